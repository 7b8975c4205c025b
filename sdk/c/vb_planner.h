/* The planner interface of Verti-Bench in Rust for C and C++, version 1.0.
 *
 * A planner is a shared library that exports one symbol, `vb_planner_entry`, and contains its metadata as text in the
 * section `.vb.planner`. The macros VB_PLANNER_METADATA and VB_PLANNER_EXPORT generate both. docs/abi.md is the
 * reference; examples/pursuit-cpp is a complete planner.
 *
 * Rules:
 * - SI units, angles in radians. World frame: origin at the world's centre, x east, y north, z up. Body frame
 *   (ISO 8855): x forward, y left, z up.
 * - Data from the harness are read-only, and valid only during the call. Text is UTF-8 and ends with 0.
 * - All functions are called from one thread. They return VB_OK on success; other values end the task, with the text in
 *   the error. C++ exceptions must not leave them.
 * - Pointers to optional data, and pointers with a length of 0, may be NULL.
 * - The structs apply to one version of the interface: major and minor version must match.
 * - The library runs in a separate process without files, network, threads or signal handlers, within the memory limit
 *   of the harness. Link libraries that are not part of the system statically.
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

/* Size of an error text, including the 0 at its end. */
#define VB_ERROR_BYTES 1024

/* Levels of the lines in a task's log. */
enum {
    VB_LOG_ERROR = 0,
    VB_LOG_WARN = 1,
    VB_LOG_INFO = 2,
    VB_LOG_DEBUG = 3
};

/* Return values of init and step. */
enum {
    VB_OK = 0,
    /* The planner aborts the task. */
    VB_FAILED = 1,
    /* The planner has a defect, e.g. an unexpected exception. */
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
    /* The track of a slip-free differential drive with the same yaw rate at the same wheel speeds, at full lock, m;
     * 0 for a vehicle without skid steering. */
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
    /* The positions of the samples. */
    vb_grid_frame frame;
    /* The rows · cols heights of the terrain in the world frame, m, row-major with row 0 in the south; NaN where
     * the height is unknown. */
    const float *data;
    size_t data_len;
} vb_height_map;

/* Labels on a square grid. */
typedef struct vb_label_map {
    /* The positions of the samples. */
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
    /* The duration of a scan, which is one revolution, s. */
    double period;
    /* The number of beams: the rows of a scan, lowest first. */
    uint32_t rows;
    /* The number of directions per revolution: the columns of a scan. Column c has the azimuth −π + (c + 1/2) · 2π
     * / cols in the sensor's frame, counter-clockwise from straight ahead. */
    uint32_t cols;
    /* The elevation angle of the lowest beam above the sensor's horizon, rad. */
    double lowest;
    /* The elevation angle of the highest beam, rad. All beams have equal angular distances. */
    double highest;
    /* The minimum measured distance, m. */
    double min_range;
    /* The maximum measured distance, m. */
    double max_range;
    /* The pose of the sensor on the vehicle. */
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
    /* The pose of the sensor on the vehicle. */
    vb_mount mount;
} vb_depth_info;

/* The data for a planner at the start of a task. */
typedef struct vb_task {
    /* The name of the task within the suite, e.g. w003/t07. */
    const char *id;
    /* The vehicle. */
    vb_vehicle vehicle;
    /* The terrain heights that the perception profile provides, m; absent if it provides none. NULL where it is
     * absent. */
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

/* A scan of the lidar: one revolution. */
typedef struct vb_lidar_scan {
    /* The simulated time at the end of the scan, s. Column c was measured (1 − (c + 1/2) / cols) · period before,
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

/* The local map, built from lidar and depth camera at the estimated pose. The vehicle is at its centre, and its
 * axes are those of the world frame, up to the error of the estimate. */
typedef struct vb_local_map {
    /* The simulated time of the last update, s. */
    double time;
    /* The terrain heights, m; NaN for unknown cells. */
    vb_height_map elevation;
    /* The terrain classes, with the numbers of the task's semantics; 255 for unknown cells. */
    vb_label_map semantics;
    /* 1 for obstacles, 0 for free cells, 255 for unknown cells. */
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
    /* The last scan of the lidar (lidar). NULL where it is absent. */
    const vb_lidar_scan *lidar;
    /* The last image of the depth camera (depth). NULL where it is absent. */
    const vb_depth_image *depth;
    /* The local map (local_map). NULL where it is absent. */
    const vb_local_map *local_map;
    /* The engaged gear; neutral during a change of direction. One of VB_GEAR_…. */
    uint32_t gear;
    /* The engine speed, rad/s. */
    double engine_speed;
    /* The current wheel steering, which follows the command at max_steer_rate, in [-1, 1], positive to the left. */
    double steering;
    /* The steering command applied until now, after clamping; 0 at first. */
    double last_steering;
    /* The throttle command applied until now, after clamping; 0 at first. */
    double last_throttle;
    /* The brake command applied until now, after clamping; 0 at first. */
    double last_brake;
} vb_observation;

/* Numbers that the harness records with the trajectory, e.g. rollouts or costs. */
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

/* The functions of the harness during a call. */
typedef struct vb_host {
    /* The first argument of `log`. */
    void *context;
    /* Appends a line to the task's log; pass the `context` above. */
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
    /* Creates a planner for a task. */
    int32_t (*init)(const vb_task *task, const vb_host *host, void **planner, vb_error *error);
    /* Runs one step. The command is all zero on entry, and its pointers must stay valid until the next call. After a
     * failure only `free` is called. */
    int32_t (*step)(void *planner, const vb_observation *observation, const vb_host *host, vb_command *command,
                    vb_error *error);
    /* Frees the planner; called once for every successful init. */
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
/* The section is kept although it is unused, also with -Wl,--gc-sections. */
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

/* A parameter, for the last argument of VB_PLANNER_METADATA; concatenate several, or pass "" for none. */
#define VB_PARAM(key, default_value, help) "param: " key "\ndefault: " default_value "\nhelp: " help "\n"

/* A requested sensor, in the same argument: VB_NEED("lidar 10") for 10 Hz, VB_NEED("lidar") for the rate of the
 * perception profile, which for pose and wheel-odometry is every step. A planner without VB_NEED gets these two.
 * VB_NEED_WITHOUT_MAPS requests a sensor only for tasks in which the profile omits a map. */
#define VB_NEED(sensor) "need: " sensor "\n"
#define VB_NEED_WITHOUT_MAPS(sensor) "need-without-maps: " sensor "\n"

/* Learned weights embedded in the library, with their hash, in the same argument. */
#define VB_MODEL(text) "model: " text "\n"

/* The metadata. All arguments are string literals without line breaks or backslashes: name (a-z, 0-9, - and _), version,
 * authors (separated by colons), one-sentence description, control period in seconds (a multiple of 0.001), and the
 * concatenated parameters, sensors and models (VB_PARAM, VB_NEED, VB_NEED_WITHOUT_MAPS, VB_MODEL). */
#define VB_PLANNER_METADATA(name, version, authors, about, control_period, params)                              \
    VB_SECTION static const char vb_planner_metadata[] =                                                         \
        "abi: " VB_TEXT(VB_ABI_MAJOR) "." VB_TEXT(VB_ABI_MINOR) "\nname: " name "\nversion: " version            \
        "\nauthors: " authors "\nabout: " about "\ncontrol-period: " control_period "\n" params

/* The symbol that the harness loads. */
extern VB_EXPORT const vb_planner_functions vb_planner_entry;

/* Exports a planner of these functions; once in a library, at file level. */
#define VB_PLANNER_EXPORT(init_function, step_function, free_function)                                           \
    const vb_planner_functions vb_planner_entry = {                                                              \
        sizeof(vb_planner_functions), VB_ABI_MAJOR, VB_ABI_MINOR, init_function, step_function, free_function}

#ifdef __cplusplus
}
#endif

#endif
