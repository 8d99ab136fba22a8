#ifndef DRILL_H
#define DRILL_H

#include "saltus_controller.h"

#define DRILL_CONSTRAINTS 8
#define DRILL_HASH 2166136261u

typedef struct { saltus_sensed sensed; saltus_task task; saltus_obstacle obstacle; } drill_decision;
typedef struct { saltus_real h[3], g[2]; saltus_half_plane constraints[DRILL_CONSTRAINTS]; } drill_program;

void drill_begin(uint32_t seed);
void drill_decision_input(drill_decision *d);
uint32_t drill_decision_hash(uint32_t hash, enum saltus_status status, const saltus_decision *d);
void drill_approach_input(saltus_approach *a);
uint32_t drill_take_off_hash(uint32_t hash, enum saltus_status status, const saltus_take_off *t);
void drill_program_input(drill_program *p);
uint32_t drill_program_hash(uint32_t hash, enum saltus_status status, const saltus_real x[2]);

#endif
