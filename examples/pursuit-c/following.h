// Path following and speed control: the same formulas in the same order as in the Rust SDK (`path`, `speed`,
// `math::turn`), so that commands are identical in both languages.
#ifndef FOLLOWING_H
#define FOLLOWING_H

#include <stdbool.h>
#include <stddef.h>

typedef struct {
  double x, y; // m
} point_t;

// A polyline, measured by arc length from its start.
typedef struct {
  point_t *points;
  double *arc; // arc length at each point, m
  size_t count;
} path_t;

// A path of `count` > 0 points, all zero; false without memory. Fill `points`, then call path_measure.
bool path_new(path_t *path, size_t count);
// Computes the arc lengths.
void path_measure(path_t *path);
void path_free(path_t *path);
// The point at an arc length, clamped to the start and the end.
point_t path_point_at(const path_t *path, double arc);
// Arc length of the point closest to (x, y) among those from arc length `start` to `end`.
double path_closest_between(const path_t *path, double x, double y, double start, double end);

// Clamps a number to [low, high].
double clamp(double value, double low, double high);
// The turn from direction `start` to direction `end`, rad in [-pi, pi), positive to the left.
double turn(double start, double end);
// Throttle and brake, each in [0, 1], proportional to the speed error (m/s).
void throttle_and_brake(double target, double speed, double *throttle, double *brake);

#endif
