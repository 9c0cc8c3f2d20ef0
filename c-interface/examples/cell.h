/*
   The embedded cell with the elastostatic law, written by
   sim-host/plant/tests/cell/constants.rs as trueweld export-core writes it.
*/
#ifndef TRUEWELD_CELL_H
#define TRUEWELD_CELL_H

#include "trueweld.h"

/* Bytes of memory that the core takes in float and in double, at most. */
#define TRUEWELD_CELL_BYTES_F32 2816u
#define TRUEWELD_CELL_BYTES_F64 5376u

/* SHA-256 of the configuration. */
static const uint8_t trueweld_cell_digest[32] = {99, 176, 38, 92, 230, 142, 91, 167, 125, 185, 11, 52, 10, 84, 254, 61, 34, 71, 59, 49, 254, 198, 134, 16, 188, 127, 118, 101, 202, 219, 203, 182};

/* All that the controller's core is built from. */
static const TrueweldConfiguration trueweld_cell = {
    /* version */ 3,
    /* bytes */ 2944,
    /* robot */ {
        /* gravity */ {
            0.0,
            0.0,
            -9.80665,
        },
        /* joints */ {
            {
                /* origin */ {
                    0.0,
                    0.0,
                    0.0,
                },
                /* axis */ {
                    0.0,
                    0.0,
                    -1.0,
                },
                /* limits */ {
                    -3.2288591161895095,
                    3.2288591161895095,
                },
                /* max_rate */ 0.7853981633974483,
                /* max_torque */ 28800.0,
                /* stiffness */ 13000000.0,
                /* damping */ 9800.0,
                /* rotor_inertia */ 2400.0,
                /* mass */ 558.0,
                /* center_of_mass */ {
                    0.091,
                    0.035,
                    0.84,
                },
                /* inertia */ {
                    31.48,
                    65.16,
                    59.85,
                    9.27,
                    11.06,
                    -1.85,
                },
            },
            {
                /* origin */ {
                    0.5,
                    0.0,
                    1.045,
                },
                /* axis */ {
                    0.0,
                    1.0,
                    0.0,
                },
                /* limits */ {
                    -2.2689280275926285,
                    0.3490658503988659,
                },
                /* max_rate */ 0.6981317007977318,
                /* max_torque */ 28800.0,
                /* stiffness */ 15000000.0,
                /* damping */ 8600.0,
                /* rotor_inertia */ 2400.0,
                /* mass */ 485.0,
                /* center_of_mass */ {
                    0.453,
                    -0.31,
                    0.0,
                },
                /* inertia */ {
                    13.32,
                    112.74,
                    113.72,
                    -0.29,
                    -11.57,
                    0.25,
                },
            },
            {
                /* origin */ {
                    1.3,
                    0.0,
                    0.0,
                },
                /* axis */ {
                    0.0,
                    1.0,
                    0.0,
                },
                /* limits */ {
                    -1.7453292519943295,
                    2.5132741228718345,
                },
                /* max_rate */ 0.6544984694978736,
                /* max_torque */ 22660.0,
                /* stiffness */ 6200000.0,
                /* damping */ 3300.0,
                /* rotor_inertia */ 1400.0,
                /* mass */ 311.0,
                /* center_of_mass */ {
                    -0.043,
                    0.01,
                    -0.022,
                },
                /* inertia */ {
                    10.56,
                    25.06,
                    27.45,
                    0.98,
                    -0.3,
                    -0.11,
                },
            },
            {
                /* origin */ {
                    0.0,
                    0.0,
                    -0.055,
                },
                /* axis */ {
                    -1.0,
                    0.0,
                    0.0,
                },
                /* limits */ {
                    -6.1086523819801535,
                    6.1086523819801535,
                },
                /* max_rate */ 1.2217304763960306,
                /* max_torque */ 4380.0,
                /* stiffness */ 500000.0,
                /* damping */ 240.0,
                /* rotor_inertia */ 140.0,
                /* mass */ 86.0,
                /* center_of_mass */ {
                    0.759,
                    -0.011,
                    0.0,
                },
                /* inertia */ {
                    3.47,
                    1.42,
                    2.78,
                    0.0,
                    0.0,
                    -0.17,
                },
            },
            {
                /* origin */ {
                    1.025,
                    0.0,
                    0.0,
                },
                /* axis */ {
                    0.0,
                    1.0,
                    0.0,
                },
                /* limits */ {
                    -2.0943951023931953,
                    2.0943951023931953,
                },
                /* max_rate */ 1.2217304763960306,
                /* max_torque */ 4380.0,
                /* stiffness */ 600000.0,
                /* damping */ 340.0,
                /* rotor_inertia */ 140.0,
                /* mass */ 48.0,
                /* center_of_mass */ {
                    0.052,
                    0.038,
                    0.0,
                },
                /* inertia */ {
                    0.44,
                    0.68,
                    0.7,
                    0.11,
                    0.0,
                    0.0,
                },
            },
            {
                /* origin */ {
                    0.0,
                    0.0,
                    0.0,
                },
                /* axis */ {
                    -1.0,
                    0.0,
                    0.0,
                },
                /* limits */ {
                    -6.1086523819801535,
                    6.1086523819801535,
                },
                /* max_rate */ 1.9198621771937625,
                /* max_torque */ 2150.0,
                /* stiffness */ 400000.0,
                /* damping */ 75.0,
                /* rotor_inertia */ 60.0,
                /* mass */ 7.0,
                /* center_of_mass */ {
                    0.27,
                    0.0,
                    0.0,
                },
                /* inertia */ {
                    0.034,
                    0.018,
                    0.018,
                    0.0,
                    0.0,
                    0.0,
                },
            },
        },
        /* viscous */ {
            2600.0,
            2800.0,
            1900.0,
            260.0,
            240.0,
            160.0,
        },
        /* coulomb */ {
            900.0,
            950.0,
            620.0,
            140.0,
            130.0,
            80.0,
        },
        /* smoothing */ 0.001,
        /* cosine_terms */ 3,
        /* table_points */ 0,
        /* cosine */ {
            -9000.0,
            -80.0,
            290.0,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
        },
        /* phase */ 0.0,
        /* table */ {
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
            {
                0.0,
                0.0,
            },
        },
        /* flange_offset */ {
            0.29,
            0.0,
            0.0,
        },
        /* tool_mass */ 180.0,
        /* tool_center_of_mass */ {
            0.18,
            0.0,
            0.0,
        },
        /* tool_inertia */ {
            4.5,
            9.0,
            9.0,
            0.0,
            0.0,
            0.0,
        },
        /* tcp_from_flange */ {
            0.4,
            0.0,
            0.0,
        },
        /* tool_z_axis */ {
            1.0,
            0.0,
            0.0,
        },
        /* tool_y_axis */ {
            0.0,
            1.0,
            0.0,
        },
    },
    /* control */ {
        /* scheme */ 3,
        /* reserved */ 0,
        /* period */ 0.012,
        /* position_kp */ {
            3700000.0,
            3700000.0,
            1840000.0,
            160000.0,
            182000.0,
            61800.0,
        },
        /* position_ki */ {
            66700000.0,
            61600000.0,
            30700000.0,
            1070000.0,
            1820000.0,
            515000.0,
        },
        /* position_kd */ {
            92500.0,
            84700.0,
            42300.0,
            5600.0,
            5300.0,
            2170.0,
        },
        /* force_kp */ 5e-9,
        /* force_ki */ 5.4e-7,
        /* force_kd */ 0.0,
        /* force_max_correction */ 0.02,
        /* force_max_rate */ 0.02,
        /* material_stiffness */ 30000000.0,
        /* tuned_stiffness */ 4210000.0,
        /* lateral */ {
            /* bandwidth */ 25.132741228718345,
            /* size */ 0.013,
            /* rate */ 0.01,
        },
        /* orientation */ {
            /* bandwidth */ 25.132741228718345,
            /* size */ 0.015,
            /* rate */ 0.02,
        },
        /* force_sensor_moment */ 5000.0,
        /* force_sensor_force */ 30000.0,
        /* force_sensor_disagreement */ 5000.0,
    },
    /* law */ {
        /* name */ "elastostatic",
        /* length */ 2.0,
        /* following_rate */ 6.0,
        /* following_along */ 1.75,
        /* following_size */ 0.002,
        /* gain_count */ 2,
        /* reserved */ 0,
        /* gains */ {
            {
                /* key */ "crosstalk",
                /* count */ 2,
                /* reserved */ 0,
                /* values */ {
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                },
            },
            {
                /* key */ "wrench_filter_hz",
                /* count */ 1,
                /* reserved */ 0,
                /* values */ {
                    5.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                },
            },
            {
                /* key */ "",
                /* count */ 0,
                /* reserved */ 0,
                /* values */ {
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                },
            },
            {
                /* key */ "",
                /* count */ 0,
                /* reserved */ 0,
                /* values */ {
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                },
            },
            {
                /* key */ "",
                /* count */ 0,
                /* reserved */ 0,
                /* values */ {
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                },
            },
            {
                /* key */ "",
                /* count */ 0,
                /* reserved */ 0,
                /* values */ {
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                },
            },
            {
                /* key */ "",
                /* count */ 0,
                /* reserved */ 0,
                /* values */ {
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                },
            },
            {
                /* key */ "",
                /* count */ 0,
                /* reserved */ 0,
                /* values */ {
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                },
            },
        },
    },
};

#endif
