@HEADER@
#ifndef SALTUS_RUNNING_H
#define SALTUS_RUNNING_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifndef SALTUS_REAL
#define SALTUS_REAL @REAL@
/* Every number. Angles are leans of a leg from the upright, positive in the direction of the run (rad); everything else is in SI units. */
typedef SALTUS_REAL saltus_real;
#endif

/* A knot of a law of lines: at `rate` (rad/s), not below that of the knot before, fire at a lean (rad), and open the valve for so long (s). */
typedef struct { saltus_real rate, firing_angle, valve_open; } saltus_knot;

enum saltus_law_kind {
    SALTUS_OVER_TIME = 0, /* alpha_f = amplitude tanh(slope t - shift) + level over the time since the start */
    SALTUS_LINES = 1,     /* lines between knots over the rate, level beyond; two knots at one rate are a jump, whose upper side holds */
    SALTUS_POLICY = 2     /* lines between evenly spaced nodes over the rate at which a leg enters the zone, level beyond */
};

/* At which lean a leg fires, and how long its valve opens. */
typedef struct {
    enum saltus_law_kind kind;
    saltus_real amplitude, slope, shift, level, valve_open; /* over time: rad, 1/s, 1, rad, s */
    const saltus_knot *knots;                               /* lines */
    saltus_real first, last, per_unit;                      /* policy: rates of the first and the last node, nodes per unit */
    const saltus_real (*nodes)[2];                          /* policy: firing angle (rad), valve opening time (s) */
    uint32_t count;                                         /* of knots or nodes */
} saltus_law;

/* What a count is. */
typedef struct {
    saltus_real wheel;              /* of the wheel's encoder (rad) */
    int32_t wheel_turn;             /* counts of it in a turn */
    saltus_real radius, pivot;      /* of the boom's encoders (rad) */
    saltus_real fine_gyro;          /* of the fine gyro (rad/s) */
    int32_t fine_limit;             /* count of it beyond which the coarse one is believed */
    saltus_real coarse_gyro;        /* of the coarse gyro (rad/s) */
    saltus_real fine_accelerometer; /* of the fine accelerometer (m/s^2) */
    int32_t accelerometer_limit;    /* count of it from which it is at its end */
} saltus_instruments;

/* How a demanded rate is held: the opening time changes with what is lacking, and with its sum. */
typedef struct {
    saltus_real by_error;              /* s for each rad/s */
    saltus_real by_sum;                /* s for each rad */
    saltus_real most_sum;              /* rad */
    saltus_real least_open, most_open; /* s; a shorter time is none */
} saltus_hold;

/* What counts as standing still: below `rate` (rad/s) for `time` (s); whether the leg in the zone may then fire once more. */
typedef struct { saltus_real rate, time; int restarts; } saltus_stall;

#define SALTUS_MOST_TAPS 16

/* How a robot runs. */
typedef struct {
    saltus_law law;
    saltus_real zone;   /* where the active zone begins (rad) */
    uint32_t legs;      /* 3 to 12; with any other number no leg ever fires */
    saltus_real period; /* of the cycle (s) */
    saltus_instruments instruments;
    const saltus_real *taps; /* weights of the rate's filter, the newest reading's first */
    uint32_t tap_count;      /* of which at most SALTUS_MOST_TAPS count */
    int holds;               /* whether a demanded rate is held */
    saltus_hold hold;
    saltus_stall stall;
} saltus_gait;

/* What counters and converters say in a cycle. */
typedef struct {
    int32_t wheel, radius, pivot;
    int32_t fine_gyro, coarse_gyro;
    int32_t fine_accelerometer[2], coarse_accelerometer[2]; /* forwards, and up at lean 0 */
} saltus_readings;

/* What a cycle decides, and from what. */
typedef struct {
    int32_t leg;              /* to fire now; -1: none */
    saltus_real valve_open;   /* for how long (s) */
    uint32_t in_zone;         /* the leg in the zone */
    saltus_real lean;         /* its lean (rad) */
    saltus_real rate;         /* filtered (rad/s), in the direction of the run */
    saltus_real firing_angle; /* that held (rad) */
    int stalled;              /* whether the robot stands still */
} saltus_action;

/* A robot that runs. Its fields are its own. */
typedef struct {
    const saltus_gait *gait;
    saltus_real past[SALTUS_MOST_TAPS];
    uint32_t newest;
    int is_read;
    uint32_t cycles, legs, leg;
    int32_t base, direction;
    saltus_real offset, pitch, entry, demand, sum;
    uint32_t still;
    int has_fired, enters;
} saltus_runner;

/* Starts a robot at rest on two legs, of which `rear` is the rear one (0 to legs - 1), with its wheel's encoder at `wheel`. `gait` lives as
 * long as the runner. If the robot has no leg `rear`, no leg ever fires. */
void saltus_runner_start(saltus_runner *runner, const saltus_gait *gait, uint32_t rear, int32_t wheel, int forwards);

/* Sets the rate to hold (rad/s), in the direction of the run. */
void saltus_runner_demand(saltus_runner *runner, saltus_real rate);

/* Runs the other way from now on: legs and leans are mirrored. */
void saltus_runner_turn_round(saltus_runner *runner, int32_t wheel);

/* A cycle: whether a leg fires now. */
void saltus_runner_step(saltus_runner *runner, const saltus_readings *readings, saltus_action *action);

/* Whether a robot can tell on which feet it stands. */
enum saltus_standing_status {
    SALTUS_STANDING_OK = 0,
    SALTUS_STANDING_ASK_LATER = 1, /* too few readings yet */
    SALTUS_STANDING_MOVING = 2,    /* the wheel turns, or something shakes it */
    SALTUS_STANDING_BETWEEN = 3,   /* gravity lies between two poses of rest, or the number of legs is not 3 to 12 */
    SALTUS_STANDING_SATURATED = 4  /* the accelerometer is at its end */
};

/* The mean of the accelerometer at rest; all 0 is without readings. */
typedef struct {
    int32_t sums[2], count;
    saltus_real fastest;
    int is_saturated;
} saltus_standing;

/* Takes a cycle's readings; beyond 250, no more. */
void saltus_standing_take(saltus_standing *standing, const saltus_instruments *instruments, const saltus_readings *readings);

/* The rear one of the two legs that stand, where gravity is `gravity` (m/s^2). */
enum saltus_standing_status saltus_rear_leg(const saltus_standing *standing, const saltus_gait *gait, saltus_real gravity, uint32_t *leg);

#ifdef __cplusplus
}
#endif

#endif
