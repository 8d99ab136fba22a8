@HEADER@
#ifndef SALTUS_POLICY_H
#define SALTUS_POLICY_H

#include <stdint.h>

typedef @REAL@ saltus_policy_real;

/* Equal steps along a number that is observed: where the first begins, where the last ends, how many there are. */
typedef struct {
    saltus_policy_real from, to;
    uint16_t count;
} saltus_policy_steps;

/* A choice for each state; the steps of the last number are neighbours. */
typedef struct {
    const saltus_policy_steps *axes;
    uint32_t axis_count;
    const uint8_t *choices;
} saltus_policy;

/*
 * The choice where `observed` is, which has a number for each axis. What is outside counts to the nearest step, what is not a number to the
 * first.
 */
static inline uint8_t saltus_policy_choice(const saltus_policy *policy, const saltus_policy_real observed[]) {
    uint32_t state = 0;
    for (uint32_t k = 0; k < policy->axis_count; k++) {
        const saltus_policy_steps *steps = &policy->axes[k];
        const saltus_policy_real place = (observed[k] - steps->from) / (steps->to - steps->from) * (saltus_policy_real)steps->count;
        const uint32_t last = steps->count - 1u;
        uint32_t step = 0;
        if (place >= (saltus_policy_real)last) {
            step = last;
        } else if (place > 0) {
            step = (uint32_t)place;
        }
        state = state * steps->count + step;
    }
    return policy->choices[state];
}
@DATA@
#endif
