// Pure pursuit: drive the circle that goes through a point ahead on the path.

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "following.h"
#include "gen/planner_plugin.h"

// The state of a planner for one task. The generated header declares the type, the planner defines it.
struct exports_vertibench_planner_guest_planner_t {
  path_t path;
  double arc; // progress along the path, m
  double wheelbase, max_steer_angle;
  double speed, ahead;
};
typedef exports_vertibench_planner_guest_planner_t planner_t;

// A parameter as a finite number; the harness gives every parameter that planner.yaml declares.
static bool number(const vertibench_planner_types_list_param_t *params, const char *key, double *value) {
  for (size_t i = 0; i < params->len; i++) {
    const vertibench_planner_types_param_t *param = &params->ptr[i];
    if (param->key.len != strlen(key) || memcmp(param->key.ptr, key, param->key.len) != 0) continue;
    // Texts of the interface have a length and no terminator.
    char text[64] = {0};
    if (param->value.len == 0 || param->value.len >= sizeof text) return false;
    memcpy(text, param->value.ptr, param->value.len);
    char *end;
    *value = strtod(text, &end);
    return *end == '\0' && isfinite(*value);
  }
  return false;
}

// Initialises a planner from the task, or returns the reason of a failure.
static const char *fill(planner_t *planner, const exports_vertibench_planner_guest_task_t *task) {
  if (!number(&task->params, "speed", &planner->speed)) return "parameter speed must be a number";
  if (!number(&task->params, "ahead", &planner->ahead)) return "parameter ahead must be a number";
  planner->ahead *= task->vehicle.scale;
  planner->wheelbase = task->vehicle.wheelbase;
  planner->max_steer_angle = task->vehicle.max_steer_angle;
  if (task->path.len == 0) return "the global path has no points";
  if (!path_new(&planner->path, task->path.len)) return "no memory for the global path";
  for (size_t i = 0; i < task->path.len; i++) {
    planner->path.points[i] = (point_t){task->path.ptr[i].x, task->path.ptr[i].y};
  }
  path_measure(&planner->path);
  return NULL;
}

// Called once per task. The planner must free the arguments; the generated code frees the returned values.
bool exports_vertibench_planner_guest_static_planner_init(
    exports_vertibench_planner_guest_task_t *task, exports_vertibench_planner_guest_own_planner_t *ret,
    planner_plugin_string_t *err) {
  planner_t *planner = calloc(1, sizeof *planner);
  const char *problem = planner == NULL ? "no memory" : fill(planner, task);
  exports_vertibench_planner_guest_task_free(task);
  if (problem != NULL) {
    if (planner != NULL) exports_vertibench_planner_guest_planner_destructor(planner);
    planner_plugin_string_dup(err, problem);
    return false;
  }
  *ret = exports_vertibench_planner_guest_planner_new(planner);
  return true;
}

// Called every control period.
bool exports_vertibench_planner_guest_method_planner_step(
    exports_vertibench_planner_guest_borrow_planner_t self, exports_vertibench_planner_guest_observation_t *o,
    exports_vertibench_planner_guest_command_t *ret, planner_plugin_string_t *err) {
  planner_t *planner = self;
  if (!o->pose.is_some) {
    exports_vertibench_planner_guest_observation_free(o);
    planner_plugin_string_dup(err, "there is no pose");
    return false;
  }
  double x = o->pose.val.position.x, y = o->pose.val.position.y;
  double yaw = o->pose.val.yaw, speed = o->pose.val.linear_velocity.x;
  // Rejects implausible numbers. Comparisons with NaN are false, so NaN is rejected, too.
  if (!(fabs(x) < 1e9 && fabs(y) < 1e9 && fabs(yaw) < 1e9 && fabs(speed) < 1e9)) {
    exports_vertibench_planner_guest_observation_free(o);
    planner_plugin_string_dup(err, "invalid position, heading or speed");
    return false;
  }
  // Progress never decreases, and advances by at most a window: it cannot jump to a later section nearby.
  double window = 2.0 * planner->ahead;
  planner->arc = path_closest_between(&planner->path, x, y, planner->arc, planner->arc + window);
  point_t goal = path_point_at(&planner->path, planner->arc + planner->ahead);
  double dx = goal.x - x, dy = goal.y - y;
  double angle = turn(yaw, atan2(dy, dx));
  double distance = hypot(dx, dy);
  double curvature = 2.0 * sin(angle) / (distance > 0.1 ? distance : 0.1);
  double steering = atan(planner->wheelbase * curvature) / planner->max_steer_angle;
  *ret = (exports_vertibench_planner_guest_command_t){.steering = clamp(steering, -1.0, 1.0)};
  throttle_and_brake(planner->speed, speed, &ret->throttle, &ret->brake);
  exports_vertibench_planner_guest_observation_free(o);
  return true;
}

// Called when the task ends.
void exports_vertibench_planner_guest_planner_destructor(planner_t *planner) {
  path_free(&planner->path);
  free(planner);
}
