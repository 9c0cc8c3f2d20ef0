/* Every misuse that can be told from a right call gives its status, changes nothing, and writes nowhere else. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cell.h"

#define GUARD 64
#define SIZE TRUEWELD_CELL_BYTES_F32

static int failed = 0;

static void expect(int line, TrueweldStatus got, TrueweldStatus wanted) {
    if (got != wanted) {
        printf("line %d: got %d (%s), wanted %d\n", line, (int)got, trueweld_status_text(got), (int)wanted);
        failed = 1;
    }
}
#define EXPECT(call, status) expect(__LINE__, call, TRUEWELD_STATUS_##status)

static TrueweldInputs_f32 inputs(void) {
    TrueweldInputs_f32 in;
    int i;
    memset(&in, 0, sizeof in);
    in.version = TRUEWELD_INTERFACE_VERSION;
    in.bytes = sizeof in;
    in.force_closed = 1;
    in.force = 18e3f;
    in.setpoint.position[0] = 1.7f;
    in.setpoint.position[2] = 0.5f;
    /* x of T along -x of W, y of T along y of B, z of T down. */
    in.setpoint.rotation[0] = -1;
    in.setpoint.rotation[4] = 1;
    in.setpoint.rotation[8] = -1;
    in.nominal = in.setpoint;
    in.b_from_w[1] = 1;
    in.b_from_w[3] = 1;
    in.b_from_w[8] = -1;
    in.wrench[5] = -18e3f;
    for (i = 0; i < 6; i++) {
        in.planned[i] = 0;
    }
    return in;
}

int main(void) {
    /* In the middle of guards, which must stay as they are; on the heap, where a sanitizer sees its ends. */
    unsigned char *all = malloc(SIZE + 2 * GUARD);
    unsigned char *memory = all + GUARD;
    TrueweldConfiguration wrong;
    TrueweldInputs_f32 in = inputs(), bad;
    TrueweldOutputs_f32 out, before;
    /* Near a posture of the weld. */
    float encoder[6] = {0, -0.9f, 1.4f, 0, 1.0f, 0}, torque[6] = {0}, no[6] = {0, NAN, 0, 0, 0, 0}, angles[6];
    uint8_t digest[32];
    size_t bytes = 0;
    int i;

    memset(all, 0xa5, SIZE + 2 * GUARD);
    memset(&out, 0, sizeof out);
    out.version = TRUEWELD_INTERFACE_VERSION;
    out.bytes = sizeof out;

    /* Before it is initialised. */
    EXPECT(trueweld_f32_start(memory, encoder, torque), NOT_INITIALISED);
    EXPECT(trueweld_f32_cycle(memory, &in, &out), NOT_INITIALISED);
    EXPECT(trueweld_digest(memory, digest), NOT_INITIALISED);
    EXPECT(trueweld_f32_inverse(memory, &in.nominal, encoder, angles), NOT_INITIALISED);

    /* Null, misaligned, too small. */
    EXPECT(trueweld_f32_initialise(NULL, SIZE, &trueweld_cell), NULL);
    EXPECT(trueweld_f32_initialise(memory, SIZE, NULL), NULL);
    EXPECT(trueweld_f32_initialise(memory + 1, SIZE - 1, &trueweld_cell), ALIGNMENT);
    EXPECT(trueweld_f32_initialise(memory, 0, &trueweld_cell), MEMORY_SIZE);
    EXPECT(trueweld_f32_bytes(&trueweld_cell, &bytes), OK);
    EXPECT(trueweld_f32_initialise(memory, bytes - 1, &trueweld_cell), MEMORY_SIZE);
    EXPECT(trueweld_f32_bytes(NULL, &bytes), NULL);
    EXPECT(trueweld_f32_bytes(&trueweld_cell, NULL), NULL);
    if (bytes > SIZE || bytes > TRUEWELD_MEMORY_BYTES_F32) {
        printf("the law needs %lu bytes, more than its constant\n", (unsigned long)bytes);
        return 1;
    }

    /* Configurations that are none. */
    for (i = 0; i < 19; i++) {
        TrueweldStatus status = TRUEWELD_STATUS_CONTROL;
        wrong = trueweld_cell;
        switch (i) {
        case 0: wrong.version += 1; status = TRUEWELD_STATUS_VERSION; break;
        case 1: wrong.bytes -= 8; status = TRUEWELD_STATUS_STRUCT_SIZE; break;
        case 2: wrong.robot.joints[3].stiffness = NAN; status = TRUEWELD_STATUS_ROBOT; break;
        case 3: wrong.robot.joints[0].axis[2] = 0.5; status = TRUEWELD_STATUS_ROBOT; break;
        case 4: wrong.robot.cosine_terms = 1000000; break;
        case 5: wrong.robot.table_points = 0xffffffffu; break;
        case 6: wrong.control.scheme = 4; break;
        case 7: wrong.control.period = 0; break;
        case 8: wrong.control.position_kp[5] = NAN; break;
        case 9: wrong.control.lateral.size = INFINITY; break;
        case 10: wrong.law.name[0] = 'x'; status = TRUEWELD_STATUS_LAW; break;
        case 11: memset(wrong.law.name, 'e', sizeof wrong.law.name); status = TRUEWELD_STATUS_LAW; break;
        case 12: wrong.law.gain_count = 9; status = TRUEWELD_STATUS_LAW; break;
        /* Finite as written, and infinite in float. */
        case 13: wrong.control.position_kp[1] = 1e39; break;
        case 14: wrong.control.force_sensor_force = -1; break;
        case 15: wrong.law.length = NAN; status = TRUEWELD_STATUS_GAIN; break;
        case 16: wrong.law.reserved = 7; status = TRUEWELD_STATUS_VERSION; break;
        case 17: wrong.control.reserved = 7; status = TRUEWELD_STATUS_VERSION; break;
        default: wrong.law.gains[0].key[0] = 'x'; status = TRUEWELD_STATUS_GAIN; break;
        }
        expect(__LINE__ + 1000 * i, trueweld_f32_initialise(memory, SIZE, &wrong), status);
    }
    wrong = trueweld_cell;
    wrong.law.gain_count -= 1;
    EXPECT(trueweld_f32_initialise(memory, SIZE, &wrong), GAIN);
    wrong = trueweld_cell;
    wrong.law.gains[0].count = 5;
    EXPECT(trueweld_f32_initialise(memory, SIZE, &wrong), GAIN);
    EXPECT(trueweld_f32_start(memory, encoder, torque), NOT_INITIALISED);

    EXPECT(trueweld_f32_initialise(memory, bytes, &trueweld_cell), OK);
    EXPECT(trueweld_digest(memory, digest), OK);
    EXPECT(trueweld_digest(memory, NULL), NULL);
    if (memcmp(digest, trueweld_cell_digest, sizeof digest) != 0) {
        printf("the digest is another\n");
        failed = 1;
    }

    /* A core of another scalar, and one that was not started. */
    EXPECT(trueweld_f64_cycle(memory, NULL, NULL), NOT_INITIALISED);
    EXPECT(trueweld_f32_cycle(memory, &in, &out), NOT_STARTED);
    EXPECT(trueweld_f32_start(memory, no, torque), NOT_FINITE);
    EXPECT(trueweld_f32_start(memory, encoder, no), NOT_FINITE);
    EXPECT(trueweld_f32_start(memory, NULL, torque), NULL);
    EXPECT(trueweld_f32_cycle(memory, &in, &out), NOT_STARTED);

    EXPECT(trueweld_f32_inverse(memory, &in.nominal, encoder, angles), OK);
    EXPECT(trueweld_f32_taught(memory, &in.nominal, encoder, &in.setpoint), OK);
    EXPECT(trueweld_f32_taught(memory, &in.nominal, NULL, &in.setpoint), NULL);
    bad = in;
    bad.nominal.position[0] = 100;
    EXPECT(trueweld_f32_inverse(memory, &bad.nominal, encoder, angles), UNREACHABLE);
    bad.nominal.position[0] = NAN;
    EXPECT(trueweld_f32_inverse(memory, &bad.nominal, encoder, angles), UNREACHABLE);
    EXPECT(trueweld_f32_start(memory, angles, torque), OK);
    memcpy(in.encoder, angles, sizeof in.encoder);

    /* Calls that are wrong leave the outputs as they are. */
    before = out;
    bad = in;
    bad.version = 0;
    EXPECT(trueweld_f32_cycle(memory, &bad, &out), VERSION);
    bad = in;
    bad.bytes -= 4;
    EXPECT(trueweld_f32_cycle(memory, &bad, &out), STRUCT_SIZE);
    bad = in;
    bad.measurement_count = TRUEWELD_MEASUREMENTS + 1;
    EXPECT(trueweld_f32_cycle(memory, &bad, &out), COUNT);
    bad = in;
    bad.force_closed = 2;
    EXPECT(trueweld_f32_cycle(memory, &bad, &out), COUNT);
    EXPECT(trueweld_f32_cycle(memory, NULL, &out), NULL);
    EXPECT(trueweld_f32_cycle(memory, &in, NULL), NULL);
    EXPECT(trueweld_f32_cycle(NULL, &in, &out), NULL);
    EXPECT(trueweld_f32_cycle(memory + 4, &in, &out), ALIGNMENT);
    if (memcmp(&before, &out, sizeof out) != 0) {
        printf("a wrong call wrote outputs\n");
        failed = 1;
    }

    /* Faults of a period: a torque that is safe to apply. */
    EXPECT(trueweld_f32_cycle(memory, &in, &out), OK);
    for (i = 0; i < 11; i++) {
        int k;
        TrueweldStatus status;
        bad = in;
        switch (i) {
        case 0: bad.encoder[2] = NAN; status = TRUEWELD_STATUS_FAULT_ENCODER; break;
        case 1: bad.wrench[0] = INFINITY; status = TRUEWELD_STATUS_FAULT_FORCE; break;
        case 2: bad.setpoint.position[1] = NAN; status = TRUEWELD_STATUS_FAULT_SETPOINT; break;
        case 3: bad.b_from_w[0] = NAN; status = TRUEWELD_STATUS_FAULT_SETPOINT; break;
        case 4: bad.nominal.position[1] = NAN; status = TRUEWELD_STATUS_FAULT_COMPENSATION; break;
        /* Scaled axes, left-handed ones, and a wrench that the sensor cannot give. */
        case 5: bad.b_from_w[8] = -3; status = TRUEWELD_STATUS_FAULT_SETPOINT; break;
        case 6: bad.setpoint.rotation[0] *= -1; status = TRUEWELD_STATUS_FAULT_SETPOINT; break;
        case 7: bad.wrench[4] = 1e6f; status = TRUEWELD_STATUS_FAULT_FORCE; break;
        case 8: bad.path = INFINITY; status = TRUEWELD_STATUS_FAULT_COMPENSATION; break;
        /* Back from there is as far. */
        case 9: status = TRUEWELD_STATUS_FAULT_COMPENSATION; break;
        default: bad.encoder[4] += 1.0f; status = TRUEWELD_STATUS_FAULT_ENCODER; break;
        }
        /* A sensor that repeats itself is stuck: it gives something new every time. */
        bad.wrench[5] -= (float)i;
        memset(out.torque, 0xff, sizeof out.torque);
        expect(__LINE__ + 1000 * i, trueweld_f32_cycle(memory, &bad, &out), status);
        for (k = 0; k < 6; k++) {
            if (!isfinite(out.torque[k]) || !isfinite(out.correction[k])) {
                printf("case %d: torque %d is no number\n", i, k);
                failed = 1;
            }
        }
        if (i == 0 && out.joint != 2) {
            printf("the fault is of joint %u\n", out.joint);
            failed = 1;
        }
    }
    EXPECT(trueweld_f32_cycle(memory, &in, &out), OK);

    for (i = 0; i < GUARD; i++) {
        if (all[i] != 0xa5 || memory[SIZE + i] != 0xa5) {
            printf("a guard was written over\n");
            failed = 1;
            break;
        }
    }
    if (strcmp(trueweld_status_text(12345), "unknown status") != 0 || trueweld_interface_version() != 1) {
        failed = 1;
    }
    free(all);
    return failed;
}
