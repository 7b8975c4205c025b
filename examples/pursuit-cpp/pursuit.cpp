// Pure pursuit in C++: drives the circle through a point ahead on the path. Like examples/pursuit, but with the C
// interface of sdk/c/vb_planner.h and the mathematics of the C++ library, whose last bits depend on the platform.

#include "vb_planner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

VB_PLANNER_METADATA("pursuit-cpp", "1.0.0", "The Verti-Bench in Rust developers",
                    "Drives the circle through a point ahead on the global path, in C++", "0.1",
                    VB_PARAM("speed", "4.0", "target speed, m/s")
                    VB_PARAM("ahead", "6.0", "distance of the point ahead, m at full scale"));

namespace {

// A vehicle's progress along a path. It never decreases, and advances by at most `window` metres per call, so that it
// does not jump to a later section nearby.
class Follower {
public:
    Follower(const vb_point2 *points, std::size_t count, double window)
        : points_(points, points + count), window_(window) {
        if (points_.empty()) throw std::runtime_error("the global path has no points");
        arc_.push_back(0.0);
        for (std::size_t i = 1; i < points_.size(); ++i) {
            arc_.push_back(arc_.back() + std::hypot(points_[i].x - points_[i - 1].x, points_[i].y - points_[i - 1].y));
        }
    }

    // Advances to the closest point within the window.
    void update(double x, double y) {
        const double from = at_, to = std::min(at_ + window_, arc_.back());
        double best = distance(x, y, from);
        for (std::size_t i = 1; i < points_.size() && arc_[i - 1] <= to; ++i) {
            const double length = arc_[i] - arc_[i - 1];
            if (arc_[i] <= from || length == 0.0) continue;
            const vb_point2 &a = points_[i - 1], &b = points_[i];
            const double along = ((x - a.x) * (b.x - a.x) + (y - a.y) * (b.y - a.y)) / length;
            const double arc = std::clamp(arc_[i - 1] + std::clamp(along, 0.0, length), from, to);
            if (distance(x, y, arc) < best) {
                best = distance(x, y, arc);
                at_ = arc;
            }
        }
    }

    // The point `distance` metres further along the path; its end if that is nearer.
    vb_point2 look_ahead(double distance) const { return point(at_ + distance); }

private:
    vb_point2 point(double arc) const {
        const std::size_t i = std::lower_bound(arc_.begin(), arc_.end(), arc) - arc_.begin();
        if (i == 0) return points_.front();
        if (i == points_.size()) return points_.back();
        const vb_point2 &a = points_[i - 1], &b = points_[i];
        const double t = (arc - arc_[i - 1]) / (arc_[i] - arc_[i - 1]);
        return {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t};
    }

    double distance(double x, double y, double arc) const {
        const vb_point2 p = point(arc);
        return std::hypot(x - p.x, y - p.y);
    }

    std::vector<vb_point2> points_;
    std::vector<double> arc_;
    double window_;
    double at_ = 0.0;
};

double param(const vb_task *task, const char *key) {
    for (std::size_t i = 0; i < task->params_len; ++i) {
        if (std::strcmp(task->params[i].key, key) != 0) continue;
        char *end = nullptr;
        const double value = std::strtod(task->params[i].value, &end);
        if (end == task->params[i].value || *end != '\0' || !std::isfinite(value)) {
            throw std::runtime_error(std::string("parameter `") + key + "`: `" + task->params[i].value +
                                     "` is not a number");
        }
        return value;
    }
    throw std::runtime_error(std::string("parameter `") + key + "` is missing");
}

struct Pursuit {
    explicit Pursuit(const vb_task *task)
        : wheelbase(task->vehicle.wheelbase), max_steer_angle(task->vehicle.max_steer_angle),
          speed(param(task, "speed")), ahead(param(task, "ahead") * task->vehicle.scale),
          follower(task->path, task->path_len, 2.0 * ahead) {}

    void step(const vb_observation *o, vb_command *command) {
        if (o->pose == nullptr) throw std::runtime_error("there is no pose");
        const vb_pose &pose = *o->pose;
        follower.update(pose.position.x, pose.position.y);
        const vb_point2 goal = follower.look_ahead(ahead);
        const double dx = goal.x - pose.position.x, dy = goal.y - pose.position.y;
        const double angle = std::atan2(dy, dx) - pose.yaw;
        const double curvature = 2.0 * std::sin(angle) / std::max(std::hypot(dx, dy), 0.1);
        command->steering = std::clamp(std::atan(wheelbase * curvature) / max_steer_angle, -1.0, 1.0);
        // The speed controller of Verti-Bench: 1 per m/s of error.
        const double wanted = std::clamp(speed - pose.linear_velocity.x, -1.0, 1.0);
        command->throttle = std::max(wanted, 0.0);
        command->brake = std::max(-wanted, 0.0);
    }

    double wheelbase, max_steer_angle, speed, ahead;
    Follower follower;
};

// Runs planner code for the harness; exceptions must not leave the library.
template <typename Code> int32_t guarded(vb_error *error, Code code) {
    try {
        code();
        return VB_OK;
    } catch (const std::exception &e) {
        std::snprintf(error->message, sizeof error->message, "%s", e.what());
    } catch (...) {
        std::snprintf(error->message, sizeof error->message, "unknown exception");
    }
    return VB_FAILED;
}

int32_t init(const vb_task *task, const vb_host *, void **planner, vb_error *error) {
    return guarded(error, [&] { *planner = new Pursuit(task); });
}

int32_t step(void *planner, const vb_observation *observation, const vb_host *, vb_command *command, vb_error *error) {
    return guarded(error, [&] { static_cast<Pursuit *>(planner)->step(observation, command); });
}

void release(void *planner) { delete static_cast<Pursuit *>(planner); }

} // namespace

VB_PLANNER_EXPORT(init, step, release);
