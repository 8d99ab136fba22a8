/*
 * The drill of running: wheels that roll, turn back, rock and stand, under every law, and a hash of every bit of what is decided. The example
 * `running_drill` of the crate does the same in Rust.
 */
#include <string.h>

#include "counted.h"
#include "saltus_running.h"

#ifndef CYCLES
#define CYCLES 1000000
#endif
/* Cycles of a run. */
#define RUN 1000

#define N(x) ((saltus_real)(x))

static uint32_t state = 1;

static uint32_t word(void) {
    state = state * 2891336453u + 12345u;
    return state >> 8;
}

/* From -most to most. */
static int32_t up_to(int32_t most) { return (int32_t)(word() % (uint32_t)(2 * most + 1)) - most; }
static int one_in(uint32_t n) { return word() % n == 0; }
/* From low to high, in steps of the difference over 2^24. */
static saltus_real between(saltus_real low, saltus_real high) { return low + (high - low) * ((saltus_real)word() / N(16777216)); }

static uint32_t hash = 2166136261u, knew;

static void mix_word(uint32_t x) {
    for (int k = 0; k < 4; k++) hash = (hash ^ ((x >> (8 * k)) & 0xFFu)) * 16777619u;
}
static void mix_real(saltus_real x) {
    uint32_t words[sizeof x / 4];
    memcpy(words, &x, sizeof x);
    for (size_t k = 0; k < sizeof x / 4; k++) mix_word(words[k]);
}

static const saltus_real taps[5] = {N(0.2), N(0.2), N(0.2), N(0.2), N(0.2)};
static saltus_knot knots[4];
static saltus_real first[2][2];
static saltus_gait gait;

/* Cells of the table for an obstacle. */
#define ROWS 5
#define LEVELS 3
#define COLUMNS 12
static uint8_t cells[ROWS * LEVELS * COLUMNS];
static saltus_real choices[5][2];
static saltus_ahead ahead;

static void draw_ahead(void) {
    /* The last choice is of no leg; the one before it does not fire. */
    for (int k = 0; k < ROWS * LEVELS * COLUMNS; k++) cells[k] = (uint8_t)(word() % 6);
    for (int k = 0; k < 5; k++) {
        choices[k][0] = between(N(-0.2), N(0.2));
        choices[k][1] = between(N(0.02), N(0.06));
    }
    choices[4][1] = N(0.0);
    ahead.way = N(0.0086);
    ahead.climb = N(0.0083);
    ahead.least_weight = N(0.1);
    ahead.same = N(0.3);
    ahead.room = one_in(2) ? N(0.0) : between(N(0.0), N(2.0));
    ahead.rate_first = N(-1.0);
    ahead.rate_last = N(9.0);
    ahead.rates_per_unit = N(ROWS) / (ahead.rate_last - ahead.rate_first);
    ahead.rate_count = ROWS + 1;
    ahead.height_first = N(0.0);
    ahead.height_last = N(0.12);
    ahead.heights_per_unit = N(LEVELS) / (ahead.height_last - ahead.height_first);
    ahead.height_count = LEVELS + 1;
    ahead.distance_first = N(-0.5);
    ahead.distance_last = N(2.5);
    ahead.distances_per_unit = N(COLUMNS) / (ahead.distance_last - ahead.distance_first);
    ahead.distance_count = COLUMNS + 1;
    ahead.cells = cells;
    ahead.cell_count = ROWS * LEVELS * COLUMNS;
    ahead.choices = (const saltus_real(*)[2])choices;
    ahead.choice_count = 5;
    ahead.first_leap = 3;
    gait.ahead = one_in(2) ? &ahead : NULL;
}

static void draw_gait(uint32_t run) {
    gait.legs = 3 + run % 10;
    gait.law.kind = run % 4 == 0 ? SALTUS_OVER_TIME : SALTUS_LINES;
    gait.law.amplitude = between(N(-0.2), N(0.2));
    gait.law.slope = between(N(1.0), N(20.0));
    gait.law.shift = between(N(0.0), N(4.0));
    gait.law.level = between(N(0.0), N(0.1));
    gait.law.valve_open = N(0.04);
    /* The second and the third knot are a jump. */
    for (int k = 0; k < 4; k++) {
        knots[k].rate = k == 0 ? N(0.0) : k == 2 ? knots[1].rate : knots[k - 1].rate + between(N(0.5), N(6.0));
        knots[k].firing_angle = between(N(-0.2), N(0.2));
        knots[k].valve_open = between(N(0.02), N(0.06));
    }
    gait.law.knots = knots;
    gait.law.count = 4;
    gait.zone = between(N(-0.26), N(0.26));
    gait.taps = taps;
    gait.tap_count = 5;
    for (int k = 0; k < 2; k++) {
        first[k][0] = between(N(-0.2), N(0.2));
        first[k][1] = between(N(0.02), N(0.06));
    }
    gait.first = (const saltus_real(*)[2])first;
    gait.first_count = word() % 3;
    gait.holds = one_in(2);
    gait.leaps = one_in(2);
    gait.leap.after = word() % 4;
    gait.leap.slope = between(N(-0.1), N(0.1));
    gait.leap.level = between(N(-0.1), N(0.1));
    gait.leap.least = N(-0.1);
    gait.leap.most = N(0.1);
    gait.leap.valve_open = N(0.05);
    gait.leap.shock = up_to(20000) + 15000;
    draw_ahead();
    gait.stall.restarts = run % 3 == 0;
}

/* A wheel: 64ths of counts, and of counts in a cycle. */
static int32_t place, rate, wanted;

static void roll(saltus_readings *r) {
    if (one_in(400)) wanted = one_in(4) ? 0 : up_to(140);
    if (one_in(3)) rate += rate < wanted ? 1 : rate > wanted ? -1 : 0;
    place += rate;
    /* Now and then the wheel is knocked, or the counter errs by up to a turn. */
    if (one_in(200)) place += up_to(300);
    if (one_in(2000)) place += up_to(800 * 64);
    int32_t fine = rate * 402 + up_to(90), end = 32767;
    r->fine_gyro = fine > end ? end : fine < -end ? -end : fine;
    r->coarse_gyro = rate * 154 + up_to(90);
    r->wheel = (place + up_to(40)) >> 6;
    r->radius = (place + up_to(40)) >> 8;
    r->pivot = up_to(12) + 10;
    int32_t most = one_in(50) ? 32767 : 500;
    r->coarse_accelerometer[0] = up_to(most);
    r->coarse_accelerometer[1] = up_to(most);
}

/* Which leg a robot at rest stands on, by what its accelerometer says; a leg that it has where it cannot tell. */
static uint32_t stand(void) {
    saltus_standing standing = {{0, 0}, 0, N(0.0), 0};
    saltus_readings r;
    memset(&r, 0, sizeof r);
    int32_t forward = up_to(16000), up = up_to(16000), noise = one_in(4) ? 8000 : 300;
    uint32_t readings = one_in(9) ? 99 : 200, leg = 0;
    /* A third of the length is of that of gravity for sure. */
    if (!one_in(3)) {
        up = forward < 0 ? 15500 + forward / 3 : 15500 - forward / 3;
        if (one_in(2)) up = -up;
        forward = forward / 2;
    }
    for (uint32_t k = 0; k < readings; k++) {
        r.fine_accelerometer[0] = forward + up_to(noise);
        r.fine_accelerometer[1] = up + up_to(noise);
        r.fine_gyro = up_to(one_in(4000) ? 3000 : 300);
        saltus_standing_take(&standing, &gait.instruments, &r);
    }
    enum saltus_standing_status status = saltus_rear_leg(&standing, &gait, N(9.81), &leg);
    mix_word((uint32_t)status);
    knew += status == SALTUS_STANDING_OK;
    if (status != SALTUS_STANDING_OK) leg = word() % gait.legs;
    mix_word(leg);
    return leg;
}

/* Bytes of the stack that a cycle takes; what is not painted, 256 of them, counts as taken. */
__attribute__((noinline)) static uint32_t stack_of(saltus_runner *runner, const saltus_readings *readings) {
    static saltus_action action;
    uint32_t top;
    paint();
    saltus_runner_step(runner, readings, &action);
    return deepest(&top);
}

int main(void) {
    start_clock();
    uint32_t from = now(), fired = 0, stood = 0;
    overhead = instructions(from, now());
    begin();
    saltus_instruments instruments = {N(0.007853981633974483), 800, N(0.003926990816987241), N(0.003926990816987241),
        N(0.00030521), 32111, N(0.00079897), N(0.00059856), 32767};
    saltus_hold hold = {N(0.0086), N(0.004), N(0.8), N(0.1), N(0.05), N(1.0)};
    gait.period = N(0.001);
    gait.instruments = instruments;
    gait.hold = hold;
    gait.stall.rate = N(0.5);
    gait.stall.time = N(0.1);
    uint32_t most = 0;
    for (uint32_t run = 0; run < CYCLES / RUN; run++) {
        saltus_runner runner;
        saltus_readings readings;
        saltus_action action;
        memset(&readings, 0, sizeof readings);
        draw_gait(run);
        uint32_t rear = stand();
        rate = 0;
        wanted = up_to(140);
        saltus_runner_start(&runner, &gait, rear, place >> 6, run % 5 != 4);
        saltus_runner_demand(&runner, between(N(-4.0), N(4.0)));
        if (one_in(2)) saltus_runner_sense(&runner, between(N(0.1), N(2.0)));
        for (uint32_t k = 0; k < RUN; k++) {
            roll(&readings);
            if (one_in(1500)) saltus_runner_turn_round(&runner, readings.wheel);
            if (one_in(300)) saltus_runner_demand(&runner, one_in(8) ? N(0.0) : between(N(-4.0), N(4.0)));
            if (one_in(30)) saltus_runner_sense(&runner, between(N(-0.2), N(3.0)));
            if (k % 101 == 0) {
                static saltus_runner other;
                other = runner;
                uint32_t used = stack_of(&other, &readings);
                if (used > most) most = used;
            }
            from = now();
            saltus_runner_step(&runner, &readings, &action);
            count(instructions(from, now()));
            fired += action.leg >= 0;
            stood += action.stalled != 0;
            mix_word((uint32_t)action.leg);
            mix_word(action.in_zone);
            mix_word((uint32_t)action.stalled);
            mix_real(action.valve_open);
            mix_real(action.lean);
            mix_real(action.rate);
            mix_real(action.firing_angle);
        }
    }
    report("cycles", CYCLES, fired, hash);
    printf("stood still in %lu, knew its feet in %lu of %lu runs\n", (unsigned long)stood, (unsigned long)knew, (unsigned long)(CYCLES / RUN));
#ifdef __arm__
    printf("# stack of a cycle: at most %lu bytes\n", (unsigned long)most);
#endif
    return 0;
}
