@HEADER@
/*
 * C99. IEEE 754 arithmetic without contraction of products and sums: -ffp-contract=off, which is what -std=c99 means to GCC. The only
 * functions of others are @SQRT@ and @ABS@, exact or correctly rounded everywhere. Link with -lm; with -fno-math-errno each is one instruction
 * where the processor has a root, and no library is needed.
 * Nothing allocates, recurses, or loops more often than a constant says.
 */
#include "saltus_controller.h"

#include <float.h>
#include <math.h>
#include <string.h>

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

#define R(x) @SUFFIX@
#define SQRT(x) @SQRT@(x)
#define ABS(x) @ABS@(x)
#define ROUND_OFF @ROUND_OFF@
#define GREATEST @GREATEST@
#define GREAT @GREAT@

typedef struct { saltus_real first, last, per_unit; uint32_t count; } axis;
typedef struct { uint32_t cell; saltus_real part; } spot;
typedef struct { saltus_real state[4], by_angle[4], by_valve[4]; } lift_off;
typedef struct { saltus_real value, by_angle, by_valve; } linear;

static const saltus_real radius = @radius@; /* foot to wheel centre, leg retracted (m) */
static const saltus_real gravity = @gravity@; /* at the axle (m/s^2) */
static const saltus_real pendulum = @pendulum@; /* m g r/(I + m r^2) (1/s^2) */
static const saltus_real reference_lean = @reference_lean@; /* where the rates of the tables count (rad) */
static const saltus_real least_rate = @least_rate@; /* least approach rate (rad/s) */
static const saltus_real greatest_rate = @greatest_rate@; /* greatest approach rate (rad/s) */
static const saltus_real stride = @stride@; /* from one touch-down to the next (m) */
static const saltus_real nominal_valve_open = @valve_open@; /* (s) */
static const saltus_real landing_height = @landing_height@; /* of the wheel's centre (m) */
static const saltus_real period = @period@; /* of control (s) */
static const saltus_real extra_delay = @extra_delay@; /* of the valve, beyond the robot file's (s) */
static const saltus_real least_valve_open = @least_valve_open@; /* (s) */
static const saltus_real greatest_valve_open = @greatest_valve_open@; /* (s) */
static const saltus_real effort = @effort@; /* cost of a squared second of open valve (m^2/s^2) */
/* 1: approach rates count at the firing angle; 0: at the reference lean */
#define AT_FIRING @at_firing@
#define NEWTON_STEPS @newton_steps@
#define CHOOSES_VALVE @chooses_valve@

@DATA@

static int within(saltus_real x, saltus_real low, saltus_real high) { return x >= low && x <= high; }
static saltus_real magnitude(saltus_real x) { return ABS(x); }
static int is_finite(saltus_real x) { return magnitude(x) <= GREATEST; }
static saltus_real lesser(saltus_real a, saltus_real b) { return b < a ? b : a; }
static saltus_real greater(saltus_real a, saltus_real b) { return b > a ? b : a; }

static saltus_real sine(saltus_real x) {
    saltus_real s = x * x;
    saltus_real series = R(-0.16666667) + s * (R(0.008333334) + s * (R(-0.00019841270) + s * R(0.0000027557319)));
    return x + x * s * series;
}

static saltus_real cosine(saltus_real x) {
    saltus_real s = x * x;
    saltus_real series = R(0.041666668) + s * (R(-0.0013888889) + s * (R(0.000024801588) + s * R(-0.00000027557319)));
    return R(1.0) + s * (R(-0.5) + s * series);
}

static enum saltus_status locate(const axis *a, saltus_real x, spot *out) {
    if (!within(x, a->first, a->last)) return is_finite(x) ? SALTUS_OUT_OF_TABLE : SALTUS_SENSOR_INVALID;
    saltus_real along = (x - a->first) * a->per_unit;
    /* Beside a number so great only whole ones lie, and its last bits count them. */
    saltus_real beside = (along - R(0.5)) + GREAT;
    @BITS@ bits;
    memcpy(&bits, &beside, sizeof bits);
    uint32_t index = (uint32_t)(bits & 0x3FFFFF), most = a->count - 2;
    out->cell = index > most ? most : index;
    out->part = along - lesser(beside - GREAT, (saltus_real)most);
    return SALTUS_OK;
}

/* Weights of the difference of the values at both ends, and of the slopes there. */
static void hermite(saltus_real t, saltus_real w[3]) {
    saltus_real s = t * t, rest = R(1.0) - t;
    w[0] = s * (R(3.0) - (t + t));
    w[1] = (t * rest) * rest;
    w[2] = -(s * rest);
}

static void hermite_slope(saltus_real t, saltus_real w[3]) {
    saltus_real rise = (t - t * t) * R(6.0);
    saltus_real end = t * (R(3.0) * t - R(2.0));
    w[0] = rise;
    w[1] = (end - (t + t)) + R(1.0);
    w[2] = end;
}

/* Between the values p and q with their slopes, by the weights of hermite. */
static inline saltus_real cubic(const saltus_real f[3], saltus_real p, saltus_real p_slope, saltus_real q, saltus_real q_slope) {
    return (p + f[0] * (q - p)) + (f[1] * p_slope + f[2] * q_slope);
}

/* Its slope, by the weights of hermite_slope. */
static inline saltus_real cubic_slope(const saltus_real f[3], saltus_real p, saltus_real p_slope, saltus_real q, saltus_real q_slope) {
    return f[0] * (q - p) + (f[1] * p_slope + f[2] * q_slope);
}

@RULE@

INLINE enum saltus_status evaluate(saltus_real rate, saltus_real angle, lift_off *out, int derivatives) {
    spot i, j;
    enum saltus_status status = locate(&map_rates, rate, &i);
    if (status) return status;
    status = locate(&map_angles, angle, &j);
    if (status) return status;
    if (!map_open[i.cell * (map_angles.count - 1) + j.cell]) return SALTUS_INFEASIBLE;
    uint32_t first = i.cell * map_angles.count + j.cell, second = first + map_angles.count;
    const saltus_real *a = map_nodes[first], *b = map_nodes[first + 1];
    const saltus_real *c = map_nodes[second], *d = map_nodes[second + 1];
    saltus_real u[3], v[3], w[3];
    hermite(i.part, u);
    hermite(j.part, v);
    if (derivatives) hermite_slope(j.part, w);
    for (int k = 0; k < 4; k++) {
        saltus_real low[2], high[2];
        low[0] = cubic(u, a[k], a[4 + k], c[k], c[4 + k]);
        low[1] = cubic(u, a[8 + k], a[12 + k], c[8 + k], c[12 + k]);
        high[0] = cubic(u, b[k], b[4 + k], d[k], d[4 + k]);
        high[1] = cubic(u, b[8 + k], b[12 + k], d[8 + k], d[12 + k]);
        out->state[k] = cubic(v, low[0], low[1], high[0], high[1]);
        if (derivatives) out->by_angle[k] = cubic_slope(w, low[0], low[1], high[0], high[1]) * map_angles.per_unit;
        if (CHOOSES_VALVE) {
            saltus_real early = a[16 + k] + i.part * (c[16 + k] - a[16 + k]);
            saltus_real late = b[16 + k] + i.part * (d[16 + k] - b[16 + k]);
            out->by_valve[k] = early + j.part * (late - early);
        } else {
            out->by_valve[k] = R(0.0);
        }
    }
    return SALTUS_OK;
}

static enum saltus_status lift_off_at(saltus_real rate, saltus_real angle, lift_off *out) {
    return evaluate(rate, angle, out, 1);
}

/* Without derivatives by the angle. */
static enum saltus_status values_at(saltus_real rate, saltus_real angle, lift_off *out) {
    for (int k = 0; k < 4; k++) out->by_angle[k] = R(0.0);
    return evaluate(rate, angle, out, 0);
}

static inline saltus_real landing_by(const saltus_real d[4], saltus_real time, saltus_real vx, saltus_real vy, saltus_real slow) {
    saltus_real inverse = R(1.0) / gravity;
    saltus_real later = d[3] * inverse + (vy * d[3] * inverse + d[1]) * slow;
    return d[0] + d[2] * time + vx * later;
}

INLINE enum saltus_status landing(const lift_off *l, saltus_real height, linear *out, int derivatives) {
    saltus_real x = l->state[0], y = l->state[1], vx = l->state[2], vy = l->state[3];
    saltus_real fall = y - height;
    saltus_real square = vy * vy + (gravity + gravity) * fall;
    if (!(square >= 0)) return SALTUS_INFEASIBLE;
    saltus_real speed = SQRT(square);
    saltus_real time = (vy + speed) * (R(1.0) / gravity);
    if (!(time >= 0)) return SALTUS_INFEASIBLE;
    saltus_real slow = speed > 0 ? R(1.0) / speed : R(0.0);
    out->value = x + vx * time;
    out->by_angle = derivatives ? landing_by(l->by_angle, time, vx, vy, slow) : R(0.0);
    out->by_valve = derivatives && CHOOSES_VALVE ? landing_by(l->by_valve, time, vx, vy, slow) : R(0.0);
    return SALTUS_OK;
}

INLINE linear distance_to(const lift_off *l, saltus_real x, saltus_real y, int derivatives) {
    saltus_real vx = l->state[2], vy = l->state[3];
    saltus_real per_gravity = R(1.0) / gravity;
    saltus_real rise = vy * per_gravity;
    saltus_real apex_x = l->state[0] + vx * rise - x, apex_y = l->state[1] + R(0.5) * vy * rise - y;
    saltus_real scale = R(2.0) * (per_gravity * per_gravity);
    saltus_real p = scale * (vx * vx - gravity * apex_y), q = scale * (vx * apex_x);
    saltus_real lever = magnitude(q);
    saltus_real reach = p < 0 ? SQRT(-p) : R(0.0);
    saltus_real r = reach + (R(16.0) * lever + R(0.5)) * R(0.33333334);
    for (int k = 0; k < 4; k++) {
        saltus_real square = r * r;
        saltus_real slope = R(3.0) * square + p;
        if (!(slope > 0)) break;
        r = (R(2.0) * square * r + lever) / slope;
    }
    saltus_real s = q > 0 ? -r : r;
    saltus_real across = apex_x + vx * s, up = apex_y - R(0.5) * gravity * (s * s);
    saltus_real size = SQRT(across * across + up * up);
    /* Negative where the path passes below the corner. */
    saltus_real distance = up < 0 ? -size : size;
    linear out = {distance, R(0.0), R(0.0)};
    if (!derivatives) return out;
    saltus_real time = s + rise;
    saltus_real inverse = size > 0 ? R(1.0) / distance : R(0.0);
    const saltus_real *a = l->by_angle, *b = l->by_valve;
    out.by_angle = (across * (a[0] + a[2] * time) + up * (a[1] + a[3] * time)) * inverse;
    if (CHOOSES_VALVE) out.by_valve = (across * (b[0] + b[2] * time) + up * (b[1] + b[3] * time)) * inverse;
    return out;
}

/* The square of the rate at the lean `to` of a robot that has `rate` at the lean `from`. */
static saltus_real square_of_rate(saltus_real rate, saltus_real from, saltus_real to) {
    return rate * rate + (pendulum + pendulum) * (cosine(from) - cosine(to));
}

enum saltus_status saltus_rate_at(saltus_sensed sensed, saltus_real lean, saltus_real *rate) {
    saltus_real horizontal = R(1.5707964);
    int upright = within(sensed.lean, -horizontal, horizontal) && within(lean, -horizontal, horizontal);
    if (!(upright && is_finite(sensed.rate))) return SALTUS_SENSOR_INVALID;
    saltus_real square = square_of_rate(sensed.rate, sensed.lean, lean);
    if (!(sensed.rate > 0 && square > 0)) return SALTUS_INFEASIBLE;
    if (!is_finite(square)) return SALTUS_OUT_OF_TABLE;
    *rate = SQRT(square);
    return SALTUS_OK;
}

/* For a rate at the reference lean. */
static enum saltus_status angle_at_reference(saltus_real rate, saltus_real distance, saltus_real height, saltus_real *out) {
    if (!is_finite(height)) return SALTUS_SENSOR_INVALID;
    saltus_real angle, step = R(0.0);
    enum saltus_status status = rule(rate, distance, &angle);
    if (status) return status;
    if (NEWTON_STEPS == 0) {
        if (height != landing_height) return SALTUS_OUT_OF_TABLE;
        *out = angle;
        return SALTUS_OK;
    }
    for (int k = 0; k < NEWTON_STEPS; k++) {
        lift_off l;
        linear x;
        status = lift_off_at(rate, angle, &l);
        if (status) return status;
        status = landing(&l, height, &x, 1);
        if (status) return status;
        if (!(x.by_angle > 0)) return SALTUS_INFEASIBLE;
        step = (distance - x.value) / x.by_angle;
        angle = angle + step;
    }
    if (!within(step, -R(0.125), R(0.125))) return SALTUS_INFEASIBLE;
    if (!within(angle, map_angles.first, map_angles.last)) return SALTUS_OUT_OF_TABLE;
    *out = angle;
    return SALTUS_OK;
}

/* The rate at the reference lean of a robot that is fired at `angle` with the approach rate `rate`. */
static inline saltus_real reference_rate(saltus_real rate, saltus_real angle) {
    return AT_FIRING ? SQRT(square_of_rate(rate, angle, reference_lean)) : rate;
}

/* The rate at the firing angle `angle` of a robot that has the rate of the rule's node k. */
static saltus_real rate_of_node(uint32_t k, saltus_real angle) {
    saltus_real node = k + 1 == rule_rates.count ? rule_rates.last : rule_rates.first + (saltus_real)k / rule_rates.per_unit;
    saltus_real square = square_of_rate(node, reference_lean, angle);
    return square > 0 ? SQRT(square) : R(0.0);
}

/* The angle on the line between the ends of the rule's first open cell that holds `rate` at the firing angle. */
static enum saltus_status between_ends(saltus_real rate, saltus_real distance, saltus_real *out) {
    for (uint32_t cell = 0; cell + 1 < rule_rates.count; cell++) {
        saltus_real a, b;
        enum saltus_status status = rule_ends(cell, distance, &a, &b);
        if (status == SALTUS_INFEASIBLE) continue;
        if (status) return status;
        saltus_real low = rate_of_node(cell, a), high = rate_of_node(cell + 1, b);
        if (within(rate, low, high) && low < high) {
            *out = a + (rate - low) / (high - low) * (b - a);
            return SALTUS_OK;
        }
    }
    return SALTUS_INFEASIBLE;
}

/* The firing angle whose own approach rate is `rate`: by secants. */
static enum saltus_status angle_at_firing(saltus_real rate, saltus_real distance, saltus_real height, saltus_real *out) {
    if (!within(rate, least_rate, greatest_rate)) return is_finite(rate) ? SALTUS_OUT_OF_TABLE : SALTUS_SENSOR_INVALID;
    saltus_real before, angle, next;
    enum saltus_status status = between_ends(rate, distance, &before);
    if (status) return status;
    status = angle_at_reference(reference_rate(rate, before), distance, height, &angle);
    if (status) return status;
    saltus_real gap_before = angle - before;
    for (int k = 1; k < 8; k++) {
        status = angle_at_reference(reference_rate(rate, angle), distance, height, &next);
        if (status) return status;
        saltus_real gap = next - angle;
        if (magnitude(gap) <= ROUND_OFF) {
            *out = angle;
            return SALTUS_OK;
        }
        saltus_real slope = (gap - gap_before) / (angle - before);
        before = angle;
        gap_before = gap;
        angle = angle - gap / slope;
    }
    return SALTUS_INFEASIBLE;
}

enum saltus_status saltus_firing_angle(saltus_real rate, saltus_real distance, saltus_real height, saltus_real *out) {
    return AT_FIRING ? angle_at_firing(rate, distance, height, out) : angle_at_reference(rate, distance, height, out);
}

/* An interval of a line that constraints cut shorter. */
typedef struct { saltus_real low, high; } interval;

static inline enum saltus_status cut(interval *i, saltus_real slope, saltus_real room, saltus_real doubt, saltus_real size) {
    if (magnitude(slope) <= doubt) return room < -(ROUND_OFF * size) ? SALTUS_INFEASIBLE : SALTUS_OK;
    saltus_real end = room / slope;
    if (slope > 0) i->high = lesser(i->high, end);
    else i->low = greater(i->low, end);
    return SALTUS_OK;
}

static enum saltus_status nearest(const interval *i, saltus_real t, saltus_real *out) {
    saltus_real size = magnitude(i->low) + magnitude(i->high);
    if (i->low - i->high > ROUND_OFF * size) return SALTUS_INFEASIBLE;
    t = greater(lesser(t, i->high), i->low);
    if (!is_finite(t)) return SALTUS_SENSOR_INVALID;
    *out = t;
    return SALTUS_OK;
}

enum saltus_status saltus_qp1(saltus_real h, saltus_real g, const saltus_half_line *c, size_t count, saltus_real *x) {
    saltus_real free = -g / h;
    if (!(h > 0) || !is_finite(free)) return SALTUS_SENSOR_INVALID;
    interval line = {-GREATEST, GREATEST};
    for (size_t k = 0; k < count; k++) {
        if (!(is_finite(c[k].slope) && is_finite(c[k].bound))) return SALTUS_SENSOR_INVALID;
        enum saltus_status status = cut(&line, c[k].slope, c[k].bound, R(0.0), magnitude(c[k].bound));
        if (status) return status;
    }
    return nearest(&line, free, x);
}

static enum saltus_status on_border(const saltus_half_plane *violated, saltus_real way0, saltus_real way1, const saltus_real free[2],
                                    const saltus_half_plane *c, size_t count, saltus_real out[2]) {
    saltus_real n0 = violated->normal[0], n1 = violated->normal[1];
    saltus_real square = n0 * way0 + n1 * way1;
    if (!(square > 0)) return SALTUS_INFEASIBLE;
    saltus_real lever = ((n0 * free[0] + n1 * free[1]) - violated->bound) / square;
    saltus_real foot0 = free[0] - lever * way0, foot1 = free[1] - lever * way1;
    interval line = {-GREATEST, GREATEST};
    for (size_t k = 0; k < count; k++) {
        saltus_real u = c[k].normal[1] * n0, v = c[k].normal[0] * n1;
        saltus_real p = c[k].normal[0] * foot0, q = c[k].normal[1] * foot1;
        saltus_real size = magnitude(c[k].bound) + magnitude(p) + magnitude(q);
        saltus_real doubt = ROUND_OFF * magnitude(u);
        enum saltus_status status = cut(&line, u - v, c[k].bound - (p + q), doubt, size);
        if (status) return status;
    }
    saltus_real t;
    enum saltus_status status = nearest(&line, R(0.0), &t);
    if (status) return status;
    out[0] = foot0 - t * n1;
    out[1] = foot1 + t * n0;
    return SALTUS_OK;
}

enum saltus_status saltus_qp2(const saltus_real h[3], const saltus_real g[2], const saltus_half_plane *c, size_t count,
                              saltus_real x[2]) {
    saltus_real h11 = h[0], h12 = h[1], h22 = h[2];
    saltus_real product = h11 * h22, square = h12 * h12;
    saltus_real determinant = product - square;
    saltus_real doubt = ROUND_OFF * R(0.0625) * product;
    if (!(h11 > 0 && determinant > doubt && is_finite(determinant))) return SALTUS_SENSOR_INVALID;
    saltus_real free[2] = {-(h22 * g[0] - h12 * g[1]) / determinant, -(h11 * g[1] - h12 * g[0]) / determinant};
    if (!(is_finite(free[0]) && is_finite(free[1]))) return SALTUS_SENSOR_INVALID;
    saltus_real best[2] = {free[0], free[1]};
    for (size_t k = 0; k < count; k++) {
        saltus_real n0 = c[k].normal[0], n1 = c[k].normal[1];
        saltus_real p = n0 * best[0], q = n1 * best[1];
        saltus_real size = magnitude(c[k].bound) + magnitude(p) + magnitude(q);
        if (!is_finite(size)) return SALTUS_SENSOR_INVALID;
        if ((p + q) - c[k].bound <= ROUND_OFF * size) continue;
        enum saltus_status status = on_border(&c[k], h22 * n0 - h12 * n1, h11 * n1 - h12 * n0, free, c, k, best);
        if (status) return status;
    }
    if (!(is_finite(best[0]) && is_finite(best[1]))) return SALTUS_SENSOR_INVALID;
    x[0] = best[0];
    x[1] = best[1];
    return SALTUS_OK;
}

/* Landing, and the wheel's clearances over the front and the back corner. */
static enum saltus_status lengths(saltus_real rate, const saltus_guess *at, const saltus_task *task, linear out[3]) {
    lift_off l;
    const saltus_obstacle *o = task->obstacle;
    enum saltus_status status = lift_off_at(rate, at->firing_angle, &l);
    if (status) return status;
    if (CHOOSES_VALVE) {
        saltus_real more = at->valve_open - nominal_valve_open;
        for (int k = 0; k < 4; k++) l.state[k] = l.state[k] + more * l.by_valve[k];
    }
    status = landing(&l, task->landing_height, &out[0], 1);
    if (status) return status;
    out[1] = distance_to(&l, o->front, o->height, 1);
    out[1].value = out[1].value - radius;
    out[2] = distance_to(&l, o->back, o->height, 1);
    out[2].value = out[2].value - radius;
    return SALTUS_OK;
}

static enum saltus_status qp_step(const saltus_guess *guess, const saltus_task *task, const linear l[3], saltus_real step[2]) {
    saltus_real angle = guess->firing_angle, valve_open = guess->valve_open;
    const saltus_obstacle *o = task->obstacle;
    saltus_real high = lesser(R(0.125), map_angles.last - angle);
    saltus_real low = greater(-R(0.125), map_angles.first - angle);
    saltus_real off = l[0].value - task->distance;
    saltus_real beyond = l[0].value - o->back;
    saltus_real over_first = l[1].value - o->clearance, over_second = l[2].value - o->clearance;
    saltus_real j = l[0].by_angle;
    if (!CHOOSES_VALVE) {
        saltus_half_line c[5] = {
            {R(1.0), high}, {-R(1.0), -low}, {-l[1].by_angle, over_first}, {-l[2].by_angle, over_second}, {-l[0].by_angle, beyond},
        };
        step[1] = R(0.0);
        return saltus_qp1(j * j, j * off, c, 5, &step[0]);
    }
    saltus_real k = l[0].by_valve;
    saltus_half_plane c[7] = {
        {{R(0.0), -R(1.0)}, valve_open - least_valve_open},
        {{R(0.0), R(1.0)}, greatest_valve_open - valve_open},
        {{-R(1.0), R(0.0)}, -low},
        {{R(1.0), R(0.0)}, high},
        {{-l[1].by_angle, -l[1].by_valve}, over_first},
        {{-l[2].by_angle, -l[2].by_valve}, over_second},
        {{-l[0].by_angle, -l[0].by_valve}, beyond},
    };
    saltus_real h[3] = {j * j, j * k, k * k + effort};
    saltus_real g[2] = {j * off, k * off + effort * valve_open};
    return saltus_qp2(h, g, c, 7, step);
}

static enum saltus_status over(saltus_real rate, const saltus_task *task, saltus_decision *d) {
    const saltus_obstacle *o = task->obstacle;
    linear l[3];
    saltus_real step[2];
    if (!(is_finite(o->front) && is_finite(o->back) && is_finite(o->height) && is_finite(o->clearance))) return SALTUS_SENSOR_INVALID;
    if (!(o->front < o->back && o->height >= 0 && o->clearance >= 0)) return SALTUS_SENSOR_INVALID;
    if (!(is_finite(task->distance) && is_finite(task->landing_height))) return SALTUS_SENSOR_INVALID;
    saltus_guess guess;
    enum saltus_status status;
    if (task->guess != NULL) {
        guess = *task->guess;
    } else {
        status = rule(rate, task->distance, &guess.firing_angle);
        if (status) return status;
        guess.valve_open = nominal_valve_open;
    }
    if (!within(guess.valve_open, least_valve_open, greatest_valve_open)) {
        return is_finite(guess.valve_open) ? SALTUS_OUT_OF_TABLE : SALTUS_SENSOR_INVALID;
    }
    status = lengths(rate, &guess, task, l);
    if (status) return status;
    status = qp_step(&guess, task, l, step);
    if (status) return status;
    d->firing_angle = guess.firing_angle + step[0];
    d->valve_open = guess.valve_open + step[1];
    /* Lengths that are too great for the numbers of the program leave its bounds to round-off. */
    if (!(within(d->firing_angle, map_angles.first - R(1e-4), map_angles.last + R(1e-4)) &&
          within(d->valve_open, least_valve_open - R(1e-5), greatest_valve_open + R(1e-5)))) {
        return SALTUS_INFEASIBLE;
    }
    saltus_real miss = R(0.002), least = o->clearance - miss;
    int clears = l[1].value >= least && l[2].value >= least && l[0].value >= o->back - miss;
    d->settled = clears && within(step[0] * l[0].by_angle, -miss, miss) && within(step[1] * l[0].by_valve, -miss, miss);
    return SALTUS_OK;
}

static enum saltus_status timing(const saltus_sensed *sensed, saltus_real angle, saltus_decision *out) {
    if (!(sensed->rate > 0)) return SALTUS_INFEASIBLE;
    saltus_real way = angle - sensed->lean, acceleration = pendulum * sine(sensed->lean);
    saltus_real square = sensed->rate * sensed->rate + (acceleration + acceleration) * way;
    if (!(square >= 0)) return SALTUS_INFEASIBLE;
    saltus_real time = (way + way) / (sensed->rate + SQRT(square)) - extra_delay;
    if (!is_finite(time)) return SALTUS_SENSOR_INVALID;
    out->timing = time < 0 ? SALTUS_LATE : time < period ? SALTUS_FIRE : SALTUS_WAIT;
    out->time = time < 0 ? -time : time;
    return SALTUS_OK;
}

enum saltus_status saltus_decide(const saltus_sensed *sensed, const saltus_task *task, saltus_decision *out) {
    saltus_decision d;
    saltus_real rate;
    enum saltus_status status = saltus_rate_at(*sensed, reference_lean, &rate);
    if (status) return status;
    if (task->obstacle == NULL) {
        status = angle_at_reference(rate, task->distance, task->landing_height, &d.firing_angle);
        d.valve_open = nominal_valve_open;
        d.settled = 1;
    } else {
        status = over(rate, task, &d);
    }
    if (status) return status;
    status = timing(sensed, d.firing_angle, &d);
    if (status) return status;
    d.approach_rate = rate;
    if (AT_FIRING) status = saltus_rate_at(*sensed, d.firing_angle, &d.approach_rate);
    if (status) return status;
    *out = d;
    return SALTUS_OK;
}

#define NO_JUMP R(-1e30)

/* One jump; its clearance is NO_JUMP where there is none. */
static saltus_take_off jump_over(saltus_real rate, saltus_real angle, saltus_real front, const saltus_approach *a) {
    saltus_take_off out = {0, rate, angle, R(0.0), NO_JUMP};
    lift_off l;
    linear x;
    if (values_at(reference_rate(rate, angle), angle, &l) || landing(&l, radius, &x, 0)) return out;
    saltus_real back = front + a->length;
    saltus_real first = distance_to(&l, front, a->height, 0).value - radius;
    saltus_real second = distance_to(&l, back, a->height, 0).value - radius;
    saltus_real clearance = lesser(lesser(x.value - back, first), second);
    out.distance = x.value;
    if (is_finite(clearance)) out.clearance = clearance;
    return out;
}

static void keep_better(saltus_take_off *best, const saltus_take_off *other) {
    if (other->clearance > best->clearance) *best = *other;
}

static saltus_take_off best_over(saltus_real rate, saltus_real front, const saltus_approach *a) {
    saltus_real first = map_angles.first, last = map_angles.last;
    saltus_real step = (last - first) / R(8.0);
    saltus_take_off best = {0, rate, R(0.0), R(0.0), NO_JUMP}, at_p, at_q;
    for (int k = 0; k < 9; k++) {
        saltus_take_off j = jump_over(rate, k == 8 ? last : first + (saltus_real)k * step, front, a);
        keep_better(&best, &j);
    }
    if (!(best.clearance > NO_JUMP)) return best;
    saltus_real low = greater(best.firing_angle - step, first), high = lesser(best.firing_angle + step, last);
    saltus_real part = R(0.38196602);
    saltus_real p = low + part * (high - low), q = high - part * (high - low);
    at_p = jump_over(rate, p, front, a);
    at_q = jump_over(rate, q, front, a);
    for (int k = 0; k < 9; k++) {
        keep_better(&best, &at_p);
        keep_better(&best, &at_q);
        if (at_p.clearance > at_q.clearance) {
            high = q;
            q = p;
            at_q = at_p;
            p = low + part * (high - low);
            at_p = jump_over(rate, p, front, a);
        } else {
            low = p;
            p = q;
            at_p = at_q;
            q = high - part * (high - low);
            at_q = jump_over(rate, q, front, a);
        }
    }
    keep_better(&best, &at_p);
    keep_better(&best, &at_q);
    return best;
}

/* The first number that is no measurement. */
static enum saltus_input wrong_input(const saltus_approach *a) {
    if (!is_finite(a->distance)) return SALTUS_INPUT_DISTANCE;
    if (!(is_finite(a->height) && a->height >= 0)) return SALTUS_INPUT_HEIGHT;
    if (!(is_finite(a->length) && a->length > 0)) return SALTUS_INPUT_LENGTH;
    if (!is_finite(a->speed)) return SALTUS_INPUT_SPEED;
    if (!(is_finite(a->clearance) && a->clearance >= 0)) return SALTUS_INPUT_CLEARANCE;
    return SALTUS_NO_INPUT;
}

enum saltus_status saltus_choose_take_off(const saltus_approach *a, saltus_take_off *out, enum saltus_input *input) {
    enum saltus_input ignored;
    if (input == NULL) input = &ignored;
    *input = wrong_input(a);
    if (*input != SALTUS_NO_INPUT) return SALTUS_SENSOR_INVALID;
    saltus_real rate = a->speed / radius;
    *input = SALTUS_INPUT_SPEED;
    if (!within(rate, least_rate, greatest_rate)) return SALTUS_OUT_OF_TABLE;
    *input = SALTUS_INPUT_DISTANCE;
    if (!(a->distance >= radius + a->clearance)) return SALTUS_INFEASIBLE;
    saltus_take_off best = {0, rate, R(0.0), R(0.0), NO_JUMP};
    saltus_real front = a->distance;
    for (uint32_t k = 0; k < 4; k++) {
        if (!(front >= radius + a->clearance)) break;
        saltus_take_off found = best_over(rate, front, a);
        if (found.clearance > best.clearance) {
            best = found;
            best.touch_down = k;
        }
        front = front - stride;
    }
    if (best.clearance > NO_JUMP && best.clearance >= a->clearance) {
        *out = best;
        *input = SALTUS_NO_INPUT;
        return SALTUS_OK;
    }
    if (front >= radius + a->clearance) return SALTUS_ASK_LATER;
    *input = SALTUS_NO_INPUT;
    return SALTUS_INFEASIBLE;
}

void saltus_observe(saltus_sensed *state, saltus_real lean, saltus_real dt, saltus_real memory) {
    saltus_real acceleration = pendulum * sine(state->lean);
    saltus_real step = dt * acceleration;
    saltus_real predicted = state->lean + dt * (state->rate + R(0.5) * step);
    saltus_real next = state->rate + step;
    saltus_real off = is_finite(lean) ? lean - predicted : R(0.0);
    saltus_real fresh = R(1.0) - memory;
    state->lean = predicted + (R(1.0) - memory * memory) * off;
    state->rate = next + fresh * fresh * off / dt;
}

static uint32_t crc_of(uint32_t crc, const saltus_real *values, size_t count) {
    for (size_t k = 0; k < count; k++) {
        @BITS@ bits;
        memcpy(&bits, &values[k], sizeof bits);
        for (size_t byte = 0; byte < sizeof bits; byte++) {
            crc ^= (uint32_t)((bits >> (8 * byte)) & 0xFF);
            for (int bit = 0; bit < 8; bit++) crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
        }
    }
    return crc;
}

@SELF_TEST@
