/* The planner interface of Verti-Bench in Rust for C and C++, version 1.0.
 *
 * A planner is a shared library that exports one symbol, `vb_planner_entry`, and carries its metadata as text in the
 * section `.vb.planner`. The macros VB_PLANNER_METADATA and VB_PLANNER_EXPORT make both. docs/abi.md is the reference;
 * examples/pursuit-cpp is a whole planner.
 *
 * Rules:
 * - SI units, angles in radians. World frame: origin at the world's centre, x east, y north, z up. Body frame
 *   (ISO 8855): x forward, y left, z up.
 * - Everything that the harness hands over is read-only, and valid during the call only. Text is UTF-8 and ends with 0.
 * - All functions are called from one thread. They return VB_OK for success; anything else ends the task, with the text
 *   that they put into the error. No C++ exception may leave them.
 * - A pointer may be NULL where the description says that something may be absent, and where a length beside it is 0.
 * - The structs are those of one version of the interface: both numbers of the version must agree.
 * - The library runs in a process of its own without files, network, threads or signal handlers, with the memory that
 *   the harness's limits give it. Link what is not part of the system statically.
 */
#ifndef VB_PLANNER_H
#define VB_PLANNER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define VB_ABI_MAJOR 1
#define VB_ABI_MINOR 0

/* Room for the text of an error, with the 0 at its end. */
#define VB_ERROR_BYTES 1024

/* Levels of the lines in a task's log. */
enum {
    VB_LOG_ERROR = 0,
    VB_LOG_WARN = 1,
    VB_LOG_INFO = 2,
    VB_LOG_DEBUG = 3
};

/* What init and step return. */
enum {
    VB_OK = 0,
    /* The planner gives up. */
    VB_FAILED = 1,
    /* The planner has a defect: an exception that nobody expected, say. */
    VB_PANICKED = 2
};

/* Values of the labels in vb_task.semantics. */
enum {
    VB_CLAY = 0,
    VB_CONCRETE = 1,
    VB_DIRT = 2,
    VB_GRASS = 3,
    VB_GRAVEL = 4,
    VB_ROCK = 5,
    VB_WOOD = 6,
    VB_MUD = 7,
    VB_SAND = 8,
    VB_SNOW = 9
};

/* made: data (by cargo xtask abi, from sdk/wit; edit that instead) */

/* The gear of the vehicle, which determines the direction of travel. */
enum {
    /* A forward gear, chosen by the gearbox. */
    VB_GEAR_FORWARD = 0,
    /* The engine is uncoupled. */
    VB_GEAR_NEUTRAL = 1,
    /* The reverse gear. */
    VB_GEAR_REVERSE = 2
};

/* A vector in three dimensions. */
typedef struct vb_vec3 {
    /* The component along x. */
    double x;
    /* The component along y. */
    double y;
    /* The component along z. */
    double z;
} vb_vec3;

/* A point of the horizontal plane of the world frame. */
typedef struct vb_point2 {
    /* The coordinate towards the east, m. */
    double x;
    /* The coordinate towards the north, m. */
    double y;
} vb_point2;

/* A pose in the horizontal plane of the world frame. */
typedef struct vb_pose2 {
    /* The coordinate towards the east, m. */
    double x;
    /* The coordinate towards the north, m. */
    double y;
    /* The heading, rad, counter-clockwise from east. */
    double yaw;
} vb_pose2;

/* The vehicle of a task. */
typedef struct vb_vehicle {
    /* The name of the vehicle, e.g. hmmwv. */
    const char *name;
    /* The scale of the world, relative to the full-size original: 1, or less for smaller vehicles. */
    double scale;
    /* The mass of the whole vehicle, kg. */
    double mass;
    /* The length of the collision shape (hull and tyres), m. */
    double length;
    /* The width of the collision shape (hull and tyres with the wheels straight ahead, without mirrors), m. The
     * shape is symmetric to the centre line. */
    double width;
    /* The height of the collision shape above flat ground, m. */
    double height;
    /* The distance between the first and the last axle, m. */
    double wheelbase;
    /* The distance between the two wheels of an axle, m. */
    double track;
    /* The radius of the wheels, m. */
    double wheel_radius;
    /* The number of wheels. Wheel data are ordered from front to back, left before right. */
    uint32_t wheels;
    /* The height of the belly above flat ground, m. */
    double ground_clearance;
    /* The road-wheel angle at full lock, rad: the mean of both wheels, to the side that steers less far. */
    double max_steer_angle;
    /* The maximum rate of the steering command, 1/s. */
    double max_steer_rate;
    /* The turning radius of the reference point at full lock on flat ground, m. */
    double min_turn_radius;
    /* The track of a differential drive without slip that would turn as fast by the same speeds of the wheels, m,
     * driving at full lock; 0 for a vehicle that is not steered by the speeds of its sides. */
    double effective_track;
    /* The yaw rate at full lock without throttle at standstill, rad/s; 0 for a vehicle that can't turn in place. */
    double turn_rate_in_place;
    /* The top speed on flat ground, m/s. */
    double max_speed;
    /* The top speed in reverse on flat ground, m/s; 0 for a vehicle without a reverse gear. */
    double max_reverse_speed;
    /* The speed below which the gearbox changes between forward and reverse, m/s. */
    double direction_change_speed;
    /* The duration of this change, during which no torque reaches the wheels, s. */
    double direction_change_time;
} vb_vehicle;

/* The positions of a map's samples: sample (row, col) is at x = origin_x + col·resolution, y = origin_y +
 * row·resolution; row 0 is the southernmost. */
typedef struct vb_grid_frame {
    /* The number of rows, from south to north. */
    uint32_t rows;
    /* The number of columns, from west to east. */
    uint32_t cols;
    /* The distance between neighbouring samples, m. */
    double resolution;
    /* The x coordinate of column 0, m. */
    double origin_x;
    /* The y coordinate of row 0, m. */
    double origin_y;
} vb_grid_frame;

/* Heights on a square grid. */
typedef struct vb_height_map {
    /* The places at which the samples lie. */
    vb_grid_frame frame;
    /* The rows · cols heights of the ground in the world frame, m, row-major with row 0 in the south; NaN where the
     * height is unknown. */
    const float *data;
    size_t data_len;
} vb_height_map;

/* Labels on a square grid. */
typedef struct vb_label_map {
    /* The places at which the samples lie. */
    vb_grid_frame frame;
    /* The rows · cols labels, row-major with row 0 in the south; 255 where the label is unknown. */
    const uint8_t *data;
    size_t data_len;
} vb_label_map;

/* A parameter of a planner. */
typedef struct vb_param {
    /* The name of the parameter. */
    const char *key;
    /* The value of the parameter, as text. */
    const char *value;
} vb_param;

/* The position and attitude of a sensor on the vehicle. */
typedef struct vb_mount {
    /* The position of the sensor in the body frame, m. */
    vb_vec3 position;
    /* The roll of the sensor relative to the body, rad. */
    double roll;
    /* The pitch of the sensor relative to the body, rad, positive downwards. */
    double pitch;
    /* The yaw of the sensor relative to the body, rad, positive to the left. */
    double yaw;
} vb_mount;

/* The spinning lidar of the vehicle. */
typedef struct vb_lidar_info {
    /* The duration of a turn, which is the interval between scans, s. */
    double period;
    /* The number of beams: the rows of a scan, lowest first. */
    uint32_t rows;
    /* The number of directions per turn: the columns of a scan. Column c has the azimuth −π + (c + 1/2) · 2π / cols
     * in the sensor's frame, counter-clockwise from straight ahead. */
    uint32_t cols;
    /* The elevation angle of the lowest beam above the sensor's horizon, rad. */
    double lowest;
    /* The elevation angle of the highest beam, rad. All beams have equal angular distances. */
    double highest;
    /* The minimum measured distance, m. */
    double min_range;
    /* The maximum measured distance, m. */
    double max_range;
    /* The place of the sensor on the vehicle. */
    vb_mount mount;
} vb_lidar_info;

/* The depth camera of the vehicle, a pinhole camera with square pixels. */
typedef struct vb_depth_info {
    /* The interval between images, s. */
    double period;
    /* The number of rows of an image, from top to bottom. */
    uint32_t rows;
    /* The number of columns of an image, from left to right. */
    uint32_t cols;
    /* The angle between the left and the right edge of an image, rad. */
    double field_of_view;
    /* The minimum measured depth, m. */
    double min_depth;
    /* The maximum measured depth, m. */
    double max_depth;
    /* Whether the images have a label for each pixel. */
    uint8_t labels;
    /* The place of the sensor on the vehicle. */
    vb_mount mount;
} vb_depth_info;

/* The data for a planner at the start of a task. */
typedef struct vb_task {
    /* The name of the task within the suite, e.g. w003/t07. */
    const char *id;
    /* The vehicle. */
    vb_vehicle vehicle;
    /* The heights of the ground that the perception profile provides, m; absent if it provides none. NULL where it
     * is absent. */
    const vb_height_map *elevation;
    /* The terrain classes that the perception profile provides: 0 clay, 1 concrete, 2 dirt, 3 grass, 4 gravel, 5
     * rock, 6 wood, 7 mud, 8 sand, 9 snow; absent if it provides none. NULL where it is absent. */
    const vb_label_map *semantics;
    /* The obstacles that the perception profile provides: 1 where an obstacle covers any part of the sample's
     * square, otherwise 0; absent if it provides none. NULL where it is absent. */
    const vb_label_map *occupancy;
    /* Half of the world's extent along x and y, m. The vehicle must stay between −x and x, and between −y and y. */
    vb_point2 half_extent;
    /* The global path, from the start to the goal. */
    const vb_point2 *path;
    size_t path_len;
    /* The pose of the vehicle at the start, at rest. */
    vb_pose2 start;
    /* The goal. */
    vb_point2 goal;
    /* The maximum distance from the goal at which the task is completed, m. */
    double goal_radius;
    /* The time limit, s. */
    double time_limit;
    /* The interval between calls of step, s. */
    double control_period;
    /* The seed of the planner's randomness. It depends only on the task and the seed of the run. */
    uint64_t seed;
    /* All declared parameters of the planner, with the user's values or the defaults. */
    const vb_param *params;
    size_t params_len;
    /* The name of the perception profile, e.g. oracle. */
    const char *perception;
    /* The lidar; absent if the planner doesn't request it. NULL where it is absent. */
    const vb_lidar_info *lidar;
    /* The depth camera; absent if the planner doesn't request it. NULL where it is absent. */
    const vb_depth_info *depth;
} vb_task;

/* An estimate of the vehicle's state, with the errors of the perception profile: exact under oracle. */
typedef struct vb_pose {
    /* The position of the vehicle's reference point in the world frame, m. */
    vb_vec3 position;
    /* The roll, rad, positive with the right side down. */
    double roll;
    /* The pitch, rad, positive with the nose down. */
    double pitch;
    /* The heading, rad, counter-clockwise from east. */
    double yaw;
    /* The velocity of the reference point in body axes, m/s. */
    vb_vec3 linear_velocity;
    /* The angular velocity in body axes, rad/s. */
    vb_vec3 angular_velocity;
} vb_pose;

/* The measured state of a wheel. */
typedef struct vb_wheel {
    /* The angular velocity of the wheel about its axle, rad/s, positive when rolling forward. */
    double spin;
    /* The suspension travel from the design position, m, positive in compression. */
    double travel;
} vb_wheel;

/* A measurement of the inertial measurement unit. */
typedef struct vb_imu_sample {
    /* The simulated time of the measurement, s. */
    double time;
    /* The specific force at the vehicle's reference point in body axes, m/s²: the acceleration minus that of
     * gravity, +9.81 along z at rest. */
    vb_vec3 specific_force;
    /* The angular velocity in body axes, rad/s. */
    vb_vec3 angular_velocity;
} vb_imu_sample;

/* A GNSS position. */
typedef struct vb_gnss_fix {
    /* The simulated time of the measurement, s. */
    double time;
    /* The measured position of the vehicle's reference point in the world frame, m. */
    vb_vec3 position;
} vb_gnss_fix;

/* A turn of the lidar. */
typedef struct vb_lidar_scan {
    /* The simulated time at which the turn ended, s. Column c was measured (1 − (c + 1/2) / cols) · period before,
     * while the vehicle moved. */
    double time;
    /* The rows · cols measured distances, m, row-major; 0 without an echo. */
    const float *ranges;
    size_t ranges_len;
} vb_lidar_scan;

/* An image of the depth camera. */
typedef struct vb_depth_image {
    /* The simulated time of the image, s. */
    double time;
    /* The rows · cols depths along the camera's axis, m, row-major; 0 without a measurement. */
    const float *depths;
    size_t depths_len;
    /* The recognised terrain classes of the pixels, with the numbers of the task's semantics, 10 for an obstacle,
     * and 255 without a measurement; empty if the camera has no labels. */
    const uint8_t *labels;
    size_t labels_len;
} vb_depth_image;

/* The map of the vehicle's surroundings, built from lidar and depth camera at the estimated pose. The vehicle is in
 * its middle, and its axes are those of the world frame, up to the error of the estimate. */
typedef struct vb_local_map {
    /* The simulated time of the last update, s. */
    double time;
    /* The heights of the ground, m; NaN where they are unknown. */
    vb_height_map elevation;
    /* The terrain classes, with the numbers of the task's semantics; 255 where they are unknown. */
    vb_label_map semantics;
    /* 1 for obstacles, 0 for ground, 255 where it is unknown. */
    vb_label_map occupancy;
} vb_local_map;

/* The observation of a control period: the measurements since the previous one. A sensor is absent if the planner
 * doesn't request it, or if it has no new measurement. */
typedef struct vb_observation {
    /* The simulated time since the start, s. */
    double time;
    /* The estimate of the vehicle's state (pose). NULL where it is absent. */
    const vb_pose *pose;
    /* The wheels (wheel_odometry), from front to back, left before right. */
    const vb_wheel *wheels;
    size_t wheels_len;
    /* The measurements of the inertial measurement unit (imu), oldest first. */
    const vb_imu_sample *imu;
    size_t imu_len;
    /* The last GNSS position (gnss). NULL where it is absent. */
    const vb_gnss_fix *gnss;
    /* The last turn of the lidar (lidar). NULL where it is absent. */
    const vb_lidar_scan *lidar;
    /* The last image of the depth camera (depth). NULL where it is absent. */
    const vb_depth_image *depth;
    /* The map of the surroundings (local_map). NULL where it is absent. */
    const vb_local_map *local_map;
    /* The engaged gear; neutral during a change of direction. One of VB_GEAR_…. */
    uint32_t gear;
    /* The engine speed, rad/s. */
    double engine_speed;
    /* The present steering of the wheels, which follows the command at max_steer_rate, in [-1, 1], positive to the
     * left. */
    double steering;
    /* The steering command applied until now, after clamping; 0 at first. */
    double last_steering;
    /* The throttle command applied until now, after clamping; 0 at first. */
    double last_throttle;
    /* The brake command applied until now, after clamping; 0 at first. */
    double last_brake;
} vb_observation;

/* Numbers that the harness records with the trajectory, e.g. a sampled trajectory or a cost. */
typedef struct vb_series {
    /* The name of the series, constant over a task. */
    const char *name;
    /* The values of the series. */
    const float *values;
    size_t values_len;
} vb_series;

/* The command that holds until the next step. */
typedef struct vb_command {
    /* The steering, in [-1, 1], positive to the left. */
    double steering;
    /* The throttle, in [0, 1]. */
    double throttle;
    /* The brake, in [0, 1]. */
    double brake;
    /* The direction of travel. A change between forward and reverse waits until the vehicle is slower than
     * direction_change_speed, with the throttle closed; brake to slow down. One of VB_GEAR_…. */
    uint32_t gear;
    /* Series that are recorded with the trajectory and drawn by vb-harness replay. Leave this empty in normal runs. */
    const vb_series *debug;
    size_t debug_len;
} vb_command;

/* end of data */

/* Room for the reason of a failure. */
typedef struct vb_error {
    /* UTF-8 text that ends with 0. */
    char message[VB_ERROR_BYTES];
} vb_error;

/* What the harness offers during a call. */
typedef struct vb_host {
    /* The first argument of `log`. */
    void *context;
    /* Appends a line to the task's log; `context` is the one above. */
    void (*log)(void *context, uint32_t level, const char *message);
} vb_host;

/* The functions of a planner. VB_PLANNER_EXPORT sets the first three fields. */
typedef struct vb_planner_functions {
    /* The size of this struct, bytes. */
    size_t size;
    /* VB_ABI_MAJOR. */
    uint32_t abi_major;
    /* VB_ABI_MINOR. */
    uint32_t abi_minor;
    /* Makes a planner for a task. */
    int32_t (*init)(const vb_task *task, const vb_host *host, void **planner, vb_error *error);
    /* One step of it. The command is all zero when it is called, and what it points to must stay valid until the next call.
     * After a failure only `free` is called. */
    int32_t (*step)(void *planner, const vb_observation *observation, const vb_host *host, vb_command *command,
                    vb_error *error);
    /* Ends it; called once for every init that succeeded. */
    void (*free)(void *planner);
} vb_planner_functions;

#if defined(_WIN32)
#define VB_EXPORT __declspec(dllexport)
#else
#define VB_EXPORT __attribute__((visibility("default")))
#endif

#if defined(__APPLE__)
#define VB_SECTION __attribute__((used, section("__DATA,__vb_planner")))
#else
/* What nobody uses stays, even for a linker that is told to drop it (-Wl,--gc-sections). */
#if defined(__ELF__) && defined(__has_attribute)
#if __has_attribute(retain)
#define VB_SECTION __attribute__((used, retain, section(".vb.planner")))
#endif
#endif
#ifndef VB_SECTION
#define VB_SECTION __attribute__((used, section(".vb.planner")))
#endif
#endif

#define VB_TEXT_(x) #x
#define VB_TEXT(x) VB_TEXT_(x)

/* A parameter, for the last argument of VB_PLANNER_METADATA; write several one after the other, or "" for none. */
#define VB_PARAM(key, default_value, help) "param: " key "\ndefault: " default_value "\nhelp: " help "\n"

/* A sensor to be read, in the same argument: VB_NEED("lidar 10") for ten times a second, VB_NEED("lidar") for as often
 * as the perception profile says; pose and wheel-odometry come at every step then. A planner without any gets these two.
 * VB_NEED_WITHOUT_MAPS asks for a sensor only where the profile leaves out one of the task's maps. */
#define VB_NEED(sensor) "need: " sensor "\n"
#define VB_NEED_WITHOUT_MAPS(sensor) "need-without-maps: " sensor "\n"

/* Learned weights in the library, with their hash, in the same argument. */
#define VB_MODEL(text) "model: " text "\n"

/* The metadata, all arguments string literals without line breaks or backslashes: name (a-z, 0-9, - and _), version,
 * authors (separated by colons), one sentence about it, control period in seconds (a multiple of 0.001), parameters
 * and whatever else stands in lines of its own (VB_PARAM, VB_NEED, VB_NEED_WITHOUT_MAPS, VB_MODEL). */
#define VB_PLANNER_METADATA(name, version, authors, about, control_period, params)                              \
    VB_SECTION static const char vb_planner_metadata[] =                                                         \
        "abi: " VB_TEXT(VB_ABI_MAJOR) "." VB_TEXT(VB_ABI_MINOR) "\nname: " name "\nversion: " version            \
        "\nauthors: " authors "\nabout: " about "\ncontrol-period: " control_period "\n" params

/* The one symbol that the harness looks for. */
extern VB_EXPORT const vb_planner_functions vb_planner_entry;

/* Exports a planner of these functions; once in a library, at file level. */
#define VB_PLANNER_EXPORT(init_function, step_function, free_function)                                           \
    const vb_planner_functions vb_planner_entry = {                                                              \
        sizeof(vb_planner_functions), VB_ABI_MAJOR, VB_ABI_MINOR, init_function, step_function, free_function}

#ifdef __cplusplus
}
#endif

#endif
