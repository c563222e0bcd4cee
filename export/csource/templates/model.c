/* @mark@
 *
@provenance@
 *
 * Command and angle in degrees, time in seconds. C99 with math.h; nothing is allocated, nothing is
 * read or written, and a model is plain data that may be copied:
 *
 *     static @name@_model servo;
 *     @name@_defaults(&servo);
 *     @name@_start(&servo, angle_deg, speed_deg_s);
 *     for (;;) {                              every period of the control loop
 *         if (@name@_step(&servo, command_deg, period_s) != @NAME@_OK) ...
 *         angle_deg = @name@_angle(&servo);
 *     }
 *
 * The command holds through a step. To use it from another file: define @NAME@_DECLARATIONS there
 * and include this file, which then declares what stands below and no more.
 */
#ifndef @NAME@_DECLARED
#define @NAME@_DECLARED

#include <stdbool.h>

/* Changes of the command that may be under way in a dead time at once. */
#ifndef @NAME@_DELAY_ROWS
#define @NAME@_DELAY_ROWS @rows@
#endif

enum @name@_parameter {
@indices@
    @NAME@_PARAMETERS
};

enum @name@_status {
    @NAME@_OK = 0,
    @NAME@_OUT_OF_RANGE = 1,  /* a parameter or a duration; nothing has changed */
    @NAME@_DELAY_FULL = 2,    /* more changes of the command than @NAME@_DELAY_ROWS */
    @NAME@_STEPS_RAN_OUT = 3  /* the motion needs more steps than are allowed: no value holds */
};

@structures@

typedef struct {
    @Row@ p;       /* parameters */
    @Flags@ on;    /* what is not neutral in them */
    @Acts@ acts;
    @Own@ own;
    @Pair@ steps;
    @Motion@ motion;
    @Updates@ updates;
    @Memory@ memory;  /* of the transmission */
    @Last@ last;      /* of the command's terms */
    double clock;    /* time of the end of the last step since the start [s] */
    double t;        /* the same, as the steps of the motion add up [s] */
    double command;  /* that acts now, behind the dead time */
    double newest;   /* that was given last */
    double row_time[@NAME@_DELAY_ROWS];
    double row_value[@NAME@_DELAY_ROWS];
    int first, rows;  /* the rows under way, a ring */
    bool given, shaped, begun, settled;
    double angle;
} @name@_model;

extern const char *const @name@_names[@NAME@_PARAMETERS];

/* The parameters of the model card; a start must follow. */
void @name@_defaults(@name@_model *m);

/* One parameter, also between steps: the motion goes on from where it is. */
int @name@_set(@name@_model *m, int parameter, double value);
double @name@_get(const @name@_model *m, int parameter);

/* Time zero, at an angle of the motor [deg] and a speed [deg/s]. */
void @name@_start(@name@_model *m, double angle_deg, double speed_deg_s);

/* Move on by a duration [s] under a command [deg] that holds; one of the status above. */
int @name@_step(@name@_model *m, double command_deg, double duration_s);

/* Angle of the surface [deg]; angle [deg] and speed [deg/s] of the motor. */
double @name@_angle(const @name@_model *m);
double @name@_motor_angle(const @name@_model *m);
double @name@_motor_speed(const @name@_model *m);

#endif

#ifndef @NAME@_DECLARATIONS

#include <math.h>
#include <stddef.h>

#ifndef INFINITY
#define INFINITY HUGE_VAL
#endif

@functions@
const char *const @name@_names[@NAME@_PARAMETERS] = {
@names@
};

static const double @name@_card[@NAME@_PARAMETERS] = {
@values@
};

static const double @name@_low[@NAME@_PARAMETERS] = {
@lows@
};

static const double @name@_high[@NAME@_PARAMETERS] = {
@highs@
};

/* What follows from the parameters. */
static void configure(@name@_model *m)
{
    m->on = flags(&m->p);
    m->acts = branches(&m->p, &m->on);
    m->own = motor(&m->p, &m->on, m->acts.v[0]);
    m->steps = step_lengths(m->p.v[1], m->p.v[2]);
    m->updates.f2 = m->steps.v[0];
    {
        const @Halves@ found = core_updates(m->own.v[0], m->own.v[1], m->updates.f2, m->acts.v[0]);
        m->updates.f0 = found.f0;
        m->updates.f1 = found.f1;
    }
    m->shaped = has_command_terms(&m->on);
}

/* The angle before shaft and linkage, or behind the shaft. */
static double inner_angle(const @name@_model *m)
{
    if (m->acts.v[7]) {
        return m->motion.f1.v[0];
    }
    return reducer_angle(&m->p, &m->on, m->motion.f0.v[0], &m->motion.f1);
}

void @name@_defaults(@name@_model *m)
{
    static const @Row@ none = {{0}};
    m->p = none;
    for (int i = 0; i < @NAME@_PARAMETERS; ++i) {
        m->p.v[i] = @name@_card[i];
    }
    @name@_start(m, m->p.v[4], m->p.v[5]);
}

void @name@_start(@name@_model *m, double angle_deg, double speed_deg_s)
{
    m->p.v[4] = angle_deg;
    m->p.v[5] = speed_deg_s;
    configure(m);
    m->motion.f0.v[0] = angle_deg;
    m->motion.f0.v[1] = speed_deg_s;
    m->motion.f1 = start_states(&m->p);
    m->motion.f2 = first_mode(m->acts.v[2], speed_deg_s);
    m->memory = memory_start(angle_deg);
    m->last = command_start(&m->p, &m->on, 0.0);
    for (int i = 0; i < @NAME@_DELAY_ROWS; ++i) {
        m->row_time[i] = 0.0;
        m->row_value[i] = 0.0;
    }
    m->clock = m->t = m->command = m->newest = 0.0;
    m->first = m->rows = 0;
    m->given = m->begun = m->settled = false;
    m->angle = output_chain(&m->p, &m->on, inner_angle(m), &m->memory);
}

int @name@_set(@name@_model *m, int parameter, double value)
{
    const @Acts@ before = m->acts;
    if (parameter < 0 || parameter >= @NAME@_PARAMETERS
        || !(value >= @name@_low[parameter] && value <= @name@_high[parameter])) {
        return @NAME@_OUT_OF_RANGE;
    }
    m->p.v[parameter] = value;
    configure(m);
    if (m->acts.v[2] != before.v[2]) {
        m->motion.f2 = first_mode(m->acts.v[2], m->motion.f0.v[1]);
    }
    if (m->acts.v[4] != before.v[4] || m->acts.v[7] != before.v[7]) {
        @Row@ here = m->p;
        here.v[4] = m->motion.f0.v[0];
        here.v[5] = m->motion.f0.v[1];
        m->motion.f1 = start_states(&here);
    }
    if (m->acts.v[3] && !before.v[3]) {
        m->memory = memory_start(inner_angle(m));
    }
    if (!m->shaped) {
        m->begun = false;
    }
    return @NAME@_OK;
}

double @name@_get(const @name@_model *m, int parameter)
{
    return parameter < 0 || parameter >= @NAME@_PARAMETERS ? NAN : m->p.v[parameter];
}

/* Times from now on, so that long runs lose no digits. */
static void rebase(@name@_model *m)
{
    for (int i = 0; i < @NAME@_DELAY_ROWS; ++i) {
        m->row_time[i] -= m->clock;
    }
    m->t -= m->clock;
    m->clock = 0.0;
}

/* Note a command that begins now. */
static int give(@name@_model *m, double command)
{
    if (!m->given) {
        m->given = true;
        m->command = m->newest = command;
    } else if (command != m->newest) {
        const int at = (m->first + m->rows) % @NAME@_DELAY_ROWS;
        if (m->rows == @NAME@_DELAY_ROWS) {
            return @NAME@_DELAY_FULL;
        }
        m->row_time[at] = m->clock;
        m->row_value[at] = command;
        m->newest = command;
        ++m->rows;
    }
    return @NAME@_OK;
}

/* One straight piece of the command, which ends at `end` [s] at the latest. */
static bool advance(@name@_model *m, double shift, double end, long *budget)
{
    const double tiny = @TINY@;
    double horizon;
    @Chain@ shaped;
    @Pair@ line = {{0}}, span = {{0}};
    @Answer@ found;
    while (m->rows > 0 && m->row_time[m->first] + shift - m->t <= tiny) {
        m->command = m->row_value[m->first];
        m->first = (m->first + 1) % @NAME@_DELAY_ROWS;
        --m->rows;
    }
    horizon = end - m->t;
    if (m->rows > 0) {
        horizon = fmin(horizon, m->row_time[m->first] + shift - m->t);
    }
    line.v[0] = m->command;
    if (m->shaped) {
        if (!m->begun) {
            m->last = command_start(&m->p, &m->on, m->command);
            m->begun = true;
        }
        shaped = command_chain(&m->p, &m->on, m->command, 0.0, horizon, &m->last);
        line.v[0] = shaped.f0;
        line.v[1] = shaped.f1;
        horizon = fmin(horizon, shaped.f2);
    }
    line.v[0] = m->p.v[0] * line.v[0] + m->p.v[3];
    line.v[1] = m->p.v[0] * line.v[1];
    if (!m->settled) {
        m->motion.f1 = settled(&m->p, &m->on, &m->motion.f0, &m->motion.f1, line.v[0]);
        m->settled = true;
    }
    span.v[0] = m->t;
    span.v[1] = fmax(horizon, 2.0 * tiny);
    found = piece(&m->p, &m->on, &m->acts, &m->own, &m->steps, &m->motion, &m->updates, &m->memory,
                  &line, &span, &end, 1, 0, false, &m->angle, *budget - 1);
    m->motion = found.f0;
    m->updates = found.f1;
    m->memory = found.f2;
    *budget = found.f5;
    if (m->shaped) {
        m->last = command_end(&shaped.f3, &shaped.f4, found.f3);
    }
    m->t += found.f3;
    return *budget >= 0;
}

int @name@_step(@name@_model *m, double command_deg, double duration_s)
{
    const double shift = latency(&m->p, &m->on);
    double end;
    long budget;
    int status;
    if (!(duration_s > 0.0 && duration_s <= 1e6) || !(fabs(command_deg) <= 1e9)) {
        return @NAME@_OUT_OF_RANGE;
    }
    if (m->clock > 1000.0) {
        rebase(m);
    }
    status = give(m, command_deg);
    if (status != @NAME@_OK) {
        return status;
    }
    end = m->clock + duration_s;
    budget = 100000 + (long)fmin(20.0 * duration_s / m->steps.v[0], 1e9);
    while (end - m->t > @TINY@) {
        if (!advance(m, shift, end, &budget)) {
            return @NAME@_STEPS_RAN_OUT;
        }
    }
    m->clock = end;
    return @NAME@_OK;
}

double @name@_angle(const @name@_model *m)
{
    return m->angle;
}

double @name@_motor_angle(const @name@_model *m)
{
    return m->motion.f0.v[0];
}

double @name@_motor_speed(const @name@_model *m)
{
    return m->motion.f0.v[1];
}

#endif
