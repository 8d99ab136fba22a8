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
    SALTUS_LINES = 1      /* lines between knots over the rate, level beyond; two knots at one rate are a jump, whose upper side holds */
};

/* At which lean a leg fires, and how long its valve opens. */
typedef struct {
    enum saltus_law_kind kind;
    saltus_real amplitude, slope, shift, level, valve_open; /* over time: rad, 1/s, 1, rad, s */
    const saltus_knot *knots;                               /* lines */
    uint32_t count;                                         /* of knots */
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

/* A jump out of a run: a firing whose angle follows from the rate at the touch-down of its leg, alpha_f = slope rate + level. It is measured
 * once the filter has forgotten the shock; until then it is the rate now. No saltus_hold changes that angle. */
typedef struct {
    uint32_t after;          /* firings before it */
    saltus_real slope;       /* s */
    saltus_real level;       /* rad */
    saltus_real least, most; /* firing angles (rad) */
    saltus_real valve_open;  /* s */
    int32_t shock;           /* greater component of the coarse accelerometer's reading from which a foot has come down; 0 or less: never */
} saltus_leap;

/* What each leg does before an obstacle: a table over the rate at which it enters the zone, the height of the axle and the distance from the axle
 * to the obstacle's front then. The height tells when the foot will come down. A range sensor gives the distance now and then (saltus_runner_sense); in between the encoder of the radius carries it on. Beyond
 * the last distance the law holds. Before the first one the obstacle is behind, and the next one counts. */
typedef struct {
    saltus_real way;          /* forwards for a count of the radius encoder (m); negative if it counts backwards */
    saltus_real climb;        /* height for a count of the pivot encoder (m); negative if it counts downwards */
    saltus_real least_weight; /* of a reading of the range sensor in the distance; the mean of the first readings weighs each alike */
    saltus_real same;         /* by how much a reading may differ from the distance (m); farther off, it is another obstacle's */
    saltus_real room;         /* nearer than this (m), a robot at rest first runs the other way until it is so far, and comes to stand; 0 and */
                              /* where a speed is held: never */
    saltus_real rate_first, rate_last, rates_per_unit; /* ends of the cells of the rate (rad/s); beyond, the first and the last cell hold */
    uint32_t rate_count;                               /* of these ends */
    saltus_real height_first, height_last, heights_per_unit; /* ends of the cells of the axle's height above that of the first cycle (m) */
    uint32_t height_count;                                   /* of these ends; beyond, the first and the last cell hold */
    saltus_real distance_first, distance_last, distances_per_unit; /* ends of the cells of the distance (m) */
    uint32_t distance_count;                                       /* of these ends */
    const uint8_t *cells; /* what is done in each cell, all distances of a height one after the other, all heights of a rate: which choice */
    uint32_t cell_count;
    const saltus_real (*choices)[2]; /* firing angle (rad), valve opening time (s); with a time of 0 the leg does not fire */
    uint32_t choice_count;
    uint8_t first_leap; /* from this choice on a firing jumps over the obstacle: no leg fires until that is behind */
} saltus_ahead;

/* How a demanded speed is held: a law of lines is then one over the demanded speed (m/s), and the firing angle is trimmed by what is lacking,
 * down to the beginning of the zone. A leg that fires sooner drives faster. Where no speed is demanded, no leg fires. */
typedef struct {
    saltus_real way;      /* forwards for a count of the radius encoder (m); negative if it counts backwards */
    saltus_real renewed;  /* part of the measured speed that a cycle renews: the period over the time of its mean */
    saltus_real ahead;    /* most by which the speed that is asked of the law is above the measured one (m/s) */
    saltus_real by_error; /* by how much sooner a leg fires (rad) for each m/s that is lacking now */
    saltus_real by_sum;   /* the same for each metre that has been lacking */
    saltus_real most_sum; /* most that counts as having been lacking (m), either way */
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
    int holds;               /* whether a demanded speed is held */
    saltus_hold hold;
    saltus_stall stall;
    const saltus_real (*first)[2]; /* firing angle (rad), valve opening time (s) of the first firings, before the law; again after a turn, and */
    uint32_t first_count;          /* after a stall if that restarts */
    int leaps;                     /* whether it leaps out of the run; not where `first` says that firing */
    saltus_leap leap;
    const saltus_ahead *ahead; /* what is done about an obstacle that is sensed; NULL: nothing */
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
    saltus_real offset, pitch, demand, sum, speed, touched;
    int32_t last_radius;
    uint32_t still, firings, since_shock;
    int has_fired, enters, is_measured, is_touched;
    saltus_real distance, reading, choice[2];
    int32_t readings, seen_radius;
    int32_t stands_at;
    int is_seen, is_read_now, is_counted, has_choice, choice_leaps, is_leaping, backs_off, is_standing_known;
} saltus_runner;

/* Starts a robot at rest on two legs, of which `rear` is the rear one (0 to legs - 1), with its wheel's encoder at `wheel`. `gait` lives as
 * long as the runner. If the robot has no leg `rear`, no leg ever fires. */
void saltus_runner_start(saltus_runner *runner, const saltus_gait *gait, uint32_t rear, int32_t wheel, int forwards);

/* Sets the speed to hold (m/s), positive forwards and negative backwards, however the robot was started; 0, or what is not a number, lets no
 * leg fire. With a speed opposite to that of the run no leg fires until the robot stands still, which turns it round. If the gait holds no
 * speed, a demand means nothing. */
void saltus_runner_demand(saltus_runner *runner, saltus_real speed);

/* What the range sensor says before the next step: the distance (m) from the axle to the front of the next obstacle, in the direction of the
 * run. What is not a positive number is no reading. If the gait has no table for what is ahead, it means nothing. */
void saltus_runner_sense(saltus_runner *runner, saltus_real distance);

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
