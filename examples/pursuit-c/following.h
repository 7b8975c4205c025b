// Following a path, and holding a speed: the same formulas in the same order as in the Rust SDK (`path`, `speed`,
// `math::turn`), so that a planner in either language gives the same commands.
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

// A path of `count` > 0 points, all zero; false if there is no memory for it. Fill `points`, then call path_measure.
bool path_new(path_t *path, size_t count);
// Computes the arc lengths.
void path_measure(path_t *path);
void path_free(path_t *path);
// The point at an arc length; before the start and past the end it is the start and the end.
point_t path_point_at(const path_t *path, double arc);
// Arc length of the point closest to (x, y) among those from arc length `start` to `end`.
double path_closest_between(const path_t *path, double x, double y, double start, double end);

// The closest number in [low, high].
double clamp(double value, double low, double high);
// The turn from direction `start` to direction `end`, rad in [-pi, pi), positive to the left.
double turn(double start, double end);
// Throttle and brake, each in [0, 1], in proportion to what is missing of the target speed (m/s).
void throttle_and_brake(double target, double speed, double *throttle, double *brake);

#endif
