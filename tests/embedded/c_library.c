/* What the C library costs on a bare Cortex-M7 in QEMU: for each law that is named the stack of initialise, start and cycle,
 * by painting it beforehand, and the instructions of a cycle, by SysTick in an emulator that counts them. cortex-m7.sh
 * compares with bounds.txt. -DDOUBLE: in double instead of float.
 *
 * Every cycle brings two readings of a seam sensor, the most that one makes in a period; over so many cycles whatever a law
 * keeps is full.
 */
#include <stdio.h>
#include <string.h>

#include "cell.h"

#ifdef DOUBLE
typedef double real;
typedef TrueweldInputs_f64 Inputs;
typedef TrueweldOutputs_f64 Outputs;
typedef TrueweldPose_f64 Pose;
#define TRUEWELD(name) trueweld_f64_##name
#define BYTES TRUEWELD_MEMORY_BYTES_F64
#define SCALAR "f64"
#else
typedef float real;
typedef TrueweldInputs_f32 Inputs;
typedef TrueweldOutputs_f32 Outputs;
typedef TrueweldPose_f32 Pose;
#define TRUEWELD(name) trueweld_f32_##name
#define BYTES TRUEWELD_MEMORY_BYTES_F32
#define SCALAR "f32"
#endif

#define CYCLES 400
#define PAINT 0xa5a5a5a5u
/* More than any call may take. */
#define PAINTED (256u * 1024u)
#define SYSTICK ((volatile uint32_t *)0xe000e010)

static union {
    unsigned char bytes[BYTES];
    uint64_t aligned;
} memory;
static TrueweldConfiguration configuration;
static Inputs inputs;
static Outputs outputs;
static real encoder[6], torque[6];

static TrueweldStatus initialise(void) { return TRUEWELD(initialise)(&memory, sizeof memory, &configuration); }
static TrueweldStatus start(void) { return TRUEWELD(start)(&memory, encoder, torque); }
static TrueweldStatus cycle(void) { return TRUEWELD(cycle)(&memory, &inputs, &outputs); }
static TrueweldStatus nothing(void) { return TRUEWELD_STATUS_OK; }

/* What a call took. */
typedef struct {
    TrueweldStatus status;
    uint32_t ticks;
    uint32_t stack;
} Cost;

/* Calls with everything below this frame painted. */
static __attribute__((noinline)) Cost measured(TrueweldStatus (*call)(void)) {
    register uint32_t *sp __asm("sp");
    volatile uint32_t *low = sp - PAINTED / 4, *at;
    uint32_t begun;
    Cost cost;
    for (at = low; at < sp - 8; at++) {
        *at = PAINT;
    }
    begun = SYSTICK[2];
    cost.status = call();
    cost.ticks = (begun - SYSTICK[2]) & 0xffffff;
    for (at = low; at < sp && *at == PAINT; at++) {
    }
    cost.stack = (uint32_t)((volatile uint32_t *)sp - at) * 4;
    return cost;
}

/* A thousand instructions. */
static TrueweldStatus thousand(void) {
    __asm volatile(".rept 1000\nnop\n.endr");
    return TRUEWELD_STATUS_OK;
}

/* A tool on its way along y of B under the load of a weld. */
static void period(int k) {
    static const real down[9] = {0, 1, 0, 1, 0, 0, 0, 0, -1};
    real ripple = (real)(50 * (k % 5 - 2) + 0.01 * k);
    int i;
    memset(&inputs, 0, sizeof inputs);
    inputs.version = TRUEWELD_INTERFACE_VERSION;
    inputs.bytes = sizeof inputs;
    inputs.force_closed = 1;
    inputs.measurement_count = 2;
    memcpy(inputs.b_from_w, down, sizeof down);
    inputs.nominal.rotation[0] = -1;
    inputs.nominal.rotation[4] = 1;
    inputs.nominal.rotation[8] = -1;
    inputs.nominal.position[0] = (real)1.7;
    inputs.nominal.position[1] = (real)(-0.3 + 1.2e-4 * k);
    inputs.nominal.position[2] = (real)0.5;
    inputs.force = 18000;
    inputs.spindle_speed = (real)-62.83;
    inputs.path = (real)(1.2e-4 * k);
    for (i = 0; i < 6; i++) {
        inputs.motor_torque[i] = 1000;
    }
    inputs.wrench[3] = 1000;
    inputs.wrench[4] = -4000;
    inputs.wrench[5] = -18000 + ripple;
    inputs.planned[3] = -4000;
    inputs.planned[4] = 1000;
    inputs.planned[5] = -18000;
    for (i = 0; i < 2; i++) {
        inputs.measurements[i].deviation = (real)(1e-5 * (k % 7));
        inputs.measurements[i].along[i ? 0 : 4] = 1;
        inputs.measurements[i].noise = (real)5e-5;
        inputs.measurements[i].age = (real)0.012;
        inputs.measurements[i].ahead = (real)0.02;
    }
}

static int law(const char *name) {
    static const real near_it[6] = {0, (real)-0.9, (real)1.4, 0, 1, 0};
    Cost of_start, of_initialise, of_nothing = measured(nothing), of_thousand = measured(thousand);
    uint32_t most = 0, stack = 0, per_thousand = of_thousand.ticks - of_nothing.ticks;
    int k;
    configuration = trueweld_cell;
    memset(configuration.law.name, 0, sizeof configuration.law.name);
    strcpy(configuration.law.name, name);
    configuration.law.gain_count = 0;
    /* Of made-up torques: the check is made, and finds nothing. */
    configuration.control.force_sensor_disagreement = 1e9;
    of_initialise = measured(initialise);
    memcpy(encoder, near_it, sizeof encoder);
    period(0);
    if (of_initialise.status || TRUEWELD(inverse)(&memory, &inputs.nominal, encoder, encoder)) {
        return 1;
    }
    of_start = measured(start);
    if (of_start.status) {
        return 1;
    }
    for (k = 0; k < CYCLES; k++) {
        Cost cost;
        period(k);
        if (TRUEWELD(inverse)(&memory, &inputs.nominal, encoder, encoder) ||
            TRUEWELD(taught)(&memory, &inputs.nominal, encoder, &inputs.setpoint)) {
            return 1;
        }
        memcpy(inputs.encoder, encoder, sizeof encoder);
        outputs.version = TRUEWELD_INTERFACE_VERSION;
        outputs.bytes = sizeof outputs;
        cost = measured(cycle);
        if (cost.status) {
            return 1;
        }
        cost.ticks -= of_nothing.ticks;
        most = cost.ticks > most ? cost.ticks : most;
        stack = cost.stack > stack ? cost.stack : stack;
    }
    printf("c-%s-initialise " SCALAR " 0 %lu\n", name, (unsigned long)of_initialise.stack);
    printf("c-%s-start " SCALAR " 0 %lu\n", name, (unsigned long)of_start.stack);
    printf("c-%s-cycle " SCALAR " %lu %lu\n", name, (unsigned long)((uint64_t)most * 1000 / per_thousand),
           (unsigned long)stack);
    return 0;
}

int main(int argc, char **argv) {
    int i;
    /* It counts down, in 24 bits. */
    SYSTICK[1] = 0xffffff;
    SYSTICK[2] = 0;
    SYSTICK[0] = 5;
    for (i = 1; i < argc; i++) {
        if (law(argv[i])) {
            printf("%s in " SCALAR ": a call of the C library failed\n", argv[i]);
            return 1;
        }
    }
    return 0;
}
