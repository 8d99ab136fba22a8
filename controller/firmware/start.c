/* Reset of a Cortex-M4F: floating point on, memory set up, main, and the end told to QEMU. Nothing of a vendor's. */
#include <stdint.h>

extern int main(void);
extern void initialise_monitor_handles(void);
extern uint32_t _sidata, _sdata, _edata, _sbss, _ebss, _estack;

static void stop(uint32_t how) {
    register uint32_t r0 __asm__("r0") = 0x18, r1 __asm__("r1") = how; /* SYS_EXIT */
    __asm__ volatile("bkpt 0xAB" : : "r"(r0), "r"(r1) : "memory");
    for (;;) {}
}

void Reset_Handler(void) {
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* CPACR: the coprocessors that are the FPU */
    __asm__ volatile("dsb\nisb");
    for (uint32_t *to = &_sdata, *from = &_sidata; to < &_edata;) *to++ = *from++;
    for (uint32_t *to = &_sbss; to < &_ebss;) *to++ = 0;
    initialise_monitor_handles();
    stop(main() == 0 ? 0x20026u : 0x20023u); /* ADP_Stopped_ApplicationExit, ADP_Stopped_RunTimeErrorUnknown */
}

static void fault(void) { stop(0x20023u); }

__attribute__((section(".vectors"), used)) void (*const vectors[16])(void) = {
    (void (*)(void))&_estack, Reset_Handler, fault, fault, fault, fault, fault,
};
