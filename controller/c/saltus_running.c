@HEADER@
/*
 * C99. IEEE 754 arithmetic without contraction of products and sums: -ffp-contract=off, which is what -std=c99 means to GCC. The only
 * functions of others are @SQRT@ and @ABS@, exact or correctly rounded everywhere. Link with -lm; with -fno-math-errno each is one instruction
 * where the processor has a root, and no library is needed.
 * Nothing allocates, recurses, or loops more often than a constant says.
 */
#include "saltus_running.h"

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
#define ABS(x) @ABS@(x)
#define GREATEST @GREATEST@
#define GREAT @GREAT@
#define PI R(3.141592653589793)

#define LEAST_LEGS 3
#define MOST_LEGS 12
/* How far (rad) behind its zone a leg leaves it: more than round-off, less than a count. */
#define BACK R(1e-5)

static int within(saltus_real x, saltus_real low, saltus_real high) { return x >= low && x <= high; }
static int is_finite(saltus_real x) { return ABS(x) <= GREATEST; }
static saltus_real lesser(saltus_real a, saltus_real b) { return b < a ? b : a; }
static saltus_real greater(saltus_real a, saltus_real b) { return b > a ? b : a; }

/* Whole numbers that go round. */
static int32_t round_to(uint32_t x) { return x <= INT32_MAX ? (int32_t)x : -(int32_t)~x - 1; }
static int32_t plus(int32_t a, int32_t b) { return round_to((uint32_t)a + (uint32_t)b); }
static int32_t minus(int32_t a, int32_t b) { return round_to((uint32_t)a - (uint32_t)b); }
static int32_t times(int32_t a, int32_t b) { return round_to((uint32_t)a * (uint32_t)b); }

static uint32_t length_of(int32_t x) { return x < 0 ? 0u - (uint32_t)x : (uint32_t)x; }

static saltus_real number(uint32_t count) { return (saltus_real)(int32_t)(count > INT32_MAX ? INT32_MAX : count); }

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

static saltus_real hyperbolic_tangent(saltus_real x) {
    if (ABS(x) > R(20.0)) return x > 0 ? R(1.0) : -R(1.0);
    saltus_real y = (x + x) / R(256.0), p = R(1.0);
    for (uint32_t k = 0; k < 8; k++) p = R(1.0) + p * (y / (saltus_real)(9 - k));
    p = p * y;
    for (int k = 0; k < 8; k++) p = p * (p + R(2.0));
    return p / (p + R(2.0));
}

/* Firing angle and valve opening time between two, a part of the way. */
static void mix(saltus_real part, saltus_real angle, saltus_real open, saltus_real next_angle, saltus_real next_open, saltus_real out[2]) {
    out[0] = angle + part * (next_angle - angle);
    out[1] = open + part * (next_open - open);
}

static void lines(const saltus_law *law, saltus_real rate, saltus_real out[2]) {
    if (law->count == 0 || !is_finite(rate)) return;
    const saltus_knot *first = &law->knots[0], *last = &law->knots[law->count - 1];
    const saltus_knot *level = rate >= last->rate ? last : rate < first->rate ? first : NULL;
    if (level != NULL) {
        out[0] = level->firing_angle;
        out[1] = level->valve_open;
        return;
    }
    const saltus_knot *before = first;
    for (uint32_t k = 0; k < law->count; k++) {
        const saltus_knot *next = &law->knots[k];
        if (next->rate > rate) {
            saltus_real part = (rate - before->rate) / (next->rate - before->rate);
            mix(part, before->firing_angle, before->valve_open, next->firing_angle, next->valve_open, out);
            return;
        }
        before = next;
    }
}

/* Beside a number so great only whole ones lie, and its last bits count them. */
static saltus_real beside_great(saltus_real along) { return (along - R(0.5)) + GREAT; }

static uint32_t whole(saltus_real beside) {
    @BITS@ bits;
    memcpy(&bits, &beside, sizeof bits);
    return (uint32_t)(bits & 0x3FFFFF);
}

/* Firing angle (rad) and valve opening time (s). What is not a number fires never. */
static void law_at(const saltus_law *law, saltus_real time, saltus_real rate, saltus_real out[2]) {
    out[0] = PI;
    out[1] = R(0.0);
    if (law->kind == SALTUS_OVER_TIME) {
        out[0] = law->amplitude * hyperbolic_tangent(law->slope * time - law->shift) + law->level;
        out[1] = law->valve_open;
    } else {
        lines(law, rate, out);
    }
}

static saltus_real gyro(const saltus_instruments *i, const saltus_readings *readings) {
    int32_t fine = readings->fine_gyro;
    if (fine < i->fine_limit && fine > minus(0, i->fine_limit)) return (saltus_real)fine * i->fine_gyro;
    return (saltus_real)readings->coarse_gyro * i->coarse_gyro;
}

/* The filtered rate (rad/s), with a cycle's readings. */
static saltus_real filtered(saltus_runner *r, const saltus_readings *readings) {
    saltus_real rate = gyro(&r->gait->instruments, readings), sum = R(0.0);
    r->newest = r->newest == 0 ? SALTUS_MOST_TAPS - 1 : r->newest - 1;
    if (!r->is_read) {
        for (int k = 0; k < SALTUS_MOST_TAPS; k++) r->past[k] = rate;
        r->is_read = 1;
    }
    r->past[r->newest] = rate;
    uint32_t at = r->newest;
    for (uint32_t k = 0; k < r->gait->tap_count && k < SALTUS_MOST_TAPS; k++) {
        sum = sum + r->gait->taps[k] * r->past[at];
        at = at + 1 == SALTUS_MOST_TAPS ? 0 : at + 1;
    }
    return sum;
}

/* Counts of a turn in the direction of the run. */
static int32_t turn(const saltus_runner *r) { return times(r->gait->instruments.wheel_turn, r->direction); }

/* Lean (rad) of the leg that was last in the zone. */
static saltus_real lean_of(const saltus_runner *r, int32_t wheel) {
    saltus_real turned = (saltus_real)times(minus(wheel, r->base), r->direction) * r->gait->instruments.wheel;
    return turned + r->offset - number(r->leg) * r->pitch;
}

/* Finds the leg in the zone; its lean (rad). */
static saltus_real find_leg(saltus_runner *r, int32_t wheel) {
    saltus_real low = r->gait->zone, high = low + r->pitch, back = low - BACK;
    saltus_real lean = lean_of(r, wheel);
    /* A cycle is too short for more than a turn; whatever the counter says, this ends. */
    for (int k = 0; k < 13; k++) {
        if (lean >= high) {
            r->leg++;
            if (r->leg >= r->legs) {
                r->leg = 0;
                r->base = plus(r->base, turn(r));
            }
        } else if (lean < back) {
            if (r->leg == 0) {
                r->leg = r->legs;
                r->base = minus(r->base, turn(r));
            }
            r->leg--;
        } else {
            break;
        }
        r->has_fired = 0;
        r->enters = 1;
        lean = lean_of(r, wheel);
    }
    return lean;
}

/* Firings count from 0 again, no foot has come down since, and no jump is under way. */
static void begin_anew(saltus_runner *r) {
    r->firings = 0;
    r->since_shock = UINT32_MAX;
    r->touched = R(0.0);
    r->is_touched = 0;
    r->is_leaping = 0;
}

/* Nothing is seen. */
static void forget(saltus_runner *r) {
    r->distance = R(0.0);
    r->reading = R(0.0);
    r->readings = 0;
    r->is_seen = 0;
    r->is_read_now = 0;
    r->is_counted = 0;
    r->backs_off = 0;
}

void saltus_runner_start(saltus_runner *r, const saltus_gait *gait, uint32_t rear, int32_t wheel, int forwards) {
    int is_sound = gait->legs >= LEAST_LEGS && gait->legs <= MOST_LEGS && rear < gait->legs;
    r->gait = gait;
    r->newest = 0;
    r->is_read = 0;
    r->cycles = 0;
    r->still = 0;
    /* Without legs the pitch is infinite, and no lean is a number. */
    r->legs = is_sound ? gait->legs : 0;
    r->leg = is_sound ? rear : 0;
    saltus_real half = PI / number(r->legs);
    r->base = wheel;
    r->offset = half + (half + half) * number(r->leg);
    r->pitch = half + half;
    r->direction = 1;
    r->has_fired = 0;
    r->enters = 1;
    r->demand = R(0.0);
    r->sum = R(0.0);
    r->speed = R(0.0);
    r->last_radius = 0;
    r->is_measured = 0;
    forget(r);
    r->seen_radius = 0;
    r->stands_at = 0;
    r->is_standing_known = 0;
    r->has_choice = 0;
    r->choice_leaps = 0;
    begin_anew(r);
    if (!forwards) saltus_runner_turn_round(r, wheel);
}

void saltus_runner_demand(saltus_runner *r, saltus_real speed) { r->demand = speed; }

void saltus_runner_sense(saltus_runner *r, saltus_real distance) {
    r->is_read_now = distance > 0 && is_finite(distance);
    r->reading = distance;
}

/* Legs and leans are mirrored from now on. */
static void mirror(saltus_runner *r, int32_t wheel) {
    r->offset = -r->offset;
    r->direction = -r->direction;
    /* Leg k of now is leg n - k then; as legs are counted from 0 to n - 1, a turn lies between. */
    if (r->leg != 0) {
        r->leg = r->legs - r->leg;
        r->base = minus(r->base, turn(r));
    }
    r->has_fired = 0;
    r->sum = R(0.0);
    r->speed = R(0.0);
    begin_anew(r);
    r->has_choice = 0;
    r->enters = 1;
    find_leg(r, wheel);
}

void saltus_runner_turn_round(saltus_runner *r, int32_t wheel) {
    forget(r);
    mirror(r, wheel);
}

/* Takes a reading of the range sensor. */
static void take(saltus_runner *r, const saltus_ahead *ahead, saltus_real reading) {
    /* What is beneath the robot is not seen: the reading is of the next obstacle. */
    if (r->is_seen && !(r->distance > 0)) return;
    if (r->is_seen && ABS(reading - r->distance) <= ahead->same) {
        r->readings = r->readings + 1 < 1000 ? r->readings + 1 : 1000;
        saltus_real weight = greater(R(1.0) / (saltus_real)r->readings, ahead->least_weight);
        r->distance = r->distance + weight * (reading - r->distance);
        return;
    }
    r->distance = reading;
    r->is_seen = 1;
    r->readings = 1;
}

/* The distance to the obstacle ahead in this cycle, if one is seen. A jump over it ends once it is behind; a robot at rest that has too little
 * room turns away from it. */
static void look(saltus_runner *r, const saltus_readings *readings) {
    const saltus_ahead *ahead = r->gait->ahead;
    if (ahead == NULL) return;
    if (!r->is_standing_known) r->stands_at = readings->pivot;
    r->is_standing_known = 1;
    int32_t counts = r->is_counted ? minus(readings->radius, r->seen_radius) : 0;
    r->seen_radius = readings->radius;
    r->is_counted = 1;
    saltus_real way = (saltus_real)times(counts, r->backs_off ? -r->direction : r->direction) * ahead->way;
    if (r->is_seen) {
        r->distance = r->distance - way;
        r->is_seen = r->distance >= ahead->distance_first;
    }
    if (r->is_read_now) take(r, ahead, r->reading);
    r->is_read_now = 0;
    if (!r->is_seen) r->is_leaping = 0;
    if (r->is_seen && r->distance < ahead->room && !r->backs_off && r->firings == 0 && !r->gait->holds) {
        r->backs_off = 1;
        mirror(r, readings->wheel);
    }
}

/* Whether it has run far enough away from the obstacle. */
static int has_room(const saltus_runner *r) {
    return r->gait->ahead != NULL && r->backs_off && (!r->is_seen || r->distance >= r->gait->ahead->room);
}

/* The cell between `count` ends in which `x` lies, and whether there is one. */
static int cell_of(saltus_real x, saltus_real first, saltus_real last, saltus_real per_unit, uint32_t count, uint32_t *cell) {
    if (!within(x, first, last) || count < 2) return 0;
    uint32_t index = whole(beside_great((x - first) * per_unit));
    *cell = index > count - 2 ? count - 2 : index;
    return 1;
}

/* What the leg that enters the zone at `rate` does about the obstacle. */
static void choose(saltus_runner *r, saltus_real rate, int32_t pivot) {
    const saltus_ahead *a = r->gait->ahead;
    uint32_t row, level, column, cell;
    r->has_choice = 0;
    if (a == NULL || r->backs_off || !r->is_seen) return;
    saltus_real fast = lesser(greater(rate, a->rate_first), a->rate_last);
    saltus_real height = (saltus_real)minus(pivot, r->stands_at) * a->climb;
    height = lesser(greater(height, a->height_first), a->height_last);
    if (!cell_of(fast, a->rate_first, a->rate_last, a->rates_per_unit, a->rate_count, &row)) return;
    if (!cell_of(height, a->height_first, a->height_last, a->heights_per_unit, a->height_count, &level)) return;
    if (!cell_of(r->distance, a->distance_first, a->distance_last, a->distances_per_unit, a->distance_count, &column)) return;
    cell = (row * (a->height_count - 1) + level) * (a->distance_count - 1) + column;
    if (cell >= a->cell_count || a->cells[cell] >= a->choice_count) return;
    r->choice[0] = a->choices[a->cells[cell]][0];
    r->choice[1] = a->choices[a->cells[cell]][1];
    r->choice_leaps = a->cells[cell] >= a->first_leap;
    r->has_choice = 1;
}

/* Notes the rate a few cycles after a foot has come down, when the filter has forgotten the impact. */
static void feel(saltus_runner *r, const saltus_readings *readings, saltus_real rate) {
    const saltus_gait *gait = r->gait;
    if (!gait->leaps) return;
    uint32_t forward = length_of(readings->coarse_accelerometer[0]), up = length_of(readings->coarse_accelerometer[1]);
    uint32_t taps = gait->tap_count < SALTUS_MOST_TAPS ? gait->tap_count : SALTUS_MOST_TAPS;
    if (gait->leap.shock > 0 && (forward > up ? forward : up) >= (uint32_t)gait->leap.shock) {
        r->since_shock = 0;
    } else if (r->since_shock != UINT32_MAX) {
        r->since_shock++;
    }
    if (r->since_shock == taps) {
        r->touched = rate;
        r->is_touched = 1;
    }
}

/* Firing angle (rad) and valve opening time (s) of the leap; whether the next firing is it. */
static int leaps(const saltus_runner *r, saltus_real rate, saltus_real out[2]) {
    const saltus_leap *leap = &r->gait->leap;
    if (!r->gait->leaps || leap->after != r->firings || r->gait->first_count > r->firings) return 0;
    saltus_real angle = leap->slope * (r->is_touched ? r->touched : rate) + leap->level;
    out[0] = lesser(greater(angle, leap->least), leap->most);
    out[1] = leap->valve_open;
    return 1;
}

/* Firing angle (rad) and valve opening time (s) of the next firing, unless it is the leap: for the obstacle ahead, one of the first, or by the
 * law at `rate`. */
static void next_firing(const saltus_runner *r, saltus_real time, saltus_real rate, saltus_real out[2]) {
    const saltus_gait *gait = r->gait;
    if (r->has_choice) {
        out[0] = r->choice[0];
        out[1] = r->choice[1];
    } else if (r->firings < gait->first_count) {
        out[0] = gait->first[r->firings][0];
        out[1] = gait->first[r->firings][1];
    } else {
        law_at(&gait->law, time, rate, out);
    }
}

/* The demanded speed (m/s) in the direction of the run, and by how much later (rad) it lets a leg fire; whether it is to run. */
static int held(saltus_runner *r, int32_t radius, saltus_real *demand, saltus_real *later) {
    const saltus_hold *hold = &r->gait->hold;
    int32_t counts = r->is_measured ? minus(radius, r->last_radius) : 0;
    r->last_radius = radius;
    r->is_measured = 1;
    saltus_real way = (saltus_real)times(counts, r->direction) * hold->way;
    r->speed = r->speed + hold->renewed * (way / r->gait->period - r->speed);
    *demand = r->demand * (saltus_real)r->direction;
    if (!(*demand > 0)) {
        r->sum = R(0.0);
        return 0;
    }
    saltus_real lacking = *demand - r->speed;
    if (lacking > hold->ahead) {
        r->sum = R(0.0);
        *demand = r->speed + hold->ahead;
        *later = R(0.0);
        return 1;
    }
    saltus_real sum = r->sum + lacking * r->gait->period;
    r->sum = lesser(greater(sum, -hold->most_sum), hold->most_sum);
    *later = -(hold->by_error * lacking + hold->by_sum * r->sum);
    return 1;
}

/* Counts the time for which it stands still. */
static int stands_still(saltus_runner *r, saltus_real rate) {
    const saltus_stall *stall = &r->gait->stall;
    if (ABS(rate) >= stall->rate) {
        r->still = 0;
        return 0;
    }
    if (r->still != UINT32_MAX) r->still++;
    int stalled = number(r->still) * r->gait->period >= stall->time;
    if (stalled && stall->restarts) {
        r->has_fired = 0;
        r->still = 0;
        begin_anew(r);
    }
    return stalled;
}

void saltus_runner_step(saltus_runner *r, const saltus_readings *readings, saltus_action *action) {
    const saltus_gait *gait = r->gait;
    look(r, readings);
    saltus_real lean = find_leg(r, readings->wheel);
    saltus_real rate = filtered(r, readings) * (saltus_real)r->direction;
    if (r->enters) {
        r->enters = 0;
        choose(r, rate, readings->pivot);
    }
    saltus_real time = number(r->cycles) * gait->period, firing[2] = {PI, R(0.0)}, demand = R(0.0), later = R(0.0);
    if (r->cycles != UINT32_MAX) r->cycles++;
    feel(r, readings, rate);
    /* First, so that a restart begins with the first firings. */
    int stalled = stands_still(r, rate), roomy = has_room(r);
    if ((!gait->holds || held(r, readings->radius, &demand, &later)) && !leaps(r, rate, firing) && !r->is_leaping && !roomy) {
        next_firing(r, time, gait->holds ? demand : rate, firing);
        if (gait->holds && !r->has_choice) firing[0] = greater(firing[0] + later, gait->zone);
    }
    action->in_zone = r->direction > 0 || r->leg == 0 ? r->leg : r->legs - r->leg;
    int fires = !r->has_fired && lean >= firing[0] && firing[1] > 0;
    if (fires) {
        r->has_fired = 1;
        if (r->firings != UINT32_MAX) r->firings++;
        r->is_touched = 0;
        if (r->has_choice && r->choice_leaps) r->is_leaping = 1;
    }
    if (stalled && gait->holds && r->demand * (saltus_real)r->direction < 0) {
        saltus_runner_turn_round(r, readings->wheel);
    } else if (stalled && roomy) {
        r->backs_off = 0;
        mirror(r, readings->wheel);
    }
    action->leg = fires ? (int32_t)action->in_zone : -1;
    action->valve_open = fires ? firing[1] : R(0.0);
    action->lean = lean;
    action->rate = rate;
    action->firing_angle = firing[0];
    action->stalled = stalled;
}

void saltus_standing_take(saltus_standing *s, const saltus_instruments *instruments, const saltus_readings *readings) {
    if (s->count >= 250) return;
    int32_t limit = instruments->accelerometer_limit;
    for (int k = 0; k < 2; k++) {
        int32_t reading = readings->fine_accelerometer[k];
        if (reading >= limit || reading <= minus(0, limit)) s->is_saturated = 1;
        s->sums[k] = plus(s->sums[k], reading);
    }
    s->fastest = greater(s->fastest, ABS(gyro(instruments, readings)));
    s->count++;
}

/* sin x and cos x for 0 <= x <= 2.2, by the half angle. */
static saltus_real sine_of(saltus_real x) {
    saltus_real half = x * R(0.5);
    return R(2.0) * sine(half) * cosine(half);
}

static saltus_real cosine_of(saltus_real x) {
    saltus_real s = sine(x * R(0.5));
    return R(1.0) - R(2.0) * s * s;
}

enum saltus_standing_status saltus_rear_leg(const saltus_standing *standing, const saltus_gait *gait, saltus_real gravity, uint32_t *leg) {
    if (standing->count < 100) return SALTUS_STANDING_ASK_LATER;
    if (standing->is_saturated) return SALTUS_STANDING_SATURATED;
    if (standing->fastest > R(0.8)) return SALTUS_STANDING_MOVING;
    saltus_real scale = gait->instruments.fine_accelerometer / (saltus_real)standing->count;
    saltus_real forward = (saltus_real)standing->sums[0] * scale, up = (saltus_real)standing->sums[1] * scale;
    saltus_real length = SQRT(forward * forward + up * up);
    saltus_real off = R(0.15) * gravity;
    if (!within(length - gravity, -off, off)) return SALTUS_STANDING_MOVING;
    if (!(gait->legs >= LEAST_LEGS && gait->legs <= MOST_LEGS)) return SALTUS_STANDING_BETWEEN;
    /* A unit vector up, in the wheel's axes, turns backwards as the wheel leans forwards. */
    uint32_t best = 0;
    saltus_real most = -R(2.0), half = PI / number(gait->legs);
    saltus_real s = sine_of(half), c = cosine_of(half), turn_s = sine_of(half + half), turn_c = cosine_of(half + half);
    for (uint32_t k = 0; k < gait->legs; k++) {
        saltus_real along = (up * c - forward * s) / length, next = s * turn_c + c * turn_s;
        if (along > most) {
            best = k;
            most = along;
        }
        c = c * turn_c - s * turn_s;
        s = next;
    }
    if (!(most >= cosine_of(lesser(half * R(0.8), R(0.45))))) return SALTUS_STANDING_BETWEEN;
    *leg = best;
    return SALTUS_STANDING_OK;
}
