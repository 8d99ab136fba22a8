/*
 * A simulated ball's run once more from what its sensors said, which the study `ball_replay` writes; that prints the same line.
 */
#include <string.h>

#include "ball_tables.h"
#include "counted.h"
#include "ball_readings.h"

static uint32_t hash = 2166136261u;

static void mix_bytes(const void *bytes, size_t count) {
    const unsigned char *at = bytes;
    for (size_t k = 0; k < count; k++) hash = (hash ^ at[k]) * 16777619u;
}

static void mix(const saltus_estimate *e, const saltus_lying *l, const saltus_firing firings[2]) {
    const saltus_real known[10] = {e->attitude.w, e->attitude.x, e->attitude.y, e->attitude.z, l->lean, l->rate, l->roll, l->roll_rate,
        l->heading, l->heading_rate};
    mix_bytes(known, sizeof known);
    mix_bytes(e->spin, sizeof e->spin);
    mix_bytes(e->velocity, sizeof e->velocity);
    mix_bytes(e->place, sizeof e->place);
    for (int side = 0; side < 2; side++) {
        mix_bytes(&firings[side].leg, 4);
        mix_bytes(&firings[side].open, sizeof firings[side].open);
    }
}

static void take(const int16_t *counts, int32_t axes[3]) {
    for (int k = 0; k < 3; k++) axes[k] = counts[k];
}

int main(void) {
    static saltus_estimator estimator;
    static saltus_balancer balancer;
    uint32_t fired = 0;
    saltus_real start = 0;
    start_clock();
    uint32_t from = now();
    overhead = instructions(from, now());
    begin();
    saltus_estimator_start(&estimator, &ball_senses, &ball_attitude, ball_place);
    saltus_balancer_start(&balancer, &ball_balance, &ball_planes[BALL_PLANE]);
    for (uint32_t k = 0; k < BALL_CYCLES; k++) {
        saltus_inertial readings;
        saltus_lying lying;
        saltus_firing firings[2];
        const saltus_estimate *e = &estimator.estimate;
        take(&ball_readings[k][0], readings.fine_gyro);
        take(&ball_readings[k][3], readings.coarse_gyro);
        take(&ball_readings[k][6], readings.fine_accelerometer);
        take(&ball_readings[k][9], readings.coarse_accelerometer);
        readings.touching = (uint64_t)ball_readings[k][12];
        from = now();
        saltus_estimator_take(&estimator, &readings);
        if (k == 0) start = e->place[1];
        saltus_sight sight = {e->attitude, {e->spin[0], e->spin[1], e->spin[2]}, e->place[1] - start, e->velocity[1], 0, readings.touching};
        saltus_balancer_step(&balancer, &sight, &lying, firings);
        for (int side = 0; side < 2; side++) saltus_estimator_fired(&estimator, firings[side].leg);
        count(instructions(from, now()));
        fired += firings[0].leg >= 0 || firings[1].leg >= 0;
        mix(e, &lying, firings);
    }
    paint();
    (void)deepest(0);
    report("replay", BALL_CYCLES, fired, hash);
    return 0;
}
