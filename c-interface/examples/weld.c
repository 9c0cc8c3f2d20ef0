/* The core in C: memory, start, and the function that a control task calls every period.
 *
 * On a controller `setup` runs once and `period` in the task; here, on a host, `main` stands for both: it reads what every
 * period is given from standard input and prints what it commands, as bits. `weld LAW` takes another law than the
 * configuration's, with its default gains. -DDOUBLE: in double instead of float.
 */
#include <stdio.h>
#include <string.h>

#include "cell.h"

#ifdef DOUBLE
typedef double real;
typedef TrueweldInputs_f64 Inputs;
typedef TrueweldOutputs_f64 Outputs;
#define TRUEWELD(name) trueweld_f64_##name
#define BYTES TRUEWELD_MEMORY_BYTES_F64
#else
typedef float real;
typedef TrueweldInputs_f32 Inputs;
typedef TrueweldOutputs_f32 Outputs;
#define TRUEWELD(name) trueweld_f32_##name
#define BYTES TRUEWELD_MEMORY_BYTES_F32
#endif

/* All state of the core: static, aligned, of a size known to the linker. */
static union {
    unsigned char bytes[BYTES];
    uint64_t aligned;
} memory;

/* Once, before the drives are on. */
static TrueweldStatus setup(const TrueweldConfiguration *configuration, const real encoder[6], const real torque[6]) {
    TrueweldStatus status = TRUEWELD(initialise)(&memory, sizeof memory, configuration);
    if (status == TRUEWELD_STATUS_OK) {
        status = TRUEWELD(start)(&memory, encoder, torque);
    }
    return status;
}

/* Every control period. Below 0 the call is wrong, and the drives are to be stopped; above 0 a sensor or the posture is at
 * fault, and `outputs` holds a torque that is safe to apply while the program decides. */
static TrueweldStatus period(const Inputs *inputs, Outputs *outputs) {
    outputs->version = TRUEWELD_INTERFACE_VERSION;
    outputs->bytes = sizeof *outputs;
    return TRUEWELD(cycle)(&memory, inputs, outputs);
}

static int numbers(real *to, int count) {
    int i;
    for (i = 0; i < count; i++) {
        double number;
        if (scanf("%lf", &number) != 1) {
            return 0;
        }
        to[i] = (real)number;
    }
    return 1;
}

static int measurements(Inputs *inputs) {
    uint32_t i;
    if (scanf("%u", &inputs->measurement_count) != 1 || inputs->measurement_count > TRUEWELD_MEASUREMENTS) {
        return 0;
    }
    for (i = 0; i < inputs->measurement_count; i++) {
        if (!(numbers(&inputs->measurements[i].deviation, 1) && numbers(inputs->measurements[i].along, 6) &&
              numbers(&inputs->measurements[i].noise, 1) && numbers(&inputs->measurements[i].age, 1) &&
              numbers(&inputs->measurements[i].ahead, 1))) {
            return 0;
        }
    }
    return 1;
}

static int read(Inputs *inputs) {
    memset(inputs, 0, sizeof *inputs);
    inputs->version = TRUEWELD_INTERFACE_VERSION;
    inputs->bytes = sizeof *inputs;
    return scanf("%u", &inputs->force_closed) == 1 && numbers(inputs->setpoint.rotation, 9) &&
           numbers(inputs->setpoint.position, 3) && numbers(inputs->nominal.rotation, 9) &&
           numbers(inputs->nominal.position, 3) && numbers(inputs->b_from_w, 9) && numbers(&inputs->force, 1) &&
           numbers(&inputs->spindle_speed, 1) && numbers(inputs->encoder, 6) && numbers(inputs->encoder_rate, 6) &&
           numbers(inputs->motor_torque, 6) && numbers(inputs->wrench, 6) && numbers(&inputs->path, 1) &&
           numbers(inputs->planned, 6) && measurements(inputs);
}

static void print(const real *values, int count) {
    int i;
    for (i = 0; i < count; i++) {
        double number = values[i];
        uint64_t bits;
        memcpy(&bits, &number, sizeof bits);
        printf(" %016llx", (unsigned long long)bits);
    }
}

int main(int argc, char **argv) {
    TrueweldConfiguration configuration = trueweld_cell;
    real encoder[6], torque[6];
    Inputs inputs;
    Outputs outputs;
    TrueweldStatus status;
    uint8_t digest[32];

    if (argc > 1) {
        memset(configuration.law.name, 0, sizeof configuration.law.name);
        strncpy(configuration.law.name, argv[1], sizeof configuration.law.name - 1);
        configuration.law.gain_count = 0;
    }
    if (!numbers(encoder, 6) || !numbers(torque, 6)) {
        return 2;
    }
    status = setup(&configuration, encoder, torque);
    if (status != TRUEWELD_STATUS_OK) {
        fprintf(stderr, "%s\n", trueweld_status_text(status));
        return 1;
    }
    /* What was certified is what runs. */
    if (argc == 1 && (trueweld_digest(&memory, digest) != TRUEWELD_STATUS_OK ||
                      memcmp(digest, trueweld_cell_digest, sizeof digest) != 0)) {
        fprintf(stderr, "the core is of another configuration\n");
        return 1;
    }
    while (read(&inputs)) {
        status = period(&inputs, &outputs);
        printf("%d", (int)status);
        print(outputs.torque, 6);
        print(outputs.correction, 6);
        printf("\n");
    }
    return 0;
}
