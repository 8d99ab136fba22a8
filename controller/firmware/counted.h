/*
 * Instructions and stack of calls on a Cortex-M4F in QEMU, where one instruction takes 64 ns of its time (-icount shift=6); on the host, nothing.
 */
#ifndef COUNTED_H
#define COUNTED_H

#include <stdint.h>
#include <stdio.h>

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

#endif
