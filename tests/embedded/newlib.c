/* The start of a C program with newlib on a bare Cortex-M7: the FPU on, then newlib's own start. */
extern char __stack;
extern void _start(void);

void reset(void) {
    *(volatile unsigned *)0xe000ed88 |= 0xfu << 20;
    __asm volatile("dsb\nisb");
    _start();
}

static void fault(void) {
    /* Semihosting: exit with an error, which ends the emulator. */
    __asm volatile("movs r0, #0x18\nldr r1, =0x20023\nbkpt 0xab" ::: "r0", "r1");
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {&__stack, reset, fault, fault,
                                                                                   fault,    fault, fault};
