/*
 * Firing decisions for the robot rats-planar, whose file's SHA-256 begins f812ed505c1c0671.
 * Written by saltus 0.1.0; to change it, write it anew.
 * 
 * Numbers: float. CRC-32 of the tables: 16A6A542.
 * Approach rate: 2.75 to 6.25 rad/s, counted at the start lean, -0.5 rad.
 * Distance: 0.2 to 0.8 m, 13 nodes. Firing angles over 2.75 to 6.25 rad/s, 14 nodes; 129 of 156 cells are open.
 * A distance goes from the foot to where the wheel touches (landing height 0.24 m).
 * Valve open for 0.04 s.
 * Lift-off map: firing angle -0.5 to 0.49089703 rad, 11 nodes; 113 of 130 cells are open.
 * Against the planner, over all open cells (6750 jumps): what is fired lands within 0.441 mm, what the map predicts within 0.894 mm.
 * A cell that misses by more than 2.000 mm is closed.
 * Size: firing table 3068 bytes, lift-off map 12450 bytes.
 */
#ifndef SALTUS_CONTROLLER_H
#define SALTUS_CONTROLLER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifndef SALTUS_REAL
#define SALTUS_REAL float
/* Every number. Angles are leans of the leg from the upright, forward positive (rad); everything else is in SI units. */
typedef SALTUS_REAL saltus_real;
#endif

/* A value, or the reason why there is none. */
enum saltus_status {
    SALTUS_OK = 0,
    SALTUS_OUT_OF_TABLE = 1,   /* outside what the tables were made for */
    SALTUS_INFEASIBLE = 2,     /* inside, but no jump does what is asked */
    SALTUS_SENSOR_INVALID = 3, /* a number that is no measurement: NaN, infinite, beyond the horizontal */
    SALTUS_ASK_LATER = 4       /* take-off: the obstacle is too far yet; ask again at the next touch-down */
};

/* When to command the valve, counted from the reading. */
enum saltus_timing {
    SALTUS_WAIT = 0, /* not within this control period, but after `time` */
    SALTUS_FIRE = 1, /* within this control period, `time` after the reading */
    SALTUS_LATE = 2  /* the instant passed by `time` */
};

/* Lean (rad) and lean rate (rad/s) of the loaded leg. The lean is the leg's angle from the vertical, forward positive. */
typedef struct { saltus_real lean, rate; } saltus_sensed;

/* A box on the ground: from the foot to its front and back, its height, least distance of the wheel to keep (m). */
typedef struct { saltus_real front, back, height, clearance; } saltus_obstacle;

/* Firing angle (rad) and valve opening time (s) to start from. */
typedef struct { saltus_real firing_angle, valve_open; } saltus_guess;

/* Distance (m) from the foot to where the wheel's centre comes down to landing_height (m) above it; the wheel touches level ground where
 * this is its radius. */
typedef struct {
    saltus_real distance, landing_height;
    const saltus_obstacle *obstacle; /* or NULL */
    const saltus_guess *guess;       /* over an obstacle, the last decision on the same jump; or NULL */
} saltus_task;

typedef struct {
    saltus_real approach_rate; /* counted as the head of this file says (rad/s) */
    saltus_real firing_angle;  /* rad */
    saltus_real valve_open;    /* s */
    saltus_real time;          /* s */
    enum saltus_timing timing;
    int settled; /* whether the jump clears what it should; if not, the next decision may, with this one for its guess */
} saltus_decision;

/* A running robot before an obstacle. */
typedef struct {
    saltus_real distance;  /* from the next touch-down's foot to the obstacle's front (m) */
    saltus_real height;    /* of the obstacle (m), >= 0 */
    saltus_real length;    /* of the obstacle along the travel (m), > 0 */
    saltus_real speed;     /* of the axle (m/s) */
    saltus_real clearance; /* least distance to keep (m), >= 0 */
} saltus_approach;

typedef struct {
    uint32_t touch_down;       /* 0 is the next */
    saltus_real approach_rate; /* rad/s */
    saltus_real firing_angle;  /* rad */
    saltus_real distance;      /* from that touch-down's foot to the landing (m) */
    saltus_real clearance;     /* what the jump keeps (m) */
} saltus_take_off;

/* Which number of a saltus_approach there is no take-off for. */
enum saltus_input {
    SALTUS_NO_INPUT = 0,        /* none of them alone: no jump clears this obstacle */
    SALTUS_INPUT_DISTANCE = 1,
    SALTUS_INPUT_HEIGHT = 2,
    SALTUS_INPUT_LENGTH = 3,
    SALTUS_INPUT_SPEED = 4,
    SALTUS_INPUT_CLEARANCE = 5
};

/* normal . x <= bound, and slope x <= bound. */
typedef struct { saltus_real normal[2], bound; } saltus_half_plane;
typedef struct { saltus_real slope, bound; } saltus_half_line;

/* alpha_f (rad) for an approach rate (rad/s), a distance (m) and a landing height (m). For plans and tests: where rates count at the firing
 * angle it looks for the angle that has this rate, which takes tens of times as long as a look-up. saltus_decide does not need it. */
enum saltus_status saltus_firing_angle(saltus_real rate, saltus_real distance, saltus_real height, saltus_real *angle);

/* The rate (rad/s) that a robot, sensed on its foot, has at `lean` (rad), or had there. */
enum saltus_status saltus_rate_at(saltus_sensed sensed, saltus_real lean, saltus_real *rate);

/* Whether and when to open the valve now, and how long for. */
enum saltus_status saltus_decide(const saltus_sensed *sensed, const saltus_task *task, saltus_decision *decision);

/* From which of the next four touch-downs to jump, and at which angle. Where there is none, `input` (which may be NULL) says what is to blame:
 *   SALTUS_SENSOR_INVALID  the number that is no measurement
 *   SALTUS_OUT_OF_TABLE    the speed: the tables do not hold it
 *   SALTUS_ASK_LATER       the distance: the obstacle is farther than these touch-downs reach. Ask again at the next touch-down
 *   SALTUS_INFEASIBLE      the distance: the wheel would stand against the obstacle; or SALTUS_NO_INPUT: no jump clears it */
enum saltus_status saltus_choose_take_off(const saltus_approach *approach, saltus_take_off *take_off, enum saltus_input *input);

/* Minimises h x x/2 + g x. */
enum saltus_status saltus_qp1(saltus_real h, saltus_real g, const saltus_half_line *constraints, size_t count,
                              saltus_real *x);

/* Minimises x' H x/2 + g' x; h holds H11, H12, H22. At most count looks and count (count - 1)/2 cuts. */
enum saltus_status saltus_qp2(const saltus_real h[3], const saltus_real g[2], const saltus_half_plane *constraints,
                              size_t count, saltus_real x[2]);

/* Follows the lean of a pivoting wheel through an encoder's readings, `memory` from 0 to below 1, `period` in s. */
void saltus_observe(saltus_sensed *state, saltus_real lean, saltus_real period, saltus_real memory);

/* CRC-32 (IEEE 802.3) of the tables as they lie in memory, least byte first. */
uint32_t saltus_crc(void);
#define SALTUS_CRC 0x16A6A542u

#ifndef SALTUS_NO_SELF_TEST
/* 0 if the tables are whole and decisions come out, to the bit, as they did when this was written; else the number of what failed. */
int saltus_self_test(void);
#endif

#ifdef __cplusplus
}
#endif

#endif
