/* A planner that does its work, beside those that do harm: a part of what it had, and the time. */
#include <stdlib.h>

#include "vb_planner.h"

VB_PLANNER_METADATA("steady", "1.0.0", "A", "Does its work", "0.1", "");

struct planner {
    double sum;
    double calls;
};

static int32_t init(const vb_task *task, const vb_host *host, void **planner, vb_error *error) {
    *planner = calloc(1, sizeof(struct planner));
    return *planner ? 0 : 1;
}

static int32_t step(void *planner, const vb_observation *o, const vb_host *host, vb_command *command, vb_error *error) {
    struct planner *p = planner;
    p->sum = p->sum * PART + o->time;
    p->calls += 1;
    host->log(host->context, VB_LOG_INFO, "hello log");
    command->steering = p->sum;
    command->throttle = p->calls;
    return 0;
}

static void release(void *planner) { free(planner); }

VB_PLANNER_EXPORT(init, step, release);
