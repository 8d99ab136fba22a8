/*
 * The drill of learnt tables: random tables, asked on and beside the borders of their steps, and a hash of what is chosen. The study `policy_drill`
 * does the same in Rust.
 */
#include "counted.h"
#include "saltus_policy.h"

#ifndef STATES
#define STATES 1000000
#endif
/* States asked of each table. */
#define EACH 1000

#define N(x) ((saltus_policy_real)(x))

static uint32_t seed = 1;
/* 0, as nobody but the program knows. */
static volatile saltus_policy_real nothing;

static uint32_t word(void) {
    seed = seed * 2891336453u + 12345u;
    return seed >> 8;
}
static saltus_policy_real between(saltus_policy_real low, saltus_policy_real high) {
    return low + (high - low) * ((saltus_policy_real)word() / N(16777216));
}

static saltus_policy_steps axes[4];
static uint8_t choices[31 * 31 * 4 * 4];
static saltus_policy policy = {axes, 0, choices};

/* As in table 6.1 and 6.3 of the thesis: two long axes, and up to two short ones. */
static void draw(void) {
    policy.axis_count = 2 + word() % 3;
    for (uint32_t k = 0; k < 4; k++) {
        axes[k].from = between(N(-20), N(1));
        axes[k].to = axes[k].from + between(N(0.1), N(40));
        axes[k].count = (uint16_t)(1 + word() % (k < 2 ? 31 : 4));
    }
    for (uint32_t k = 0; k < sizeof choices; k++) choices[k] = (uint8_t)(word() % 6);
}

int main(void) {
    uint32_t hash = 2166136261u;
    start_clock();
    uint32_t from = now();
    overhead = instructions(from, now());
    begin();
    for (uint32_t k = 0; k < STATES; k++) {
        if (k % EACH == 0) draw();
        saltus_policy_real observed[4];
        for (uint32_t axis = 0; axis < 4; axis++) {
            const saltus_policy_steps *steps = &axes[axis];
            const saltus_policy_real width = steps->to - steps->from;
            /* Within the range, far out, or on a border. */
            switch (word() % 8) {
            case 0:
                observed[axis] = between(N(-1e6), N(1e6));
                break;
            case 1:
                observed[axis] = steps->from + width * (saltus_policy_real)(word() % (steps->count + 1u)) / (saltus_policy_real)steps->count;
                break;
            case 2:
                observed[axis] = nothing / nothing;
                break;
            default:
                observed[axis] = between(steps->from - width / N(10), steps->to + width / N(10));
            }
        }
        from = now();
        uint8_t choice = saltus_policy_choice(&policy, observed);
        count(instructions(from, now()));
        hash = (hash ^ choice) * 16777619u;
    }
    paint();
    (void)deepest(0);
    report("choices", STATES, STATES, hash);
    return 0;
}
