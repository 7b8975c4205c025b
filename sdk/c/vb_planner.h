/* The planner interface of Verti-Bench in Rust for C and C++, version 0.1.
 *
 * A planner is a shared library that exports one symbol, `vb_planner_entry`, and carries its metadata as text in the
 * section `.vb.planner`. The macros VB_PLANNER_METADATA and VB_PLANNER_EXPORT make both. docs/abi.md is the reference;
 * examples/pursuit-cpp is a whole planner.
 *
 * Rules:
 * - SI units, angles in radians. World frame: origin at the world's centre, x east, y north, z up. Body frame
 *   (ISO 8855): x forward, y left, z up.
 * - Everything that the harness hands over is read-only, and valid during the call only. Text is UTF-8 and ends with 0.
 * - All functions are called from one thread. They return 0 for success; anything else ends the task, with the text
 *   that they put into the error. No C++ exception may leave them.
 * - Every struct that may grow begins with its size in bytes, as the side that fills it knows it. A later minor version
 *   may add fields at the end: read those only if `size` covers them. Until 1.0 both numbers of the version must agree.
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

#define VB_ABI_MAJOR 0
#define VB_ABI_MINOR 1

/* Room for the text of an error, with the 0 at its end. */
#define VB_ERROR_BYTES 1024

enum {
    VB_LOG_ERROR = 0,
    VB_LOG_WARN = 1,
    VB_LOG_INFO = 2,
    VB_LOG_DEBUG = 3
};

/* Values of vb_labels in vb_task.semantics. */
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

typedef struct vb_point2 {
    double x;
    double y;
} vb_point2;

typedef struct vb_pose2 {
    double x;
    double y;
    double yaw; /* counter-clockwise from east */
} vb_pose2;

typedef struct vb_vec3 {
    double x;
    double y;
    double z;
} vb_vec3;

/* Sample (row, col) lies at x = origin_x + col * resolution, y = origin_y + row * resolution, and is
 * data[row * cols + col]; row 0 is the southernmost. */
typedef struct vb_grid_frame {
    uint32_t rows;
    uint32_t cols;
    double resolution;
    double origin_x;
    double origin_y;
} vb_grid_frame;

typedef struct vb_heights {
    vb_grid_frame frame;
    const float *data;
} vb_heights;

typedef struct vb_labels {
    vb_grid_frame frame;
    const uint8_t *data;
} vb_labels;

typedef struct vb_param {
    const char *key;
    const char *value; /* as the user wrote it */
} vb_param;

typedef struct vb_vehicle {
    size_t size;
    const char *name;
    double scale; /* 1, 1/6 or 1/10 */
    double mass;
    double length; /* of what collides, hull and tyres; so are width and height */
    double width;  /* wheels straight ahead, without mirrors; half of it to each side of the centre line */
    double height;
    double wheelbase; /* between the first and the last axle */
    double track;
    double wheel_radius;
    uint32_t wheels; /* front to back, left before right */
    double ground_clearance;
    double max_steer_angle; /* of the road wheels at steering 1, mean of both sides */
    double max_steer_rate;  /* of the steering command, 1/s */
    double min_turn_radius;
    double max_speed;
} vb_vehicle;

typedef struct vb_task {
    size_t size;
    const char *id; /* e.g. "w003/t07" */
    const vb_vehicle *vehicle;
    vb_heights elevation;
    vb_labels semantics;
    vb_labels occupancy; /* 1 where an obstacle covers any part of the sample's square */
    const vb_point2 *path; /* the global path, start to goal */
    size_t path_len;
    vb_pose2 start;
    vb_point2 goal;
    double goal_radius;
    double time_limit;
    double control_period; /* between two calls of step */
    uint64_t seed;         /* for the planner's own randomness */
    const vb_param *params; /* every parameter of the metadata */
    size_t params_len;
} vb_task;

typedef struct vb_wheel {
    double speed;      /* rad/s, positive when rolling forward */
    double deflection; /* suspension travel, m, positive in compression */
} vb_wheel;

typedef struct vb_observation {
    size_t size;
    double time; /* simulated, since the start */
    vb_vec3 position;
    double roll;  /* positive with the right side down */
    double pitch; /* positive with the nose down */
    double yaw;
    vb_vec3 linear_velocity;  /* body axes */
    vb_vec3 angular_velocity; /* body axes */
    const vb_wheel *wheels;
    size_t wheels_len;
    double last_steering; /* the commands applied until now */
    double last_throttle;
    double last_brake;
} vb_observation;

/* Numbers that the harness records beside the trajectory. */
typedef struct vb_series {
    const char *name;
    const float *values;
    size_t values_len;
} vb_series;

/* All zero when step is called. */
typedef struct vb_command {
    size_t size;
    double steering; /* [-1, 1], positive to the left */
    double throttle; /* [0, 1] */
    double brake;    /* [0, 1] */
    const vb_series *debug; /* may be NULL; must stay valid until the next call */
    size_t debug_len;
} vb_command;

typedef struct vb_error {
    size_t size;
    char message[VB_ERROR_BYTES];
} vb_error;

/* What the harness offers during a call. */
typedef struct vb_host {
    size_t size;
    void *context;
    /* Appends a line to the task's log; `context` is the one above. */
    void (*log)(void *context, uint32_t level, const char *message);
} vb_host;

typedef struct vb_planner_functions {
    size_t size;
    uint32_t abi_major;
    uint32_t abi_minor;
    /* Makes a planner for a task. */
    int32_t (*init)(const vb_task *task, const vb_host *host, void **planner, vb_error *error);
    /* One step of it. After a failure only `free` is called. */
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
#define VB_SECTION __attribute__((used, section(".vb.planner")))
#endif

#define VB_TEXT_(x) #x
#define VB_TEXT(x) VB_TEXT_(x)

/* A parameter, for the last argument of VB_PLANNER_METADATA; write several one after the other, or "" for none. */
#define VB_PARAM(key, default_value, help) "param: " key "\ndefault: " default_value "\nhelp: " help "\n"

/* The metadata, all arguments string literals without line breaks or backslashes: name (a-z, 0-9, - and _), version,
 * authors (separated by colons), one sentence about it, control period in seconds (a multiple of 0.001), parameters. */
#define VB_PLANNER_METADATA(name, version, authors, about, control_period, params)                              \
    VB_SECTION static const char vb_planner_metadata[] =                                                         \
        "abi: " VB_TEXT(VB_ABI_MAJOR) "." VB_TEXT(VB_ABI_MINOR) "\nname: " name "\nversion: " version            \
        "\nauthors: " authors "\nabout: " about "\ncontrol-period: " control_period "\n" params

/* The one symbol that the harness looks for. */
extern VB_EXPORT const vb_planner_functions vb_planner_entry;

#define VB_PLANNER_EXPORT(init_function, step_function, free_function)                                           \
    const vb_planner_functions vb_planner_entry = {                                                              \
        sizeof(vb_planner_functions), VB_ABI_MAJOR, VB_ABI_MINOR, init_function, step_function, free_function}

#ifdef __cplusplus
}
#endif

#endif
