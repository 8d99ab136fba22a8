/*
 * The drill, counted: on a Cortex-M4F in QEMU, where one instruction takes 64 ns of its time (-icount shift=6), or on the host without counts.
 * Prints hashes, counts and the deepest stack.
 */
#include <stdio.h>

#include "counted.h"
#include "drill.h"

#ifndef DECISIONS
#define DECISIONS 100000
#endif
#define TAKE_OFFS (DECISIONS / 50)
#define PROGRAMS (DECISIONS / 2)

__attribute__((noinline)) static uint32_t decisions(int with_obstacle, const char *what) {
    uint32_t hash = DRILL_HASH, answered = 0;
    begin();
    drill_begin(1);
    for (uint32_t k = 0; k < DECISIONS; k++) {
        drill_decision d;
        saltus_decision answer;
        drill_decision_input(&d);
        if (!with_obstacle) d.task.obstacle = NULL;
        uint32_t from = now();
        enum saltus_status status = saltus_decide(&d.sensed, &d.task, &answer);
        count(instructions(from, now()));
        answered += status == SALTUS_OK;
        hash = drill_decision_hash(hash, status, &answer);
    }
    report(what, DECISIONS, answered, hash);
    return hash;
}

__attribute__((noinline)) static void stack_of(void) {
#ifdef __arm__
    uint32_t top;
    drill_decision d;
    saltus_decision answer;
    drill_begin(1);
    uint32_t most = 0;
    for (int k = 0; k < 200; k++) {
        drill_decision_input(&d);
        d.task.obstacle = &d.obstacle;
        paint();
        saltus_decide(&d.sensed, &d.task, &answer);
        uint32_t used = deepest(&top);
        if (used > most) most = used;
    }
    printf("# stack: decision %lu bytes", (unsigned long)most);
    most = 0;
    saltus_approach a;
    saltus_take_off t;
    for (int k = 0; k < 50; k++) {
        drill_approach_input(&a);
        paint();
        saltus_choose_take_off(&a, &t, NULL);
        uint32_t used = deepest(&top);
        if (used > most) most = used;
    }
    printf(", take-off %lu bytes\n", (unsigned long)most);
#else
    paint();
    (void)deepest(NULL);
#endif
}

int main(void) {
    start_clock();
    uint32_t from = now();
    overhead = instructions(from, now());
    int failed = saltus_self_test();
    printf("self-test: %d\n", failed);

    decisions(0, "decisions without an obstacle");
    decisions(1, "decisions");

    uint32_t hash = DRILL_HASH, answered = 0;
    begin();
    drill_begin(2);
    for (uint32_t k = 0; k < TAKE_OFFS; k++) {
        saltus_approach a;
        saltus_take_off t;
        drill_approach_input(&a);
        from = now();
        enum saltus_status status = saltus_choose_take_off(&a, &t, NULL);
        count(instructions(from, now()));
        answered += status == SALTUS_OK;
        hash = drill_take_off_hash(hash, status, &t);
    }
    report("take-offs", TAKE_OFFS, answered, hash);

    hash = DRILL_HASH;
    answered = 0;
    begin();
    drill_begin(3);
    for (uint32_t k = 0; k < PROGRAMS; k++) {
        drill_program p;
        saltus_real x[2];
        drill_program_input(&p);
        from = now();
        enum saltus_status status = saltus_qp2(p.h, p.g, p.constraints, DRILL_CONSTRAINTS, x);
        count(instructions(from, now()));
        answered += status == SALTUS_OK;
        hash = drill_program_hash(hash, status, x);
    }
    report("programs of 8 constraints", PROGRAMS, answered, hash);
    stack_of();
    return failed;
}
