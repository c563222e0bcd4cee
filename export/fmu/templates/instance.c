/* What both versions of FMI share: an instance of the model, its variables and its state.
 *
 * Value references: the parameters in the order of the model, then those of enum variable.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model.c"

#define TOKEN "@token@"

enum variable {
    COMMAND = @NAME@_PARAMETERS,
    ANGLE,
    MOTOR_ANGLE,
    MOTOR_SPEED,
    DER_MOTOR_ANGLE,
    DER_MOTOR_SPEED,
    TIME = @time@
};

enum phase { SETTING_UP, RUNNING, ENDED };

typedef struct {
    @name@_model model;
    double command;
    double time;
    int phase;
    int continuous; /* true for model exchange */
} state;

typedef struct {
    state now;
    void *environment;
    void *logger;
    int logging;
} instance;

static instance *new_instance(int continuous)
{
    instance *me = calloc(1, sizeof *me);
    if (me != NULL) {
        @name@_defaults(&me->now.model);
        me->now.continuous = continuous;
    }
    return me;
}

static void reset_instance(instance *me)
{
    const int continuous = me->now.continuous;
    memset(&me->now, 0, sizeof me->now);
    @name@_defaults(&me->now.model);
    me->now.continuous = continuous;
}

/* The linear core under the command; described where the model is no more than that core. */
static double acceleration(const state *now)
{
    const double *p = now->model.p.v;
    const double *x = now->model.motion.f0.v;
    return (p[0] * now->command + p[3] - x[0] - 2.0 * p[2] * p[1] * x[1]) / (p[1] * p[1]);
}

static int get_number(const instance *me, unsigned reference, double *value)
{
    const state *now = &me->now;
    switch (reference) {
    case COMMAND: *value = now->command; return 1;
    case ANGLE:
        *value = now->continuous ? @name@_motor_angle(&now->model) : @name@_angle(&now->model);
        return 1;
    case MOTOR_ANGLE: *value = @name@_motor_angle(&now->model); return 1;
    case MOTOR_SPEED: *value = @name@_motor_speed(&now->model); return 1;
    case DER_MOTOR_ANGLE: *value = @name@_motor_speed(&now->model); return @exchange@;
    case DER_MOTOR_SPEED: *value = acceleration(now); return @exchange@;
    case TIME: *value = now->time; return 1;
    default: break;
    }
    if (reference >= @NAME@_PARAMETERS) {
        return 0;
    }
    *value = @name@_get(&now->model, (int)reference);
    return 1;
}

/* A parameter until the start and between steps; the initial state until the start alone. */
static int set_number(instance *me, unsigned reference, double value)
{
    state *now = &me->now;
    if (reference == COMMAND) {
        if (!(fabs(value) <= 1e9)) {
            return 0;
        }
        now->command = value;
        return 1;
    }
    if (now->continuous && now->phase == RUNNING
        && (reference == MOTOR_ANGLE || reference == MOTOR_SPEED)) {
        now->model.motion.f0.v[reference - MOTOR_ANGLE] = value;
        return 1;
    }
    if (reference >= @NAME@_PARAMETERS) {
        return 0;
    }
    if (now->phase == RUNNING && (reference == 4 || reference == 5)) {
        return 0;
    }
    if (@name@_set(&now->model, (int)reference, value) != @NAME@_OK) {
        return 0;
    }
    if (now->phase == SETTING_UP) {
        @name@_start(&now->model, now->model.p.v[4], now->model.p.v[5]);
    }
    return 1;
}

static const char *step_error(int status)
{
    switch (status) {
    case @NAME@_OUT_OF_RANGE: return "the step size is not above zero, or not finite";
    case @NAME@_DELAY_FULL: return "more changes of the command in the dead time than fit";
    default: return "the motion needs more steps than are allowed";
    }
}
