/* The core of a welding robot's controller and its compensation laws: see docs/c-interface.md.
   Written by cbindgen from c-interface/src; c-interface/tests/header.rs compares. Licence: MIT OR Apache-2.0. */

#ifndef TRUEWELD_H
#define TRUEWELD_H

#include <stddef.h>
#include <stdint.h>

/*
 Version of the structs and functions.
 */
#define TRUEWELD_INTERFACE_VERSION 1

/*
 Most readings of a seam sensor in one period.
 */
#define TRUEWELD_MEASUREMENTS 8

/*
 Alignment of the memory, bytes.
 */
#define TRUEWELD_MEMORY_ALIGNMENT 8

/*
 Bytes of memory that are enough for any law in `float`.
 */
#define TRUEWELD_MEMORY_BYTES_F32 32768

/*
 Bytes of memory that are enough for any law in `double`.
 */
#define TRUEWELD_MEMORY_BYTES_F64 65536

/*
 How a call went. 0: as it should. Above 0: a fault in this period; the outputs hold a torque that
 is safe to apply. Below 0: the call was wrong; nothing was changed.
 */
enum TrueweldStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   As it should.
   */
  TRUEWELD_STATUS_OK = 0,
  /*
   The encoder `joint` is no number, or jumped by more than the joint can move.
   */
  TRUEWELD_STATUS_FAULT_ENCODER = 1,
  /*
   The force sensor gave no number, is stuck, is beyond its range, or the drives contradict it.
   */
  TRUEWELD_STATUS_FAULT_FORCE = 2,
  /*
   The set-point is no number, its axes are no rotation, or it is far out of reach.
   */
  TRUEWELD_STATUS_FAULT_SETPOINT = 3,
  /*
   The arm is singular here.
   */
  TRUEWELD_STATUS_FAULT_SINGULAR = 4,
  /*
   The joint `joint` is outside its limits.
   */
  TRUEWELD_STATUS_FAULT_LIMIT = 5,
  /*
   The law cannot form a correction, or `nominal` or `path` cannot be; the last one is held.
   */
  TRUEWELD_STATUS_FAULT_COMPENSATION = 6,
  /*
   A pointer is null.
   */
  TRUEWELD_STATUS_NULL = -1,
  /*
   A pointer is not aligned for what it points to; memory: TRUEWELD_MEMORY_ALIGNMENT.
   */
  TRUEWELD_STATUS_ALIGNMENT = -2,
  /*
   The memory is too small.
   */
  TRUEWELD_STATUS_MEMORY_SIZE = -3,
  /*
   The memory holds no core of this scalar: `initialise` comes first.
   */
  TRUEWELD_STATUS_NOT_INITIALISED = -4,
  /*
   The core was not started: `start` comes before `cycle`.
   */
  TRUEWELD_STATUS_NOT_STARTED = -5,
  /*
   A struct is of another version.
   */
  TRUEWELD_STATUS_VERSION = -6,
  /*
   A struct is of another size: compiler or header do not fit the library.
   */
  TRUEWELD_STATUS_STRUCT_SIZE = -7,
  /*
   A count is above its bound, or a flag is neither 0 nor 1.
   */
  TRUEWELD_STATUS_COUNT = -8,
  /*
   A number is NaN or infinite.
   */
  TRUEWELD_STATUS_NOT_FINITE = -9,
  /*
   The robot of the configuration cannot be one.
   */
  TRUEWELD_STATUS_ROBOT = -10,
  /*
   A number of the controller's configuration is out of range.
   */
  TRUEWELD_STATUS_CONTROL = -11,
  /*
   The law of the configuration is unknown.
   */
  TRUEWELD_STATUS_LAW = -12,
  /*
   A gain of the law is missing, unknown or out of range.
   */
  TRUEWELD_STATUS_GAIN = -13,
  /*
   The pose is out of reach.
   */
  TRUEWELD_STATUS_UNREACHABLE = -14,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TrueweldStatus TrueweldStatus;
#else
typedef int32_t TrueweldStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 One joint, SI units and rad; see [`JointParameters`].
 */
typedef struct {
  /*
   Origin in the previous joint's frame, m.
   */
  double origin[3];
  /*
   Unit vector of the axis, in the link frame.
   */
  double axis[3];
  /*
   Lower and upper position limit, rad.
   */
  double limits[2];
  /*
   Largest speed, rad/s.
   */
  double max_rate;
  /*
   Largest drive torque seen from the joint, N·m.
   */
  double max_torque;
  /*
   Stiffness of the drive train, N·m/rad.
   */
  double stiffness;
  /*
   Damping of the drive train, N·m·s/rad.
   */
  double damping;
  /*
   Inertia of motor and gear seen from the joint, kg·m².
   */
  double rotor_inertia;
  /*
   Mass of the link, kg.
   */
  double mass;
  /*
   Centre of mass in the link frame, m.
   */
  double center_of_mass[3];
  /*
   Inertia about the centre of mass, axes of the link frame: xx, yy, zz, xy, xz, yz, kg·m².
   */
  double inertia[6];
} TrueweldJointNumbers;

/*
 The robot as the controller believes it is, SI units and rad; see [`RobotParameters`].
 */
typedef struct {
  /*
   Acceleration of gravity in B, m/s².
   */
  double gravity[3];
  /*
   The joints, A1 first.
   */
  TrueweldJointNumbers joints[6];
  /*
   Viscous friction of the motors, N·m·s/rad.
   */
  double viscous[6];
  /*
   Coulomb friction of the motors, N·m.
   */
  double coulomb[6];
  /*
   Rate over which the Coulomb friction turns round, rad/s.
   */
  double smoothing;
  /*
   How many terms of the counterbalance's cosine series count.
   */
  uint32_t cosine_terms;
  /*
   How many points of the counterbalance's table count.
   */
  uint32_t table_points;
  /*
   Terms of the cosine series, N·m.
   */
  double cosine[8];
  /*
   Angle of A2 that the series counts from, rad.
   */
  double phase;
  /*
   Points of the table: angle of A2, rad, and torque, N·m.
   */
  double table[24][2];
  /*
   Flange centre in the A6 frame, m.
   */
  double flange_offset[3];
  /*
   Mass of the tool, kg.
   */
  double tool_mass;
  /*
   The tool's centre of mass from the flange, m.
   */
  double tool_center_of_mass[3];
  /*
   The tool's inertia about its centre of mass: xx, yy, zz, xy, xz, yz, kg·m².
   */
  double tool_inertia[6];
  /*
   Tool centre point from the flange, m.
   */
  double tcp_from_flange[3];
  /*
   z axis of the tool frame T in axes of the A6 link.
   */
  double tool_z_axis[3];
  /*
   y axis of the tool frame T in axes of the A6 link.
   */
  double tool_y_axis[3];
} TrueweldRobotNumbers;

/*
 Bounds and speed of a compensation loop; see [`LoopLimits`].
 */
typedef struct {
  /*
   Bandwidth, rad/s.
   */
  double bandwidth;
  /*
   Largest correction, m or rad.
   */
  double size;
  /*
   Largest rate, m/s or rad/s.
   */
  double rate;
} TrueweldLimitNumbers;

/*
 Gains and limits of the controller.
 */
typedef struct {
  /*
   1: parallel, 2: superposed, 3: external.
   */
  uint32_t scheme;
  /*
   0.
   */
  uint32_t reserved;
  /*
   Control period, s.
   */
  double period;
  /*
   K_p of the joint position loop, N·m/rad.
   */
  double position_kp[6];
  /*
   K_i of the joint position loop, N·m/(rad·s).
   */
  double position_ki[6];
  /*
   K_d of the joint position loop, N·m·s/rad.
   */
  double position_kd[6];
  /*
   K_pf of the force loop: N/N, of the external controller m/N.
   */
  double force_kp;
  /*
   K_if of the force loop: 1/s, of the external controller m/(N·s).
   */
  double force_ki;
  /*
   K_df of the force loop: N·s/m, of the external controller s.
   */
  double force_kd;
  /*
   Largest correction of the force loop: N, of the external controller m.
   */
  double force_max_correction;
  /*
   Largest rate of the force loop: N/s, of the external controller m/s.
   */
  double force_max_rate;
  /*
   Stiffness of the material against depth, N/m. External controller alone.
   */
  double material_stiffness;
  /*
   Stiffness that the tool met where the gains were tuned, N/m. External controller alone.
   */
  double tuned_stiffness;
  /*
   Of the correction's translation.
   */
  TrueweldLimitNumbers lateral;
  /*
   Of the correction's rotation.
   */
  TrueweldLimitNumbers orientation;
  /*
   Largest moment that the force sensor can measure, N·m: one that reads as much is at fault. 0:
   not known.
   */
  double force_sensor_moment;
  /*
   Largest force that the force sensor can measure, N, likewise.
   */
  double force_sensor_force;
  /*
   Largest difference between the push that the force sensor shows and the push that the drives
   bear, N: beyond it for four periods, the sensor is at fault. 0: not checked.
   */
  double force_sensor_disagreement;
} TrueweldControlNumbers;

/*
 A name of ASCII characters, filled up with zeros.
 */
typedef char TrueweldName[32];

/*
 One gain of a law.
 */
typedef struct {
  /*
   Its key, as in a control file; the unit is its last part.
   */
  TrueweldName key;
  /*
   How many of the numbers count: 1, or as many as the gain has.
   */
  uint32_t count;
  /*
   0.
   */
  uint32_t reserved;
  /*
   Its numbers.
   */
  double values[6];
} TrueweldGainNumbers;

/*
 The law and its gains.
 */
typedef struct {
  /*
   Its name, as on the command line.
   */
  TrueweldName name;
  /*
   Length of the weld, m.
   */
  double length;
  /*
   Outer integral: μ across the seam, rad/s.
   */
  double following_rate;
  /*
   Outer integral: μ along the seam, rad/s.
   */
  double following_along;
  /*
   Outer integral: largest |c|, m.
   */
  double following_size;
  /*
   How many of the gains count: all that the law has, or none for its defaults.
   */
  uint32_t gain_count;
  /*
   0.
   */
  uint32_t reserved;
  /*
   The gains.
   */
  TrueweldGainNumbers gains[8];
} TrueweldLawNumbers;

/*
 All that a controller's core is built from.
 */
typedef struct {
  /*
   [`CONFIGURATION_VERSION`].
   */
  uint32_t version;
  /*
   Size of this struct in bytes.
   */
  uint32_t bytes;
  /*
   The robot model, with what measurements improved in it.
   */
  TrueweldRobotNumbers robot;
  /*
   The controller.
   */
  TrueweldControlNumbers control;
  /*
   The law.
   */
  TrueweldLawNumbers law;
} TrueweldConfiguration;


/*
 A pose: b_from_t, of the tool frame T in the base frame B.
 */
typedef struct {
  /*
   Rotation matrix, row by row.
   */
  float rotation[9];
  /*
   Position, m.
   */
  float position[3];
} TrueweldPose_f32;

/*
 What an instrument outside the robot saw of the tool's deviation.
 */
typedef struct {
  /*
   What was seen, m or rad.
   */
  float deviation;
  /*
   The direction that it sees, axes of W: per rad of rotation, then per m of displacement.
   */
  float along[6];
  /*
   Standard deviation of its noise, m or rad.
   */
  float noise;
  /*
   How long ago it was seen, s.
   */
  float age;
  /*
   How far ahead of the tool along the seam, m.
   */
  float ahead;
} TrueweldMeasurement_f32;

/*
 What one control period is given.
 */
typedef struct {
  /*
   TRUEWELD_INTERFACE_VERSION.
   */
  uint32_t version;
  /*
   Size of this struct in bytes.
   */
  uint32_t bytes;
  /*
   1: the force loop is closed and holds `force`. 0: depth under position control.
   */
  uint32_t force_closed;
  /*
   How many of the measurements count.
   */
  uint32_t measurement_count;
  /*
   The set-point of the encoders' pose before correction.
   */
  TrueweldPose_f32 setpoint;
  /*
   Where the real tool should be.
   */
  TrueweldPose_f32 nominal;
  /*
   Axes of the weld frame W in B, row by row: x along the weld, z into the material.
   */
  float b_from_w[9];
  /*
   Push into the material, N.
   */
  float force;
  /*
   Rate of the spindle, rad/s; 0 where it stands or is not known.
   */
  float spindle_speed;
  /*
   Encoder angles, rad.
   */
  float encoder[6];
  /*
   Encoder rates, rad/s.
   */
  float encoder_rate[6];
  /*
   Motor torque of the last period, seen from the joint, N·m; all 0 where it is not known.
   */
  float motor_torque[6];
  /*
   What the environment applies to the tool at the TCP, axes of T: moment N·m, then force N.
   */
  float wrench[6];
  /*
   Where the tool is along the seam, m.
   */
  float path;
  /*
   The load that the weld is planned with here, axes of W: moment N·m, then force N.
   */
  float planned[6];
  /*
   Readings of a seam sensor since the last period.
   */
  TrueweldMeasurement_f32 measurements[TRUEWELD_MEASUREMENTS];
} TrueweldInputs_f32;

/*
 What one control period gives.
 */
typedef struct {
  /*
   TRUEWELD_INTERFACE_VERSION, set by the caller.
   */
  uint32_t version;
  /*
   Size of this struct in bytes, set by the caller.
   */
  uint32_t bytes;
  /*
   The joint of a fault, 0 = A1; 6 where a fault is of none.
   */
  uint32_t joint;
  /*
   What was held at a limit: 1 a drive's torque, 2 the force loop, 4 the compensation, or a sum.
   */
  uint32_t limited;
  /*
   Motor torque, seen from the joint, N·m.
   */
  float torque[6];
  /*
   Correction of the set-point in force, axes of W: rad, then m.
   */
  float correction[6];
  /*
   Force error as the force loop sees it, N.
   */
  float force_error;
  /*
   Depth that the external controller adds, m.
   */
  float depth_correction;
  /*
   Push that the parallel and the superposed controller add, N.
   */
  float push;
} TrueweldOutputs_f32;

/*
 A pose: b_from_t, of the tool frame T in the base frame B.
 */
typedef struct {
  /*
   Rotation matrix, row by row.
   */
  double rotation[9];
  /*
   Position, m.
   */
  double position[3];
} TrueweldPose_f64;

/*
 What an instrument outside the robot saw of the tool's deviation.
 */
typedef struct {
  /*
   What was seen, m or rad.
   */
  double deviation;
  /*
   The direction that it sees, axes of W: per rad of rotation, then per m of displacement.
   */
  double along[6];
  /*
   Standard deviation of its noise, m or rad.
   */
  double noise;
  /*
   How long ago it was seen, s.
   */
  double age;
  /*
   How far ahead of the tool along the seam, m.
   */
  double ahead;
} TrueweldMeasurement_f64;

/*
 What one control period is given.
 */
typedef struct {
  /*
   TRUEWELD_INTERFACE_VERSION.
   */
  uint32_t version;
  /*
   Size of this struct in bytes.
   */
  uint32_t bytes;
  /*
   1: the force loop is closed and holds `force`. 0: depth under position control.
   */
  uint32_t force_closed;
  /*
   How many of the measurements count.
   */
  uint32_t measurement_count;
  /*
   The set-point of the encoders' pose before correction.
   */
  TrueweldPose_f64 setpoint;
  /*
   Where the real tool should be.
   */
  TrueweldPose_f64 nominal;
  /*
   Axes of the weld frame W in B, row by row: x along the weld, z into the material.
   */
  double b_from_w[9];
  /*
   Push into the material, N.
   */
  double force;
  /*
   Rate of the spindle, rad/s; 0 where it stands or is not known.
   */
  double spindle_speed;
  /*
   Encoder angles, rad.
   */
  double encoder[6];
  /*
   Encoder rates, rad/s.
   */
  double encoder_rate[6];
  /*
   Motor torque of the last period, seen from the joint, N·m; all 0 where it is not known.
   */
  double motor_torque[6];
  /*
   What the environment applies to the tool at the TCP, axes of T: moment N·m, then force N.
   */
  double wrench[6];
  /*
   Where the tool is along the seam, m.
   */
  double path;
  /*
   The load that the weld is planned with here, axes of W: moment N·m, then force N.
   */
  double planned[6];
  /*
   Readings of a seam sensor since the last period.
   */
  TrueweldMeasurement_f64 measurements[TRUEWELD_MEASUREMENTS];
} TrueweldInputs_f64;

/*
 What one control period gives.
 */
typedef struct {
  /*
   TRUEWELD_INTERFACE_VERSION, set by the caller.
   */
  uint32_t version;
  /*
   Size of this struct in bytes, set by the caller.
   */
  uint32_t bytes;
  /*
   The joint of a fault, 0 = A1; 6 where a fault is of none.
   */
  uint32_t joint;
  /*
   What was held at a limit: 1 a drive's torque, 2 the force loop, 4 the compensation, or a sum.
   */
  uint32_t limited;
  /*
   Motor torque, seen from the joint, N·m.
   */
  double torque[6];
  /*
   Correction of the set-point in force, axes of W: rad, then m.
   */
  double correction[6];
  /*
   Force error as the force loop sees it, N.
   */
  double force_error;
  /*
   Depth that the external controller adds, m.
   */
  double depth_correction;
  /*
   Push that the parallel and the superposed controller add, N.
   */
  double push;
} TrueweldOutputs_f64;



#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 The version of this interface: what `version` of the structs must be.
 */
uint32_t trueweld_interface_version(void);

/*
 What a status means, in a line of English.
 */
const char *trueweld_status_text(int32_t status);

/*
 SHA-256 of the configuration that a core was built from, to compare with a certificate's: 32
 bytes to `digest`.

 # Safety
 `memory` is null or was given to an `initialise`; `digest` is null or has 32 bytes.
 */
TrueweldStatus trueweld_digest(const void *memory, uint8_t *digest);

/*
 Bytes of memory that the law of a configuration needs in `float`, to `bytes`; never more than
 TRUEWELD_MEMORY_BYTES_F32.

 # Safety
 The pointers are null or point to what their types say.
 */
TrueweldStatus trueweld_f32_bytes(const TrueweldConfiguration *configuration, size_t *bytes);

/*
 Builds robot model, controller and law in the caller's memory, in `float`, and checks the whole
 configuration. The configuration is not needed afterwards.

 # Safety
 `memory` is null or has `bytes` bytes that nobody else uses; `configuration` is null or points
 to one.
 */
TrueweldStatus trueweld_f32_initialise(void *memory, size_t bytes, const TrueweldConfiguration *configuration);

/*
 Starts a weld from rest: the drives hold `torque`, N·m, at `encoder` angles, rad; 6 numbers
 each.

 # Safety
 `memory` is null or was given to `trueweld_f32_initialise`; the others are null or have 6
 numbers.
 */
TrueweldStatus trueweld_f32_start(void *memory, const float *encoder, const float *torque);

/*
 One control period. With a status of 0 or above `outputs` holds a torque that is safe to apply;
 below 0 the call was wrong, and `outputs` is as it was.

 # Safety
 `memory` is null or was given to `trueweld_f32_initialise` and is not used by another call at the
 same time; the others are null or point to what their types say.
 */
TrueweldStatus trueweld_f32_cycle(void *memory, const TrueweldInputs_f32 *inputs, TrueweldOutputs_f32 *outputs);

/*
 Joint angles at which the unloaded model's tool is at a pose, on the branch nearest to `near`, to
 `angles`, rad; 6 numbers each.

 # Safety
 As of `trueweld_f32_start`; `pose` is null or points to one.
 */
TrueweldStatus trueweld_f32_inverse(const void *memory, const TrueweldPose_f32 *pose, const float *near, float *angles);

/*
 The pose that the encoders show while the real tool is at `nominal` under gravity alone, to
 `pose`: the set-point of a weld that is not taught by hand. `near`: 6 joint angles near it, rad.

 # Safety
 As of `trueweld_f32_start`; the poses are null or point to one.
 */
TrueweldStatus trueweld_f32_taught(const void *memory,
                                   const TrueweldPose_f32 *nominal,
                                   const float *near,
                                   TrueweldPose_f32 *pose);

/*
 As `trueweld_f32_bytes`, in `double`.

 # Safety
 The pointers are null or point to what their types say.
 */
TrueweldStatus trueweld_f64_bytes(const TrueweldConfiguration *configuration, size_t *bytes);

/*
 As `trueweld_f32_initialise`, in `double`.

 # Safety
 As there.
 */
TrueweldStatus trueweld_f64_initialise(void *memory, size_t bytes, const TrueweldConfiguration *configuration);

/*
 As `trueweld_f32_start`, in `double`.

 # Safety
 As there.
 */
TrueweldStatus trueweld_f64_start(void *memory, const double *encoder, const double *torque);

/*
 As `trueweld_f32_cycle`, in `double`.

 # Safety
 As there.
 */
TrueweldStatus trueweld_f64_cycle(void *memory, const TrueweldInputs_f64 *inputs, TrueweldOutputs_f64 *outputs);

/*
 As `trueweld_f32_inverse`, in `double`.

 # Safety
 As there.
 */
TrueweldStatus trueweld_f64_inverse(const void *memory,
                                    const TrueweldPose_f64 *pose,
                                    const double *near,
                                    double *angles);

/*
 As `trueweld_f32_taught`, in `double`.

 # Safety
 As there.
 */
TrueweldStatus trueweld_f64_taught(const void *memory,
                                   const TrueweldPose_f64 *nominal,
                                   const double *near,
                                   TrueweldPose_f64 *pose);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TRUEWELD_H */
