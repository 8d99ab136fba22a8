/*
 * A drill for the exported code: many inputs, the same on every machine, and a hash of every bit of the answers. The example
 * `drill` of the crate does the same in Rust.
 */
#include "drill.h"

#include <string.h>

static uint32_t state;

/* From low to high, in steps of the difference over 2^24. */
static saltus_real between(saltus_real low, saltus_real high) {
    state = state * 2891336453u + 12345u;
    return low + (high - low) * ((saltus_real)(state >> 8) / (saltus_real)16777216);
}

static uint32_t mixed(uint32_t hash, uint32_t word) {
    for (int k = 0; k < 4; k++) hash = (hash ^ ((word >> (8 * k)) & 0xFFu)) * 16777619u;
    return hash;
}

static uint32_t mixed_real(uint32_t hash, saltus_real x) {
    uint32_t words[sizeof x / 4];
    memcpy(words, &x, sizeof x);
    for (size_t k = 0; k < sizeof x / 4; k++) hash = mixed(hash, words[k]);
    return hash;
}

void drill_begin(uint32_t seed) { state = seed; }

void drill_decision_input(drill_decision *d) {
    d->sensed.lean = between((saltus_real)-0.55, (saltus_real)0.35);
    d->sensed.rate = between((saltus_real)2.0, (saltus_real)6.5);
    d->task.distance = between((saltus_real)0.15, (saltus_real)0.85);
    d->task.landing_height = (saltus_real)0.24;
    d->obstacle.front = between((saltus_real)0.2, (saltus_real)0.5);
    d->obstacle.back = d->obstacle.front + between((saltus_real)0.0, (saltus_real)0.2);
    d->obstacle.height = between((saltus_real)0.0, (saltus_real)0.15);
    d->obstacle.clearance = between((saltus_real)0.0, (saltus_real)0.02);
    d->task.obstacle = between((saltus_real)0.0, (saltus_real)1.0) < (saltus_real)0.75 ? &d->obstacle : NULL;
    d->task.guess = NULL;
}

uint32_t drill_decision_hash(uint32_t hash, enum saltus_status status, const saltus_decision *d) {
    hash = mixed(hash, (uint32_t)status);
    if (status != SALTUS_OK) return hash;
    hash = mixed_real(mixed_real(hash, d->approach_rate), d->firing_angle);
    hash = mixed_real(mixed_real(hash, d->valve_open), d->time);
    return mixed(mixed(hash, (uint32_t)d->timing), (uint32_t)d->settled);
}

void drill_approach_input(saltus_approach *a) {
    a->distance = between((saltus_real)0.1, (saltus_real)1.6);
    a->height = between((saltus_real)0.0, (saltus_real)0.15);
    a->length = between((saltus_real)0.01, (saltus_real)0.2);
    a->speed = between((saltus_real)0.7, (saltus_real)1.5);
    a->clearance = between((saltus_real)0.0, (saltus_real)0.02);
}

uint32_t drill_take_off_hash(uint32_t hash, enum saltus_status status, const saltus_take_off *t) {
    hash = mixed(hash, (uint32_t)status);
    if (status != SALTUS_OK) return hash;
    hash = mixed_real(mixed_real(mixed(hash, t->touch_down), t->approach_rate), t->firing_angle);
    return mixed_real(mixed_real(hash, t->distance), t->clearance);
}

void drill_program_input(drill_program *p) {
    saltus_real low = (saltus_real)-1.0, high = (saltus_real)1.0;
    saltus_real a = between(low, high), b = between(low, high), c = between(low, high);
    p->h[0] = a * a + (saltus_real)0.1;
    p->h[1] = a * b;
    p->h[2] = b * b + c * c + (saltus_real)0.1;
    p->g[0] = between(low, high);
    p->g[1] = between(low, high);
    for (int k = 0; k < DRILL_CONSTRAINTS; k++) {
        p->constraints[k].normal[0] = between(low, high);
        p->constraints[k].normal[1] = between(low, high);
        p->constraints[k].bound = between((saltus_real)-0.25, high);
    }
}

uint32_t drill_program_hash(uint32_t hash, enum saltus_status status, const saltus_real x[2]) {
    hash = mixed(hash, (uint32_t)status);
    return status == SALTUS_OK ? mixed_real(mixed_real(hash, x[0]), x[1]) : hash;
}
