@HEADER@
#ifndef SALTUS_BALL_H
#define SALTUS_BALL_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifndef SALTUS_REAL
#define SALTUS_REAL @REAL@
/* Every number, in SI units and radians. Axes of the world: x along the first heading, y to its left, z up. */
typedef SALTUS_REAL saltus_real;
#endif

/* A rotation from the body's axes to the world's: a unit quaternion. */
typedef struct { saltus_real w, x, y, z; } saltus_rotation;

/* What the sensors say in a cycle, in counts of their converters, along the body's axes: the mean of the cycle. */
typedef struct {
    int32_t fine_gyro[3], coarse_gyro[3];
    int32_t fine_accelerometer[3], coarse_accelerometer[3];
    uint64_t touching; /* switches in the feet: bit k is leg k's, 1 where it is pressed */
} saltus_inertial;

/* What a count is. */
typedef struct {
    saltus_real fine_gyro, coarse_gyro;                   /* rad/s */
    saltus_real fine_accelerometer, coarse_accelerometer; /* m/s^2 */
    int32_t limit;                                        /* count of a fine one from which on the coarse one is believed */
} saltus_scales;

#define SALTUS_MOST_FEET 64

/* The feet. */
typedef struct {
    const saltus_real (*directions)[3]; /* where each leg points: unit vectors in the body's axes */
    uint32_t count;                     /* of which at most SALTUS_MOST_FEET count */
    saltus_real reach;                  /* from where the legs meet to the middle of a retracted foot (m) */
    saltus_real radius;                 /* of a foot (m) */
} saltus_feet;

/* How sensors are weighed. */
typedef struct {
    saltus_real period;  /* of the cycle (s) */
    saltus_real gravity; /* m/s^2 */
    saltus_real bias[3]; /* what gyros read at rest (rad/s) */
    saltus_real by_foot; /* how fast the velocity follows what a standing foot says (1/s) */
    saltus_real tilt;    /* how fast the vertical follows what that leaves (1/(m s)) */
    saltus_real settles; /* for how long a foot must be pressed before it is believed (s) */
    saltus_real returns; /* for how long it is not believed after its leg was fired (s): it must be home again */
} saltus_filter;

/* What makes the motion of what the sensors say. */
typedef struct { saltus_filter filter; saltus_scales scales; saltus_feet feet; } saltus_senses;

/* What a ball knows of its motion; all but the attitude along the world's axes. */
typedef struct {
    saltus_rotation attitude;
    saltus_real spin[3];     /* rad/s */
    saltus_real velocity[3]; /* of the place where the legs meet (m/s) */
    saltus_real place[3];    /* where that is (m) */
} saltus_estimate;

/* Makes an estimate, a cycle at a time. Its fields but `estimate` are its own. */
typedef struct {
    const saltus_senses *senses;
    saltus_estimate estimate;
    struct { uint16_t pressed, fired; } feet[SALTUS_MOST_FEET];
} saltus_estimator;

/* A leg in a plane, or two of which each is the mirror image of the other. */
typedef struct {
    uint32_t legs[2];  /* of twins first the left one, of a single leg twice itself */
    saltus_real angle; /* how far the disc turns from where the first station points down to where this one does (rad), in [0, 2 pi), rising */
} saltus_station;

/* A plane through the middle, with the legs near it: a disc. */
typedef struct {
    saltus_real axis[3];  /* unit vector across the plane, to the left of a ball that rolls forwards, in the body's axes */
    saltus_real first[3]; /* unit vector along the leg of the first station */
    saltus_real ahead[3]; /* unit vector that points down after a quarter turn from where `first` does */
    const saltus_station *stations;
    uint32_t count;
} saltus_plane;

/* How a plane lies. */
typedef struct {
    saltus_real lean;    /* of the station in the zone (rad) */
    saltus_real rate;    /* of the turn about the disc's axis (rad/s) */
    saltus_real roll, roll_rate; /* how far the disc leans to the right (rad), and its rate (rad/s) */
    saltus_real heading, heading_rate; /* to the left of the x axis (rad), in [-pi, pi], and its rate (rad/s) */
} saltus_lying;

/* By how much longer the valve of the right twin opens, and that of the left one less long (s). */
typedef struct {
    saltus_real roll, roll_rate;       /* for each rad of roll, as it will be when the leg pushes, and for each rad/s of it */
    saltus_real heading, heading_rate; /* for each rad off the course, to the left, and for each rad/s of it */
    saltus_real aside, aside_rate;     /* for each metre to the left of the line, and for each m/s of it */
    saltus_real sum;                   /* for each rad that earlier twins were off it */
    saltus_real most;                  /* either way (s) */
    saltus_real from;                  /* lean of the twins from which on each that is on the ground fires for what it lacks (rad) */
    saltus_real rest;                  /* least time from one of these firings to the next of the same twin (s) */
} saltus_steer;

/* How a ball rolls, and how it is kept in its plane. Of two numbers the first is of single legs, the second of twins. */
typedef struct {
    saltus_real period;     /* of the cycle (s) */
    saltus_real zone;       /* lean at which a station enters the active zone (rad) */
    saltus_real angles[2];  /* lean from which on the station in the zone fires, once, when it touches the ground (rad) */
    saltus_real opens[2];   /* valve opening times at `rate` (s) */
    saltus_real by_rate[2]; /* by how much longer a valve opens for each rad/s below `rate` (s) */
    saltus_real rate;       /* to hold (rad/s) */
    saltus_real first[2];   /* valve opening times where it turns more slowly than `slow` (s): to set out */
    saltus_real slow;       /* that rate (rad/s) */
    saltus_real stall;      /* for how long it may turn more slowly than half of that before the station may fire again (s) */
    saltus_real lead;       /* how long a leg takes from its command until it pushes (s) */
    saltus_real least;      /* shortest opening time (s); what would open for less does not fire */
    saltus_steer steer;
} saltus_balance;

/* What a cycle sees. */
typedef struct {
    saltus_rotation attitude;
    saltus_real spin[3];    /* rad/s, the world's axes */
    saltus_real aside;      /* way to the left of the line (m) */
    saltus_real aside_rate; /* its rate (m/s) */
    saltus_real course;     /* heading of the line, to the left of the x axis (rad) */
    uint64_t touching;      /* feet on the ground: bit k is leg k's */
} saltus_sight;

/* A leg to fire now. */
typedef struct {
    int32_t leg;      /* -1: none */
    saltus_real open; /* for how long (s) */
} saltus_firing;

/* Follows a plane as it turns. */
typedef struct {
    const saltus_plane *plane;
    saltus_real zone, turn;
    int is_seen;
    int32_t turns;
    uint32_t station;
} saltus_tracker;

/* Rolls a ball. Its fields are its own. */
typedef struct {
    const saltus_balance *balance;
    saltus_tracker tracker;
    int waits;
    uint32_t still;
    saltus_real sum;
    uint16_t since[2];
} saltus_balancer;

/* How a ball is led along a path. */
typedef struct {
    const saltus_balance *balance;
    saltus_real ahead;    /* how far ahead on the path the place is to which it turns (m) */
    saltus_real slew;     /* how fast its course is turned (rad/s) */
    saltus_real tips;     /* roll from which on no leg fires until it lies still (rad) */
    saltus_real astray;   /* way aside of its path from which on it stops, to choose another plane (m) */
    saltus_real turn;     /* how far the way to go may be off its heading before it stops, to choose another plane (rad) */
    saltus_real near;     /* how near it must come to a point of its path (m) */
    saltus_real still;    /* spin below which it lies still (rad/s) */
    saltus_real rests;    /* for how long (s) */
    saltus_real patience; /* for how long no station may come before it tries another plane (s) */
} saltus_lead;

/* What a cycle of a pilot sees. */
typedef struct {
    saltus_rotation attitude;
    saltus_real spin[3];     /* rad/s, the world's axes */
    saltus_real place[2];    /* where the legs meet (m): along the first heading, to its left */
    saltus_real velocity[2]; /* of that place (m/s) */
    uint64_t touching;       /* feet on the ground: bit k is leg k's */
} saltus_view;

/* Leads a ball along a path. Its fields are its own. */
typedef struct {
    const saltus_lead *lead;
    const saltus_plane *planes;
    const saltus_real (*path)[2];
    uint32_t plane_count, path_count, next, plane, still, idle, attempts, starts;
    saltus_real from[2], course;
    saltus_balancer balancer;
    int32_t passed;
    int rolls, faces;
} saltus_pilot;

/* Whether a ball can tell how it lies. */
enum saltus_rest_status {
    SALTUS_REST_OK = 0,
    SALTUS_REST_ASK_LATER = 1, /* too few readings yet */
    SALTUS_REST_MOVING = 2,    /* it turns, or something shakes it */
    SALTUS_REST_SATURATED = 3  /* an accelerometer is at its end */
};

/* The mean of the accelerometers at rest; all 0 is without readings. */
typedef struct { int32_t sums[3], count, fastest; int is_saturated; } saltus_at_rest;

/* Takes a cycle's readings; beyond 250, no more. */
void saltus_at_rest_take(saltus_at_rest *rest, const saltus_scales *scales, const saltus_inertial *readings);

/* How a ball lies at rest: upright by gravity, along any heading. */
enum saltus_rest_status saltus_attitude(const saltus_at_rest *rest, const saltus_senses *senses, saltus_rotation *attitude);

/* Starts a ball at rest with this attitude, its legs meeting at `place` (m). `senses` lives as long as the estimator. */
void saltus_estimator_start(saltus_estimator *estimator, const saltus_senses *senses, const saltus_rotation *attitude, const saltus_real place[3]);

/* The leg has been fired. */
void saltus_estimator_fired(saltus_estimator *estimator, int32_t leg);

/* Takes a cycle's readings. */
void saltus_estimator_take(saltus_estimator *estimator, const saltus_inertial *readings);

/* Starts a ball that has not yet been seen, to roll in `plane`. Both live as long as the balancer. */
void saltus_balancer_start(saltus_balancer *balancer, const saltus_balance *balance, const saltus_plane *plane);

/* A cycle: how the plane lies, and the legs that fire now. */
void saltus_balancer_step(saltus_balancer *balancer, const saltus_sight *sight, saltus_lying *lying, saltus_firing firings[2]);

/* Starts a ball that begins at the origin, by any of `planes`, through the points of `path` (m). All of them live as long as the pilot. */
void saltus_pilot_start(saltus_pilot *pilot, const saltus_lead *lead, const saltus_plane *planes, uint32_t plane_count,
    const saltus_real (*path)[2], uint32_t path_count);

/* A cycle: the legs that fire now. */
void saltus_pilot_step(saltus_pilot *pilot, const saltus_view *view, saltus_firing firings[2]);

/* The plane in which it rolls, by its number; -1 while it comes to rest. */
int32_t saltus_pilot_plane(const saltus_pilot *pilot);

#ifdef __cplusplus
}
#endif

#endif
