/*
 * The control loop of a ball, after `saltus export gait disc-stable --out ball`, which rolls straight on, or `steer`, which follows
 * a path of points:
 *
 *     cc -std=c99 -Iball ball.c ball/saltus_ball.c -lm -o ball_loop
 *
 * A line of its input is a cycle of 1 ms: fine gyros, coarse gyros, fine accelerometers, coarse accelerometers, each x, y, z in counts, and the
 * switches in the feet. Its output: the cycle, the leg that fires, for how long (s). A robot reads its converters and opens its valves instead.
 */
#include <math.h>
#include <stdio.h>

#include "ball_tables.h"

static int read_three(int32_t axes[3]) {
    long x, y, z;
    if (scanf("%ld %ld %ld", &x, &y, &z) != 3) return 0;
    axes[0] = (int32_t)x;
    axes[1] = (int32_t)y;
    axes[2] = (int32_t)z;
    return 1;
}

static int read_sensors(saltus_inertial *r) {
    unsigned long touching;
    if (!read_three(r->fine_gyro) || !read_three(r->coarse_gyro)) return 0;
    if (!read_three(r->fine_accelerometer) || !read_three(r->coarse_accelerometer)) return 0;
    if (scanf("%lu", &touching) != 1) return 0;
    r->touching = touching;
    return 1;
}

#ifdef BALL_LEAD
/* Through these points (m), from (0, 0). */
static const saltus_real path[][2] = {{10, 0}, {10, 10}, {0, 10}, {0, 0}};
#else
/* Of the planes that stand upright, and in which a single leg would push off, the one that leads most nearly along the x axis; along which
 * heading it leads. Twins are too weak to set out by. */
static const saltus_plane *choose(const saltus_estimate *e, saltus_real *heading) {
    const saltus_plane *best = NULL;
    for (int k = 0; k < BALL_PLANES; k++) {
        saltus_balancer balancer;
        saltus_sight sight = {e->attitude, {0, 0, 0}, 0, 0, 0, ~(uint64_t)0};
        saltus_lying lying;
        saltus_firing firings[2];
        saltus_balancer_start(&balancer, &ball_balance, &ball_planes[k]);
        saltus_balancer_step(&balancer, &sight, &lying, firings);
        if (fabs((double)lying.roll) > 0.1 || firings[0].leg < 0 || firings[1].leg >= 0) continue;
        if (!best || fabs((double)lying.heading) < fabs((double)*heading)) {
            best = &ball_planes[k];
            *heading = lying.heading;
        }
    }
    return best;
}
#endif

int main(void) {
    static saltus_at_rest rest;
    static saltus_estimator estimator;
    saltus_inertial readings;
    saltus_rotation attitude;
    const saltus_real origin[3] = {0, 0, 0};
    long cycle = 0;
    do {
        if (!read_sensors(&readings)) return 1;
        cycle++;
        saltus_at_rest_take(&rest, &ball_senses.scales, &readings);
    } while (saltus_attitude(&rest, &ball_senses, &attitude) != SALTUS_REST_OK);
    saltus_estimator_start(&estimator, &ball_senses, &attitude, origin);
#ifdef BALL_LEAD
    static saltus_pilot pilot;
    saltus_pilot_start(&pilot, &ball_lead, ball_planes, BALL_PLANES, path, sizeof path / sizeof path[0]);
#else
    static saltus_balancer balancer;
    saltus_real course = 0;
    const saltus_plane *plane = choose(&estimator.estimate, &course);
    if (!plane) return 1;
    saltus_balancer_start(&balancer, &ball_balance, plane);
    const saltus_real ahead = (saltus_real)cos((double)course), left = (saltus_real)sin((double)course);
    printf("way %ld course %.3f\n", (long)(plane - ball_planes), (double)course);
#endif
    for (; read_sensors(&readings); cycle++) {
        const saltus_estimate *e = &estimator.estimate;
        saltus_firing firings[2];
        saltus_estimator_take(&estimator, &readings);
#ifdef BALL_LEAD
        saltus_view view = {e->attitude, {e->spin[0], e->spin[1], e->spin[2]}, {e->place[0], e->place[1]}, {e->velocity[0], e->velocity[1]},
            readings.touching};
        int32_t before = saltus_pilot_plane(&pilot);
        saltus_pilot_step(&pilot, &view, firings);
        int32_t plane = saltus_pilot_plane(&pilot);
        if (plane != before && plane >= 0) printf("way %ld\n", (long)plane);
#else
        saltus_lying lying;
        saltus_sight sight = {e->attitude, {e->spin[0], e->spin[1], e->spin[2]}, ahead * e->place[1] - left * e->place[0],
            ahead * e->velocity[1] - left * e->velocity[0], course, readings.touching};
        saltus_balancer_step(&balancer, &sight, &lying, firings);
#endif
        for (int side = 0; side < 2; side++) {
            saltus_estimator_fired(&estimator, firings[side].leg);
            if (firings[side].leg >= 0) printf("%ld leg %ld %.5f\n", cycle, (long)firings[side].leg, (double)firings[side].open);
        }
    }
    return 0;
}
