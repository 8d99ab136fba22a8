/*
 * The drill, counted: on a Cortex-M4F in QEMU, where one instruction takes 64 ns of its time (-icount shift=6), or on the host without counts.
 * Prints hashes, counts and the deepest stack.
 */
#include <stdio.h>
#include <stdlib.h>

#include "drill.h"

#ifndef DECISIONS
#define DECISIONS 100000
#endif
#define TAKE_OFFS (DECISIONS / 50)
#define PROGRAMS (DECISIONS / 2)

#ifdef __arm__
/* SysTick: 25 MHz on mps2-an386, 24 bits, down. */
#define CONTROL (*(volatile uint32_t *)0xE000E010u)
#define RELOAD (*(volatile uint32_t *)0xE000E014u)
#define CURRENT (*(volatile uint32_t *)0xE000E018u)

static void start_clock(void) {
    RELOAD = 0xFFFFFF;
    CURRENT = 0;
    CONTROL = 5;
}
static uint32_t now(void) { return CURRENT; }
/* Ticks of 40 ns to instructions of 64 ns. */
static uint32_t instructions(uint32_t from, uint32_t to) { return (((from - to) & 0xFFFFFFu) * 40 + 32) / 64; }

extern uint32_t _ebss;
/* Above the buffers that printf takes. */
#define FLOOR (&_ebss + 16384)
#define PAINT 0xA5A5A5A5u

/* Paints the free stack, well below the caller's frame. */
static void paint(void) {
    uint32_t here;
    for (volatile uint32_t *p = FLOOR; p < &here - 64; p++) *p = PAINT;
}
/* Bytes of the stack that were used below `top`. */
static uint32_t deepest(const uint32_t *top) {
    const volatile uint32_t *p = FLOOR;
    while (p < top && *p == PAINT) p++;
    return (uint32_t)((uintptr_t)top - (uintptr_t)p);
}
#else
static void start_clock(void) {}
static uint32_t now(void) { return 0; }
static uint32_t instructions(uint32_t from, uint32_t to) { return from - to; }
static void paint(void) {}
static uint32_t deepest(const uint32_t *top) { return (uint32_t)(0 * (uintptr_t)top); }
#endif

/* How many calls took how many instructions. */
#define MOST 65536
static uint32_t histogram[MOST];
static uint32_t overhead;

static void begin(void) {
    for (int k = 0; k < MOST; k++) histogram[k] = 0;
}
static void count(uint32_t n) {
    n = n > overhead ? n - overhead : 0;
    histogram[n < MOST ? n : MOST - 1]++;
}
static void report(const char *what, uint32_t calls, uint32_t answered, uint32_t hash) {
    printf("%s: %lu calls, %lu answered, hash %08lx\n", what, (unsigned long)calls, (unsigned long)answered, (unsigned long)hash);
#ifdef __arm__
    uint32_t seen = 0, median = 0, worst = 0;
    for (uint32_t n = 0; n < MOST; n++) {
        if (!histogram[n]) continue;
        if (seen < calls / 2) median = n;
        seen += histogram[n];
        worst = n;
    }
    printf("# %s: instructions median %lu, worst %lu\n", what, (unsigned long)median, (unsigned long)worst);
#endif
}

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
