#include "following.h"

#include <math.h>
#include <stdlib.h>

static const double PI = 3.14159265358979323846;

bool path_new(path_t *path, size_t count) {
  path->count = count;
  path->points = calloc(count, sizeof *path->points);
  path->arc = calloc(count, sizeof *path->arc);
  if (path->points != NULL && path->arc != NULL) return true;
  path_free(path);
  return false;
}

void path_measure(path_t *path) {
  for (size_t i = 1; i < path->count; i++) {
    point_t a = path->points[i - 1], b = path->points[i];
    path->arc[i] = path->arc[i - 1] + hypot(b.x - a.x, b.y - a.y);
  }
}

void path_free(path_t *path) {
  free(path->points);
  free(path->arc);
  *path = (path_t){0};
}

// Index of the first point at or past `arc`; past it only, if `past` holds.
static size_t first_index(const path_t *path, double arc, bool past) {
  size_t low = 0, high = path->count;
  while (low < high) {
    size_t middle = low + (high - low) / 2;
    double a = path->arc[middle];
    if (past ? a > arc : a >= arc) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return low;
}

point_t path_point_at(const path_t *path, double arc) {
  size_t i = first_index(path, arc, false);
  if (i == 0) return path->points[0];
  if (i == path->count) return path->points[i - 1];
  point_t a = path->points[i - 1], b = path->points[i];
  double t = (arc - path->arc[i - 1]) / (path->arc[i] - path->arc[i - 1]);
  return (point_t){a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t};
}

double path_closest_between(const path_t *path, double x, double y, double start, double end) {
  double whole = path->arc[path->count - 1];
  start = clamp(start, 0.0, whole);
  end = clamp(end, start, whole);
  point_t p = path_point_at(path, start);
  double best = start, nearest = hypot(x - p.x, y - p.y);
  size_t i = first_index(path, start, true);
  for (i = i > 1 ? i : 1; i < path->count && path->arc[i - 1] <= end; i++) {
    double length = path->arc[i] - path->arc[i - 1];
    if (length == 0.0) continue;
    point_t a = path->points[i - 1], b = path->points[i];
    double along = ((x - a.x) * (b.x - a.x) + (y - a.y) * (b.y - a.y)) / length;
    double arc = clamp(path->arc[i - 1] + clamp(along, 0.0, length), start, end);
    p = path_point_at(path, arc);
    double distance = hypot(x - p.x, y - p.y);
    if (distance < nearest) {
      best = arc;
      nearest = distance;
    }
  }
  return best;
}

double clamp(double value, double low, double high) {
  return value < low ? low : value > high ? high : value;
}

double turn(double start, double end) {
  double a = fmod(end - start + PI, 2.0 * PI);
  if (a < 0.0) a += 2.0 * PI;
  // A tiny negative remainder plus 2 pi may round to 2 pi, the excluded end of the interval.
  return a >= 2.0 * PI ? -PI : a - PI;
}

void throttle_and_brake(double target, double speed, double *throttle, double *brake) {
  double u = clamp(target - speed, -1.0, 1.0);
  *throttle = u >= 0.0 ? u : 0.0;
  *brake = u >= 0.0 ? 0.0 : -u;
}
