@HEADER@
/*
 * C99. IEEE 754 arithmetic without contraction of products and sums: -ffp-contract=off, which is what -std=c99 means to GCC. The only
 * function of others is @SQRT@, correctly rounded everywhere; with -fno-math-errno it is one instruction and no library is linked.
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

#define R(x) @SUFFIX@
#define SQRT(x) @SQRT@(x)
#define ROUND_OFF @ROUND_OFF@
#define GREATEST @GREATEST@

typedef struct { saltus_real first, last, per_unit; uint32_t count; } axis;
typedef struct { uint32_t cell; saltus_real part; } spot;
typedef struct { saltus_real state[4], by_angle[4], by_valve[4]; } lift_off;
typedef struct { saltus_real value, by_angle, by_valve; } linear;

@DATA@

static int is_finite(saltus_real x) { return x >= -GREATEST && x <= GREATEST; }
static int within(saltus_real x, saltus_real low, saltus_real high) { return x >= low && x <= high; }
static saltus_real magnitude(saltus_real x) { return x < 0 ? -x : x; }
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
    if (!is_finite(x)) return SALTUS_SENSOR_INVALID;
    if (!within(x, a->first, a->last)) return SALTUS_OUT_OF_TABLE;
    saltus_real along = (x - a->first) * a->per_unit;
    uint32_t whole = (uint32_t)along, last = a->count - 2;
    out->cell = whole > last ? last : whole;
    out->part = along - (saltus_real)out->cell;
    return SALTUS_OK;
}

static void hermite(saltus_real t, saltus_real w[4]) {
    saltus_real s = t * t;
    saltus_real rise = s * (R(3.0) - (t + t));
    saltus_real half = s * (t - R(1.0));
    w[0] = R(1.0) - rise;
    w[1] = rise;
    w[2] = (half - s) + t;
    w[3] = half;
}

static void hermite_slope(saltus_real t, saltus_real w[4]) {
    saltus_real rise = (t - t * t) * R(6.0);
    saltus_real end = t * (R(3.0) * t - R(2.0));
    w[0] = -rise;
    w[1] = rise;
    w[2] = (end - (t + t)) + R(1.0);
    w[3] = end;
}

/* Value and slope, along the rates, of four numbers at either node. */
static inline void along(const saltus_real u[4], const saltus_real *p, const saltus_real *q, saltus_real out[2]) {
    out[0] = (u[0] * p[0] + u[1] * q[0]) + (u[2] * p[1] + u[3] * q[1]);
    out[1] = (u[0] * p[2] + u[1] * q[2]) + (u[2] * p[3] + u[3] * q[3]);
}

static inline saltus_real mix(const saltus_real f[4], const saltus_real low[2], const saltus_real high[2]) {
    return (f[0] * low[0] + f[1] * high[0]) + (f[2] * low[1] + f[3] * high[1]);
}

@RULE@

static enum saltus_status lift_off_at(saltus_real rate, saltus_real angle, lift_off *out) {
    spot i, j;
    enum saltus_status status = locate(&map_rates, rate, &i);
    if (status) return status;
    status = locate(&map_angles, angle, &j);
    if (status) return status;
    if (!map_open[i.cell * (map_angles.count - 1) + j.cell]) return SALTUS_INFEASIBLE;
    uint32_t first = i.cell * map_angles.count + j.cell, second = first + map_angles.count;
    const saltus_real *a = map_nodes[first], *b = map_nodes[first + 1];
    const saltus_real *c = map_nodes[second], *d = map_nodes[second + 1];
    saltus_real u[4], v[4], w[4];
    hermite(i.part, u);
    hermite(j.part, v);
    hermite_slope(j.part, w);
    for (int k = 0; k < 4; k++) {
        saltus_real low[2], high[2];
        along(u, a + 4 * k, c + 4 * k, low);
        along(u, b + 4 * k, d + 4 * k, high);
        out->state[k] = mix(v, low, high);
        out->by_angle[k] = mix(w, low, high) * map_angles.per_unit;
        saltus_real early = a[16 + k] + i.part * (c[16 + k] - a[16 + k]);
        saltus_real late = b[16 + k] + i.part * (d[16 + k] - b[16 + k]);
        out->by_valve[k] = early + j.part * (late - early);
    }
    return SALTUS_OK;
}

static inline saltus_real landing_by(const saltus_real d[4], saltus_real time, saltus_real vx, saltus_real vy, saltus_real slow) {
    saltus_real later = d[3] / gravity + (vy * d[3] / gravity + d[1]) * slow;
    return d[0] + d[2] * time + vx * later;
}

static enum saltus_status landing(const lift_off *l, saltus_real height, linear *out) {
    saltus_real x = l->state[0], y = l->state[1], vx = l->state[2], vy = l->state[3];
    saltus_real fall = y - height;
    saltus_real square = vy * vy + (gravity + gravity) * fall;
    if (!(square >= 0)) return SALTUS_INFEASIBLE;
    saltus_real speed = SQRT(square);
    saltus_real time = (vy + speed) / gravity;
    if (!(time >= 0)) return SALTUS_INFEASIBLE;
    saltus_real slow = speed > 0 ? R(1.0) / speed : R(0.0);
    out->value = x + vx * time;
    out->by_angle = landing_by(l->by_angle, time, vx, vy, slow);
    out->by_valve = landing_by(l->by_valve, time, vx, vy, slow);
    return SALTUS_OK;
}

static linear distance_to(const lift_off *l, saltus_real x, saltus_real y) {
    saltus_real vx = l->state[2], vy = l->state[3];
    saltus_real rise = vy / gravity;
    saltus_real apex_x = l->state[0] + vx * rise - x, apex_y = l->state[1] + R(0.5) * vy * rise - y;
    saltus_real scale = R(2.0) / (gravity * gravity);
    saltus_real p = scale * (vx * vx - gravity * apex_y), q = scale * (vx * apex_x);
    saltus_real lever = magnitude(q);
    saltus_real reach = p < 0 ? SQRT(-p) : R(0.0);
    saltus_real r = reach + (R(16.0) * lever + R(0.5)) * R(0.33333334);
    for (int k = 0; k < 6; k++) {
        saltus_real square = r * r;
        saltus_real slope = R(3.0) * square + p;
        if (!(slope > 0)) break;
        r = (R(2.0) * square * r + lever) / slope;
    }
    saltus_real s = q > 0 ? -r : r;
    saltus_real across = apex_x + vx * s, up = apex_y - R(0.5) * gravity * (s * s);
    saltus_real distance = SQRT(across * across + up * up);
    saltus_real time = s + rise;
    saltus_real inverse = distance > 0 ? R(1.0) / distance : R(0.0);
    const saltus_real *a = l->by_angle, *b = l->by_valve;
    linear out;
    out.value = distance;
    out.by_angle = (across * (a[0] + a[2] * time) + up * (a[1] + a[3] * time)) * inverse;
    out.by_valve = (across * (b[0] + b[2] * time) + up * (b[1] + b[3] * time)) * inverse;
    return out;
}

enum saltus_status saltus_approach_rate(saltus_sensed sensed, saltus_real *rate) {
    saltus_real horizontal = R(1.5707964);
    if (!(within(sensed.lean, -horizontal, horizontal) && is_finite(sensed.rate))) return SALTUS_SENSOR_INVALID;
    saltus_real square = sensed.rate * sensed.rate + (pendulum + pendulum) * (cosine(sensed.lean) - cosine(start_lean));
    if (!(sensed.rate > 0 && square > 0)) return SALTUS_INFEASIBLE;
    if (!is_finite(square)) return SALTUS_OUT_OF_TABLE;
    *rate = SQRT(square);
    return SALTUS_OK;
}

enum saltus_status saltus_firing_angle(saltus_real rate, saltus_real distance, saltus_real height, saltus_real *out) {
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
        status = landing(&l, height, &x);
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

/* An interval of a line that constraints cut shorter. */
typedef struct { saltus_real low, high; int from_below, from_above; } interval;

static enum saltus_status cut(interval *i, saltus_real slope, saltus_real room, saltus_real doubt, saltus_real size) {
    if (magnitude(slope) <= doubt) return room < -(ROUND_OFF * size) ? SALTUS_INFEASIBLE : SALTUS_OK;
    saltus_real end = room / slope;
    if (slope > 0) {
        if (!i->from_above || end < i->high) i->high = end;
        i->from_above = 1;
    } else {
        if (!i->from_below || end > i->low) i->low = end;
        i->from_below = 1;
    }
    return SALTUS_OK;
}

static enum saltus_status nearest(const interval *i, saltus_real t, saltus_real *out) {
    if (i->from_below && i->from_above) {
        saltus_real size = magnitude(i->low) + magnitude(i->high);
        if (i->low - i->high > ROUND_OFF * size) return SALTUS_INFEASIBLE;
    }
    if (i->from_above && t > i->high) t = i->high;
    if (i->from_below && t < i->low) t = i->low;
    if (!is_finite(t)) return SALTUS_SENSOR_INVALID;
    *out = t;
    return SALTUS_OK;
}

enum saltus_status saltus_qp1(saltus_real h, saltus_real g, const saltus_half_line *c, size_t count, saltus_real *x) {
    saltus_real free = -g / h;
    if (!(h > 0) || !is_finite(free)) return SALTUS_SENSOR_INVALID;
    interval line = {R(0.0), R(0.0), 0, 0};
    for (size_t k = 0; k < count; k++) {
        if (!(is_finite(c[k].slope) && is_finite(c[k].bound))) return SALTUS_SENSOR_INVALID;
        enum saltus_status status = cut(&line, c[k].slope, c[k].bound, R(0.0), magnitude(c[k].bound));
        if (status) return status;
    }
    return nearest(&line, free, x);
}

/* H = L L'; in y = L' x the objective is a squared distance. */
typedef struct { saltus_real i11, l21, i22; } factor;

static inline void turn(const factor *f, saltus_real a0, saltus_real a1, saltus_real out[2]) {
    out[0] = a0 * f->i11;
    out[1] = (a1 - f->l21 * out[0]) * f->i22;
}

static enum saltus_status on_border(const factor *f, const saltus_real n[2], saltus_real bound, const saltus_real free[2],
                                    const saltus_half_plane *c, size_t count, saltus_real out[2]) {
    saltus_real square = n[0] * n[0] + n[1] * n[1];
    if (!(square > 0)) return SALTUS_INFEASIBLE;
    saltus_real lever = ((n[0] * free[0] + n[1] * free[1]) - bound) / square;
    saltus_real foot[2] = {free[0] - lever * n[0], free[1] - lever * n[1]};
    interval line = {R(0.0), R(0.0), 0, 0};
    for (size_t k = 0; k < count; k++) {
        saltus_real o[2];
        turn(f, c[k].normal[0], c[k].normal[1], o);
        saltus_real slope = o[1] * n[0] - o[0] * n[1];
        saltus_real p = o[0] * foot[0], q = o[1] * foot[1];
        saltus_real size = magnitude(c[k].bound) + magnitude(p) + magnitude(q);
        saltus_real doubt = ROUND_OFF * (magnitude(o[1] * n[0]) + magnitude(o[0] * n[1]));
        enum saltus_status status = cut(&line, slope, c[k].bound - (p + q), doubt, size);
        if (status) return status;
    }
    saltus_real t;
    enum saltus_status status = nearest(&line, R(0.0), &t);
    if (status) return status;
    out[0] = foot[0] - t * n[1];
    out[1] = foot[1] + t * n[0];
    return SALTUS_OK;
}

enum saltus_status saltus_qp2(const saltus_real h[3], const saltus_real g[2], const saltus_half_plane *c, size_t count,
                              saltus_real x[2]) {
    if (!(h[0] > 0 && is_finite(h[0]) && is_finite(h[2]))) return SALTUS_SENSOR_INVALID;
    factor f;
    f.i11 = R(1.0) / SQRT(h[0]);
    f.l21 = h[1] * f.i11;
    saltus_real rest = h[2] - f.l21 * f.l21;
    if (!(rest > ROUND_OFF * h[2])) return SALTUS_SENSOR_INVALID;
    f.i22 = R(1.0) / SQRT(rest);
    saltus_real free[2], best[2];
    turn(&f, -g[0], -g[1], free);
    if (!(is_finite(free[0]) && is_finite(free[1]))) return SALTUS_SENSOR_INVALID;
    best[0] = free[0];
    best[1] = free[1];
    for (size_t k = 0; k < count; k++) {
        saltus_real n[2];
        turn(&f, c[k].normal[0], c[k].normal[1], n);
        if (!(is_finite(n[0]) && is_finite(n[1]) && is_finite(c[k].bound))) return SALTUS_SENSOR_INVALID;
        saltus_real p = n[0] * best[0], q = n[1] * best[1];
        saltus_real size = magnitude(c[k].bound) + magnitude(p) + magnitude(q);
        if ((p + q) - c[k].bound <= ROUND_OFF * size) continue;
        enum saltus_status status = on_border(&f, n, c[k].bound, free, c, k, best);
        if (status) return status;
    }
    saltus_real second = best[1] * f.i22;
    saltus_real first = (best[0] - f.l21 * second) * f.i11;
    if (!(is_finite(first) && is_finite(second))) return SALTUS_SENSOR_INVALID;
    x[0] = first;
    x[1] = second;
    return SALTUS_OK;
}

/* Landing, and the wheel's clearances over the front and the back corner. */
static enum saltus_status lengths(saltus_real rate, saltus_real angle, saltus_real valve_open, const saltus_task *task,
                                  linear out[3]) {
    lift_off l;
    const saltus_obstacle *o = task->obstacle;
    enum saltus_status status = lift_off_at(rate, angle, &l);
    if (status) return status;
    saltus_real more = valve_open - nominal_valve_open;
    for (int k = 0; k < 4; k++) l.state[k] = l.state[k] + more * l.by_valve[k];
    status = landing(&l, task->landing_height, &out[0]);
    if (status) return status;
    out[1] = distance_to(&l, o->front, o->height);
    out[1].value = out[1].value - radius;
    out[2] = distance_to(&l, o->back, o->height);
    out[2].value = out[2].value - radius;
    return SALTUS_OK;
}

static enum saltus_status qp_step(saltus_real angle, saltus_real valve_open, const saltus_task *task, const linear l[3],
                                  saltus_real step[2]) {
    const saltus_obstacle *o = task->obstacle;
    saltus_real high = lesser(R(0.125), map_angles.last - angle);
    saltus_real low = greater(-R(0.125), map_angles.first - angle);
    saltus_real off = l[0].value - task->distance;
    saltus_real beyond = l[0].value - o->back;
    saltus_real over_first = l[1].value - o->clearance, over_second = l[2].value - o->clearance;
    saltus_real j = l[0].by_angle, k = l[0].by_valve;
    if (!(greatest_valve_open > least_valve_open)) {
        saltus_half_line c[5] = {
            {-l[1].by_angle, over_first}, {-l[2].by_angle, over_second}, {-l[0].by_angle, beyond}, {R(1.0), high}, {-R(1.0), -low},
        };
        step[1] = R(0.0);
        return saltus_qp1(j * j, j * off, c, 5, &step[0]);
    }
    saltus_half_plane c[7] = {
        {{-l[1].by_angle, -l[1].by_valve}, over_first},
        {{-l[2].by_angle, -l[2].by_valve}, over_second},
        {{-l[0].by_angle, -l[0].by_valve}, beyond},
        {{R(1.0), R(0.0)}, high},
        {{-R(1.0), R(0.0)}, -low},
        {{R(0.0), R(1.0)}, greatest_valve_open - valve_open},
        {{R(0.0), -R(1.0)}, valve_open - least_valve_open},
    };
    saltus_real h[3] = {j * j, j * k, k * k + effort};
    saltus_real g[2] = {j * off, k * off + effort * valve_open};
    return saltus_qp2(h, g, c, 7, step);
}

static enum saltus_status over(saltus_real rate, saltus_real *angle, saltus_real *valve_open, const saltus_task *task) {
    const saltus_obstacle *o = task->obstacle;
    linear l[3];
    if (!(is_finite(o->front) && is_finite(o->back) && is_finite(o->height) && is_finite(o->clearance))) return SALTUS_SENSOR_INVALID;
    if (!(o->front < o->back && o->height >= 0 && o->clearance >= 0)) return SALTUS_SENSOR_INVALID;
    for (int k = 0; k < 2; k++) {
        saltus_real step[2];
        enum saltus_status status = lengths(rate, *angle, *valve_open, task, l);
        if (status) return status;
        status = qp_step(*angle, *valve_open, task, l, step);
        if (status) return status;
        *angle = *angle + step[0];
        *valve_open = *valve_open + step[1];
    }
    enum saltus_status status = lengths(rate, *angle, *valve_open, task, l);
    if (status) return status;
    saltus_real least = o->clearance - R(0.002);
    int clears = l[1].value >= least && l[2].value >= least && l[0].value >= o->back - R(0.002);
    return clears ? SALTUS_OK : SALTUS_INFEASIBLE;
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
    enum saltus_status status = saltus_approach_rate(*sensed, &d.approach_rate);
    if (status) return status;
    status = saltus_firing_angle(d.approach_rate, task->distance, task->landing_height, &d.firing_angle);
    if (status) return status;
    d.valve_open = nominal_valve_open;
    if (task->obstacle != NULL) {
        status = over(d.approach_rate, &d.firing_angle, &d.valve_open, task);
        if (status) return status;
    }
    status = timing(sensed, d.firing_angle, &d);
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
    if (lift_off_at(rate, angle, &l) || landing(&l, radius, &x)) return out;
    saltus_real back = front + a->length;
    saltus_real first = distance_to(&l, front, a->height).value - radius;
    saltus_real second = distance_to(&l, back, a->height).value - radius;
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

enum saltus_status saltus_choose_take_off(const saltus_approach *a, saltus_take_off *out) {
    if (!(is_finite(a->distance) && is_finite(a->height) && is_finite(a->speed) && is_finite(a->length))) return SALTUS_SENSOR_INVALID;
    if (!(a->length > 0 && a->height >= 0 && a->clearance >= 0 && is_finite(a->clearance))) return SALTUS_SENSOR_INVALID;
    saltus_real rate = a->speed / radius;
    if (!within(rate, map_rates.first, map_rates.last)) return SALTUS_OUT_OF_TABLE;
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
        return SALTUS_OK;
    }
    return front >= radius + a->clearance ? SALTUS_OUT_OF_TABLE : SALTUS_INFEASIBLE;
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
