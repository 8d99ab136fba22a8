@HEADER@
/*
 * C99. IEEE 754 arithmetic without contraction of products and sums: -ffp-contract=off, which is what -std=c99 means to GCC. The only
 * functions of others are @SQRT@ and @ABS@, exact or correctly rounded everywhere. Link with -lm; with -fno-math-errno each is one instruction
 * where the processor has a root, and no library is needed.
 * Nothing allocates, recurses, or loops more often than legs and stations are.
 */
#include "saltus_ball.h"

#include <float.h>
#include <math.h>

#ifndef __GNUC__
#pragma STDC FP_CONTRACT OFF
#endif

#if FLT_EVAL_METHOD != 0
#error "Wider intermediate results would change the answers"
#endif

#ifdef __GNUC__
#define INLINE static inline __attribute__((always_inline))
#else
#define INLINE static inline
#endif

/* A constant, rounded from double as in Rust. */
#define R(x) ((saltus_real)(x))
#define SQRT(x) @SQRT@(x)
#define ABS(x) @ABS@(x)
#define GREATEST @GREATEST@
#define PI 3.141592653589793
#define HALF_PI 1.5707963267948966
#define TWO_PI 6.283185307179586

static int is_finite(saltus_real x) { return ABS(x) <= GREATEST; }
static saltus_real lesser(saltus_real a, saltus_real b) { return b < a ? b : a; }
static saltus_real greater(saltus_real a, saltus_real b) { return b > a ? b : a; }
static saltus_real number(uint32_t count) { return (saltus_real)(int32_t)(count > INT32_MAX ? INT32_MAX : count); }

/* Whole numbers that go round. */
static int32_t round_to(uint32_t x) { return x <= INT32_MAX ? (int32_t)x : -(int32_t)~x - 1; }

static int32_t minus(int32_t x) { return round_to(0u - (uint32_t)x); }

/* Counts on, up to the greatest number. */
static uint16_t next16(uint16_t x) { return x == UINT16_MAX ? x : (uint16_t)(x + 1); }

static saltus_real dot(const saltus_real a[3], const saltus_real b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const saltus_real a[3], const saltus_real b[3], saltus_real out[3]) {
    saltus_real x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

/* a + s b. */
static void add(const saltus_real a[3], saltus_real s, const saltus_real b[3], saltus_real out[3]) {
    for (int k = 0; k < 3; k++) out[k] = a[k] + s * b[k];
}

/* v of the first frame in the second. */
INLINE void turn(const saltus_rotation *q, const saltus_real v[3], saltus_real out[3]) {
    saltus_real u[3] = {q->x, q->y, q->z}, t[3], c[3], w[3];
    cross(u, v, t);
    add(t, R(1.0), t, t);
    cross(u, t, c);
    add(v, q->w, t, w);
    add(w, R(1.0), c, out);
}

static saltus_rotation back(const saltus_rotation *q) {
    saltus_rotation r = {q->w, -q->x, -q->y, -q->z};
    return r;
}

/* First b, then a. */
static saltus_rotation after(const saltus_rotation *a, const saltus_rotation *b) {
    saltus_rotation r = {
        a->w * b->w - a->x * b->x - a->y * b->y - a->z * b->z,
        a->w * b->x + a->x * b->w + a->y * b->z - a->z * b->y,
        a->w * b->y - a->x * b->z + a->y * b->w + a->z * b->x,
        a->w * b->z + a->x * b->y - a->y * b->x + a->z * b->w,
    };
    return r;
}

/* That of unit length along it; none for what has no length. */
static saltus_rotation unit(const saltus_rotation *q) {
    saltus_real length = SQRT(q->w * q->w + q->x * q->x + q->y * q->y + q->z * q->z);
    if (!(length > 0) || !is_finite(length)) {
        saltus_rotation none = {R(1.0), R(0.0), R(0.0), R(0.0)};
        return none;
    }
    saltus_rotation r = {q->w / length, q->x / length, q->y / length, q->z / length};
    return r;
}

/* By a small rotation vector (rad), to its fourth power; of unit length again. */
static saltus_rotation small(const saltus_real v[3]) {
    saltus_real s = dot(v, v) * R(0.25);
    saltus_real cosine = R(1.0) - s * R(0.5) + s * s * R(1.0 / 24.0);
    saltus_real sine = R(0.5) - s * R(1.0 / 12.0);
    saltus_rotation r = {cosine, sine * v[0], sine * v[1], sine * v[2]};
    return unit(&r);
}

/* The angle of the point (x, y) from the x axis (rad), in [-pi, pi]; 0 at the origin, and for what is not a number. */
static saltus_real angle_of(saltus_real y, saltus_real x) {
    saltus_real height = ABS(y), width = ABS(x);
    int is_steep = height > width;
    saltus_real shorter = is_steep ? width : height, longer = is_steep ? height : width;
    if (!(longer > 0)) return R(0.0);
    saltus_real t = shorter / longer;
    for (int k = 0; k < 3; k++) t = t / (R(1.0) + SQRT(R(1.0) + t * t));
    saltus_real s = t * t, sum = R(0.0);
    sum = R(1.0) / R(11.0) - s * sum;
    sum = R(1.0) / R(9.0) - s * sum;
    sum = R(1.0) / R(7.0) - s * sum;
    sum = R(1.0) / R(5.0) - s * sum;
    sum = R(1.0) / R(3.0) - s * sum;
    sum = R(1.0) / R(1.0) - s * sum;
    saltus_real angle = R(8.0) * t * sum;
    if (is_steep) angle = R(HALF_PI) - angle;
    if (x < 0) angle = R(PI) - angle;
    return y < 0 ? -angle : angle;
}

void saltus_at_rest_take(saltus_at_rest *rest, const saltus_scales *scales, const saltus_inertial *readings) {
    if (rest->count >= 250) return;
    int32_t limit = scales->limit;
    for (int k = 0; k < 3; k++) {
        int32_t reading = readings->fine_accelerometer[k], turns = readings->fine_gyro[k];
        if (reading >= limit || reading <= minus(limit)) rest->is_saturated = 1;
        rest->sums[k] = round_to((uint32_t)rest->sums[k] + (uint32_t)reading);
        if (turns < 0) turns = minus(turns);
        if (turns > rest->fastest) rest->fastest = turns;
    }
    rest->count++;
}

enum saltus_rest_status saltus_attitude(const saltus_at_rest *rest, const saltus_senses *senses, saltus_rotation *attitude) {
    const saltus_scales *scales = &senses->scales;
    if (rest->count < 100) return SALTUS_REST_ASK_LATER;
    if (rest->is_saturated) return SALTUS_REST_SATURATED;
    if ((saltus_real)rest->fastest * scales->fine_gyro > R(0.8)) return SALTUS_REST_MOVING;
    saltus_real count = scales->fine_accelerometer / (saltus_real)rest->count;
    saltus_real x = (saltus_real)rest->sums[0] * count, y = (saltus_real)rest->sums[1] * count, z = (saltus_real)rest->sums[2] * count;
    saltus_real length = SQRT(x * x + y * y + z * z), gravity = senses->filter.gravity, off = R(0.15) * gravity;
    if (!(length - gravity >= -off && length - gravity <= off)) return SALTUS_REST_MOVING;
    /* The shortest turn from up in the body's axes to the world's; with its head down, half a turn about x before. */
    saltus_rotation q = {length + z, y, -x, R(0.0)};
    if (!(z >= 0)) {
        saltus_rotation half_turn = {R(0.0), R(1.0), R(0.0), R(0.0)}, shortest = {length - z, -y, -x, R(0.0)};
        q = after(&shortest, &half_turn);
    }
    *attitude = unit(&q);
    return SALTUS_REST_OK;
}

void saltus_estimator_start(saltus_estimator *e, const saltus_senses *senses, const saltus_rotation *attitude, const saltus_real place[3]) {
    e->senses = senses;
    e->estimate.attitude = unit(attitude);
    for (int k = 0; k < 3; k++) {
        e->estimate.spin[k] = R(0.0);
        e->estimate.velocity[k] = R(0.0);
        e->estimate.place[k] = place[k];
    }
    for (int k = 0; k < SALTUS_MOST_FEET; k++) {
        e->feet[k].pressed = 0;
        e->feet[k].fired = UINT16_MAX;
    }
}

void saltus_estimator_fired(saltus_estimator *e, int32_t leg) {
    if (leg >= 0 && leg < SALTUS_MOST_FEET) e->feet[leg].fired = 0;
}

/* The readings of three axes: the fine one, where it is not at its end. */
static void read(int32_t limit, const int32_t fine[3], const int32_t coarse[3], saltus_real fine_unit, saltus_real coarse_unit, saltus_real out[3]) {
    int32_t least = minus(limit);
    for (int k = 0; k < 3; k++) {
        int is_fine = fine[k] < limit && fine[k] > least;
        out[k] = is_fine ? (saltus_real)fine[k] * fine_unit : (saltus_real)coarse[k] * coarse_unit;
    }
}

/* What the feet that stand say of velocity and vertical. */
static void stand(saltus_estimator *e, uint64_t touching) {
    const saltus_filter *f = &e->senses->filter;
    const saltus_feet *feet = &e->senses->feet;
    saltus_estimate *now = &e->estimate;
    saltus_real off[3] = {R(0.0), R(0.0), R(0.0)};
    uint32_t count = 0, legs = feet->count < SALTUS_MOST_FEET ? feet->count : SALTUS_MOST_FEET;
    for (uint32_t k = 0; k < legs; k++) {
        e->feet[k].fired = next16(e->feet[k].fired);
        if (!(touching >> k & 1)) {
            e->feet[k].pressed = 0;
            continue;
        }
        e->feet[k].pressed = next16(e->feet[k].pressed);
        int settled = (saltus_real)e->feet[k].pressed * f->period > f->settles, is_home = (saltus_real)e->feet[k].fired * f->period > f->returns;
        if (!settled || !is_home) continue;
        /* A sphere that rolls on the ground: where it touches, it does not move. */
        saltus_real arm[3], still[3];
        turn(&now->attitude, feet->directions[k], arm);
        for (int i = 0; i < 3; i++) arm[i] = arm[i] * feet->reach;
        arm[2] = arm[2] - feet->radius;
        cross(now->spin, arm, still);
        add(now->velocity, R(1.0), still, still);
        add(off, -R(1.0), still, off);
        count++;
    }
    if (count == 0) return;
    saltus_real part = f->period / (saltus_real)(int32_t)count;
    add(now->velocity, part * f->by_foot, off, now->velocity);
    /* A foot that says more velocity to the left than was integrated: the ball leans more to the left than was believed. */
    saltus_real tilt = part * f->tilt;
    saltus_real vector[3] = {-off[1] * tilt, off[0] * tilt, R(0.0)};
    saltus_rotation by = small(vector), turned = after(&by, &now->attitude);
    now->attitude = unit(&turned);
}

void saltus_estimator_take(saltus_estimator *e, const saltus_inertial *readings) {
    const saltus_filter *f = &e->senses->filter;
    const saltus_scales *s = &e->senses->scales;
    saltus_estimate *now = &e->estimate;
    saltus_real rate[3], force[3], vector[3], pull[3], mean[3];
    const saltus_real none[3] = {R(0.0), R(0.0), R(0.0)};
    read(s->limit, readings->fine_gyro, readings->coarse_gyro, s->fine_gyro, s->coarse_gyro, rate);
    read(s->limit, readings->fine_accelerometer, readings->coarse_accelerometer, s->fine_accelerometer, s->coarse_accelerometer, force);
    add(rate, -R(1.0), f->bias, rate);
    /* Half of the turn, where the mean force acted; then the other half. */
    add(none, R(0.5) * f->period, rate, vector);
    saltus_rotation half = small(vector), middle = after(&now->attitude, &half), end = after(&middle, &half);
    turn(&middle, force, pull);
    pull[2] = pull[2] - f->gravity;
    now->attitude = unit(&end);
    turn(&now->attitude, rate, now->spin);
    for (int k = 0; k < 3; k++) mean[k] = now->velocity[k];
    add(now->velocity, f->period, pull, now->velocity);
    add(mean, R(1.0), now->velocity, mean);
    add(now->place, R(0.5) * f->period, mean, now->place);
    stand(e, readings->touching);
}

/* Stations that have entered the zone, from the first one of turn 0 on. */
static int32_t passed(const saltus_tracker *t) { return round_to((uint32_t)t->turns * t->plane->count + t->station); }

static const saltus_station *station_of(const saltus_tracker *t) {
    return t->station < t->plane->count ? &t->plane->stations[t->station] : 0;
}

/* The disc has turned by `angle` (rad, whole turns left out) from where its first station points down; whether another station has entered
 * the zone. */
static int follow(saltus_tracker *t, saltus_real angle) {
    saltus_real whole = R(TWO_PI), turned = angle - t->zone;
    for (int k = 0; k < 3; k++) {
        if (turned < 0) {
            turned = turned + whole;
        } else if (turned >= whole) {
            turned = turned - whole;
        }
    }
    int32_t before = passed(t);
    int is_first = !t->is_seen;
    if (!is_first) {
        saltus_real half = R(0.5 * TWO_PI);
        if (turned - t->turn > half) {
            t->turns = round_to((uint32_t)t->turns - 1u);
        } else if (t->turn - turned > half) {
            t->turns = round_to((uint32_t)t->turns + 1u);
        }
    }
    t->is_seen = 1;
    t->turn = turned;
    t->station = 0;
    for (uint32_t k = 0; k < t->plane->count; k++) {
        if (t->plane->stations[k].angle <= turned) t->station = k;
    }
    return is_first || passed(t) > before;
}

/* Looks at the ball's attitude and spin; whether another station has entered the zone. */
static int look(saltus_tracker *t, const saltus_rotation *attitude, const saltus_real spin[3], saltus_lying *lying) {
    const saltus_plane *plane = t->plane;
    const saltus_real downwards[3] = {R(0.0), R(0.0), -R(1.0)};
    saltus_real down[3], axis[3], ahead[3] = {R(1.0), R(0.0), R(0.0)};
    saltus_rotation body = back(attitude);
    turn(&body, downwards, down);
    int entered = follow(t, angle_of(dot(down, plane->ahead), dot(down, plane->first)));
    turn(attitude, plane->axis, axis);
    /* The heading is level, and across the axis. */
    saltus_real length = SQRT(axis[0] * axis[0] + axis[1] * axis[1]);
    if (length > 0) {
        ahead[0] = axis[1] / length;
        ahead[1] = -axis[0] / length;
    }
    const saltus_station *station = station_of(t);
    lying->lean = t->turn + t->zone - (station ? station->angle : R(0.0));
    lying->rate = dot(spin, axis);
    lying->roll = angle_of(axis[2], length);
    lying->roll_rate = dot(spin, ahead);
    lying->heading = angle_of(ahead[1], ahead[0]);
    lying->heading_rate = spin[2];
    return entered;
}

/* An angle of at most a turn and a half (rad), from -pi to pi. */
static saltus_real wrapped(saltus_real angle) {
    saltus_real half = R(PI);
    if (angle > half) return angle - (half + half);
    if (angle < -half) return angle + (half + half);
    return angle;
}

void saltus_balancer_start(saltus_balancer *b, const saltus_balance *balance, const saltus_plane *plane) {
    saltus_tracker tracker = {plane, balance->zone, R(0.0), 0, 0, 0};
    b->balance = balance;
    b->tracker = tracker;
    b->waits = 1;
    b->still = 0;
    b->sum = R(0.0);
    b->since[0] = b->since[1] = UINT16_MAX;
}

/* By how much longer the right twin's valve opens (s). */
static saltus_real difference(const saltus_balancer *b, const saltus_lying *lying, const saltus_sight *sight) {
    const saltus_steer *s = &b->balance->steer;
    saltus_real more = s->roll * (lying->roll + b->balance->lead * lying->roll_rate)
        + s->roll_rate * lying->roll_rate
        + s->heading * wrapped(lying->heading - sight->course)
        + s->heading_rate * lying->heading_rate
        + s->aside * sight->aside
        + s->aside_rate * sight->aside_rate
        + s->sum * b->sum;
    return greater(lesser(more, s->most), -s->most);
}

/* Adds up how far off the line the twins were: a radian at most, half a metre aside counted as a quarter of one. */
static void sum_up(saltus_balancer *b, const saltus_lying *lying, const saltus_sight *sight) {
    saltus_real most = R(1.0), off = wrapped(lying->heading - sight->course) + R(0.5) * sight->aside;
    if (is_finite(off)) b->sum = greater(lesser(b->sum + off, most), -most);
}

static void fire(saltus_firing *firing, uint32_t leg, saltus_real open) {
    firing->leg = (int32_t)leg;
    firing->open = open;
}

/* Fires each of the twins that is on the ground for what it lacks, if it is ready. */
static void correct(saltus_balancer *b, const uint32_t legs[2], const int touch[2], saltus_real more, saltus_firing firings[2]) {
    const saltus_balance *p = b->balance;
    for (int side = 0; side < 2; side++) {
        saltus_real open = side == 0 ? -more : more;
        int rested = (saltus_real)b->since[side] * p->period > p->steer.rest;
        if (touch[side] && rested && open >= p->least) {
            b->since[side] = 0;
            fire(&firings[side], legs[side], open);
        }
    }
}

void saltus_balancer_step(saltus_balancer *b, const saltus_sight *sight, saltus_lying *lying, saltus_firing firings[2]) {
    const saltus_balance *p = b->balance;
    int entered = look(&b->tracker, &sight->attitude, sight->spin, lying);
    int is_still = ABS(lying->rate) < p->slow * R(0.5);
    b->still = !is_still ? 0 : b->still == UINT32_MAX ? b->still : b->still + 1;
    if (entered || number(b->still) * p->period > p->stall) {
        b->waits = 1;
        b->still = 0;
    }
    for (int side = 0; side < 2; side++) {
        b->since[side] = next16(b->since[side]);
        firings[side].leg = -1;
        firings[side].open = R(0.0);
    }
    const saltus_station *station = station_of(&b->tracker);
    if (!station) return;
    int kind = station->legs[0] != station->legs[1], touch[2];
    for (int side = 0; side < 2; side++) touch[side] = station->legs[side] < 64 && (sight->touching >> station->legs[side] & 1);
    saltus_real more = kind ? difference(b, lying, sight) : R(0.0);
    if (!(b->waits && lying->lean - p->angles[kind] >= 0) || !(touch[0] || touch[1])) {
        if (kind && lying->lean - p->steer.from >= 0) correct(b, station->legs, touch, more, firings);
        return;
    }
    b->waits = 0;
    saltus_real open = lying->rate < p->slow ? p->first[kind] : p->opens[kind] + p->by_rate[kind] * (p->rate - lying->rate);
    if (!kind) {
        open = greater(open, p->least);
        if (open >= p->least) fire(&firings[0], station->legs[0], open);
        return;
    }
    b->since[0] = b->since[1] = 0;
    sum_up(b, lying, sight);
    if (open - more >= p->least) fire(&firings[0], station->legs[0], open - more);
    if (open + more >= p->least) fire(&firings[1], station->legs[1], open + more);
}

/* Where the path is: the heading of its present piece (rad), how far the ball is to its left (m), how fast it goes to the left of its course (m/s), and
 * the heading to the place ahead (rad). */
typedef struct { saltus_real line, left, left_rate, aim; } way;

/* The unit vector along a heading of at most a turn. */
static void direction(saltus_real heading, saltus_real out[2]) {
    saltus_real half = heading * R(0.5), s = half * half;
    saltus_real even = R(0.041666668) + s * (R(-0.0013888889) + s * (R(0.000024801588) + s * R(-0.00000027557319)));
    saltus_real odd = R(-0.16666667) + s * (R(0.008333334) + s * (R(-0.00019841270) + s * R(0.0000027557319)));
    saltus_real x = R(1.0) + s * (R(-0.5) + s * even), y = half + half * s * odd;
    out[0] = x * x - y * y;
    out[1] = (x + x) * y;
}

void saltus_pilot_start(saltus_pilot *p, const saltus_lead *lead, const saltus_plane *planes, uint32_t plane_count,
    const saltus_real (*path)[2], uint32_t path_count) {
    p->lead = lead;
    p->planes = planes;
    p->plane_count = plane_count;
    p->path = path;
    p->path_count = path_count;
    p->next = p->plane = p->still = p->idle = p->attempts = p->starts = 0;
    p->from[0] = p->from[1] = p->course = R(0.0);
    p->passed = 0;
    p->rolls = p->faces = 0;
}

int32_t saltus_pilot_plane(const saltus_pilot *p) { return p->rolls ? (int32_t)p->plane : -1; }

static saltus_real seconds(const saltus_pilot *p, uint32_t cycles) { return number(cycles) * p->lead->balance->period; }

/* Whether the ball is far from its path, and `heading` leads farther. */
static int leaves(const saltus_pilot *p, const way *w, saltus_real heading) {
    return ABS(w->left) - p->lead->astray > 0 && w->left * wrapped(heading - w->line) > 0;
}

/* Where the path is, past the points that have been reached; whether there is any. */
static int find(saltus_pilot *p, const saltus_view *view, way *w) {
    const saltus_lead *l = p->lead;
    for (int points = 0; points < 8 && p->next < p->path_count; points++) {
        const saltus_real *to = p->path[p->next];
        saltus_real piece[2] = {to[0] - p->from[0], to[1] - p->from[1]}, rest[2] = {to[0] - view->place[0], to[1] - view->place[1]};
        saltus_real length = SQRT(piece[0] * piece[0] + piece[1] * piece[1]);
        int is_near = rest[0] * rest[0] + rest[1] * rest[1] < l->near * l->near;
        if (!is_near && length > 0) {
            saltus_real along[2] = {piece[0] / length, piece[1] / length};
            saltus_real gone[2] = {view->place[0] - p->from[0], view->place[1] - p->from[1]};
            saltus_real far = lesser(along[0] * gone[0] + along[1] * gone[1] + l->ahead, length), at[2];
            direction(p->course, at);
            w->line = angle_of(along[1], along[0]);
            w->left = along[0] * gone[1] - along[1] * gone[0];
            w->left_rate = at[0] * view->velocity[1] - at[1] * view->velocity[0];
            w->aim = angle_of(p->from[1] + far * along[1] - view->place[1], p->from[0] + far * along[0] - view->place[0]);
            return 1;
        }
        p->from[0] = to[0];
        p->from[1] = to[1];
        p->next++;
    }
    return 0;
}

/* Whether it has been still for long enough. */
static int lies(saltus_pilot *p, const saltus_view *view) {
    const saltus_lead *l = p->lead;
    int is_still = l->still * l->still - dot(view->spin, view->spin) > 0;
    p->still = !is_still ? 0 : p->still == UINT32_MAX ? p->still : p->still + 1;
    return seconds(p, p->still) > l->rests;
}

typedef struct { int is_there; uint32_t plane; saltus_real off, heading; } choice;

/* Sets out in the plane that leads most nearly where the path goes; after a start that failed in the next best one, and so on. */
static void set_out(saltus_pilot *p, const saltus_view *view, const way *w) {
    choice best[3];
    for (int place = 0; place < 3; place++) best[place].is_there = 0;
    const saltus_real upwards[3] = {R(0.0), R(0.0), R(1.0)};
    saltus_rotation body = back(&view->attitude);
    saltus_real up[3];
    turn(&body, upwards, up);
    for (uint32_t k = 0; k < p->plane_count; k++) {
        saltus_real axis[3];
        if (ABS(dot(up, p->planes[k].axis)) > R(0.2)) continue;
        turn(&view->attitude, p->planes[k].axis, axis);
        saltus_real heading = angle_of(-axis[0], axis[1]), off = ABS(wrapped(w->aim - heading));
        if (leaves(p, w, heading) || !(off >= 0)) continue;
        choice next = {1, k, off, heading};
        for (int place = 0; place < 3; place++) {
            if (!best[place].is_there) {
                best[place] = next;
                break;
            }
            if (best[place].off < next.off) continue;
            /* As near as one before it: that one counts. */
            if (best[place].off <= next.off) break;
            choice was = best[place];
            best[place] = next;
            next = was;
        }
    }
    uint32_t which = p->attempts % 3;
    while (which > 0 && !best[which].is_there) which--;
    const choice *chosen = &best[which];
    if (!chosen->is_there) return;
    p->plane = chosen->plane;
    p->course = chosen->heading;
    p->rolls = 1;
    saltus_balancer_start(&p->balancer, p->lead->balance, &p->planes[p->plane]);
    p->idle = 0;
    p->passed = INT32_MIN;
    p->faces = 0;
    if (p->starts != UINT32_MAX) p->starts++;
}

void saltus_pilot_step(saltus_pilot *p, const saltus_view *view, saltus_firing firings[2]) {
    const saltus_lead *l = p->lead;
    way w;
    for (int side = 0; side < 2; side++) {
        firings[side].leg = -1;
        firings[side].open = R(0.0);
    }
    if (!find(p, view, &w)) {
        p->rolls = 0;
        return;
    }
    if (!p->rolls && lies(p, view)) set_out(p, view, &w);
    if (!p->rolls) return;
    saltus_real most = l->slew * l->balance->period, off = wrapped(w.aim - p->course);
    p->course = wrapped(p->course + greater(lesser(off, most), -most));
    saltus_sight sight = {view->attitude, {view->spin[0], view->spin[1], view->spin[2]}, R(0.0), w.left_rate, p->course, view->touching};
    saltus_lying lying;
    saltus_firing fired[2];
    saltus_balancer_step(&p->balancer, &sight, &lying, fired);
    int32_t stations = passed(&p->balancer.tracker);
    if (p->idle != UINT32_MAX) p->idle++;
    if (stations > p->passed) {
        p->passed = stations;
        p->idle = 0;
    }
    if (p->passed > 6) p->attempts = 0;
    int is_stuck = seconds(p, p->idle) > l->patience, is_astray = leaves(p, &w, lying.heading);
    int faces = ABS(wrapped(w.aim - lying.heading)) < l->turn, turns = p->faces && !faces;
    p->faces = faces;
    if (ABS(lying.roll) > l->tips || is_stuck || is_astray || turns) {
        p->rolls = 0;
        if (is_stuck && p->attempts != UINT32_MAX) p->attempts++;
        p->still = 0;
        return;
    }
    firings[0] = fired[0];
    firings[1] = fired[1];
}
