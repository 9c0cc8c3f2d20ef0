/* The core in C: memory, start, and the function that a control task calls every period.
 *
 * On a controller `setup` runs once and `period` in the task; here `main` stands for both: `weld LAW INPUTS OUTPUTS` reads
 * what every period is given from a file and writes what it commands, as doubles. Another law than the configuration's
 * has its default gains. -DDOUBLE: in double instead of float.
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

static int numbers(FILE *from, real *to, int count) {
    int i;
    for (i = 0; i < count; i++) {
        double number;
        if (fread(&number, sizeof number, 1, from) != 1) {
            return 0;
        }
        to[i] = (real)number;
    }
    return 1;
}

static int count(FILE *from, uint32_t *to) {
    double number;
    if (fread(&number, sizeof number, 1, from) != 1 || !(number >= 0 && number <= TRUEWELD_MEASUREMENTS)) {
        return 0;
    }
    *to = (uint32_t)number;
    return 1;
}

static int measurements(FILE *from, Inputs *inputs) {
    uint32_t i;
    for (i = 0; i < inputs->measurement_count; i++) {
        if (!(numbers(from, &inputs->measurements[i].deviation, 1) && numbers(from, inputs->measurements[i].along, 6) &&
              numbers(from, &inputs->measurements[i].noise, 1) && numbers(from, &inputs->measurements[i].age, 1) &&
              numbers(from, &inputs->measurements[i].ahead, 1))) {
            return 0;
        }
    }
    return 1;
}

static int read_inputs(FILE *from, Inputs *inputs) {
    memset(inputs, 0, sizeof *inputs);
    inputs->version = TRUEWELD_INTERFACE_VERSION;
    inputs->bytes = sizeof *inputs;
    return count(from, &inputs->force_closed) && numbers(from, inputs->setpoint.rotation, 9) &&
           numbers(from, inputs->setpoint.position, 3) && numbers(from, inputs->nominal.rotation, 9) &&
           numbers(from, inputs->nominal.position, 3) && numbers(from, inputs->b_from_w, 9) &&
           numbers(from, &inputs->force, 1) && numbers(from, &inputs->spindle_speed, 1) &&
           numbers(from, inputs->encoder, 6) && numbers(from, inputs->encoder_rate, 6) &&
           numbers(from, inputs->motor_torque, 6) && numbers(from, inputs->wrench, 6) && numbers(from, &inputs->path, 1) &&
           numbers(from, inputs->planned, 6) && count(from, &inputs->measurement_count) && measurements(from, inputs);
}

static void write_numbers(FILE *to, const real *values, int count) {
    int i;
    for (i = 0; i < count; i++) {
        double number = values[i];
        fwrite(&number, sizeof number, 1, to);
    }
}

int main(int argc, char **argv) {
    TrueweldConfiguration configuration = trueweld_cell;
    real encoder[6], torque[6];
    Inputs inputs;
    Outputs outputs;
    TrueweldStatus status;
    uint8_t digest[32];
    FILE *from, *to;

    if (argc != 4 || !(from = fopen(argv[2], "rb")) || !(to = fopen(argv[3], "wb"))) {
        fprintf(stderr, "expected: weld LAW INPUTS OUTPUTS\n");
        return 2;
    }
    if (strcmp(argv[1], configuration.law.name) != 0) {
        memset(configuration.law.name, 0, sizeof configuration.law.name);
        strncpy(configuration.law.name, argv[1], sizeof configuration.law.name - 1);
        configuration.law.gain_count = 0;
    }
    if (!numbers(from, encoder, 6) || !numbers(from, torque, 6)) {
        return 2;
    }
    status = setup(&configuration, encoder, torque);
    if (status != TRUEWELD_STATUS_OK) {
        fprintf(stderr, "%s\n", trueweld_status_text(status));
        return 1;
    }
    /* What was certified is what runs. */
    if (strcmp(argv[1], trueweld_cell.law.name) == 0 &&
        (trueweld_digest(&memory, digest) != TRUEWELD_STATUS_OK ||
         memcmp(digest, trueweld_cell_digest, sizeof digest) != 0)) {
        fprintf(stderr, "the core is of another configuration\n");
        return 1;
    }
    while (read_inputs(from, &inputs)) {
        real told;
        status = period(&inputs, &outputs);
        told = (real)status;
        write_numbers(to, &told, 1);
        write_numbers(to, outputs.torque, 6);
        write_numbers(to, outputs.correction, 6);
    }
    return fclose(to) == 0 ? 0 : 2;
}
