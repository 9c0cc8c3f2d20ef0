//! The variables of both models: what a controller is given, what it commands, and what a cell
//! shows beyond its instruments.
//!
//! What a plant gives and a law takes has one name in both, so that they are joined by names.
//! Frames: B base, F flange, T tool, W weld (x along the seam, z into the material); rotations are
//! matrices, row by row.

use crate::variable::PhysicalQuantity::{
    Angle, AngularVelocity, Force, Length, Number, Time, Torque,
};
use crate::variable::ValueKind::{Boolean, Integer, Real};
use crate::variable::{VariableGroup, variables};
use nalgebra::{Matrix3, Vector3};
use trueweld_core::compensation::DeviationMeasurement;
use trueweld_core::control::{SensorReadings, Setpoint};
use trueweld_core::{Fault, JointVector, Pose, Twist, Wrench};
use trueweld_plant::simulate::{CellView, Controlled, Reference};

/// Most readings of a seam sensor in one period, as in the C interface.
pub(crate) const READINGS_A_PERIOD: usize = 8;

variables! {
    /// What a controller is given in one period.
    Seen {
        setpoint_rotation: [[f64; 3]; 3] = Real(Number), "Set-point of the encoders' pose before correction: axes of T in B";
        setpoint_position: [f64; 3] = Real(Length), "Set-point of the encoders' pose before correction: TCP in B";
        nominal_rotation: [[f64; 3]; 3] = Real(Number), "Where the real tool should be: axes of T in B";
        nominal_position: [f64; 3] = Real(Length), "Where the real tool should be: TCP in B";
        weld_axes: [[f64; 3]; 3] = Real(Number), "Axes of the weld frame W in B: x along the seam, z into the material";
        force_closed: f64 = Boolean, "The force loop is closed and holds the push; false: depth under position control";
        push: f64 = Real(Force), "Push into the material that is asked for";
        spindle_rate: f64 = Real(AngularVelocity), "Rate of the spindle; 0 where it stands or is not known";
        encoder: [f64; 6] = Real(Angle), "Encoder angles, A1 first, seen from the joint";
        encoder_rate: [f64; 6] = Real(AngularVelocity), "Encoder rates";
        motor_torque: [f64; 6] = Real(Torque), "Motor torques of the last period, seen from the joint; all 0 where not known";
        wrench_moment: [f64; 3] = Real(Torque), "Force sensor: moment of the environment on the tool at the TCP, axes of T";
        wrench_force: [f64; 3] = Real(Force), "Force sensor: force of the environment on the tool, axes of T";
        path: f64 = Real(Length), "Where the tool is along the seam";
        planned_moment: [f64; 3] = Real(Torque), "Load that the weld is planned with here: moment at the TCP, axes of W";
        planned_force: [f64; 3] = Real(Force), "Load that the weld is planned with here: force, axes of W";
        seam_count: f64 = Integer, "How many readings of the seam sensor came since the last period, 0 to 8";
        seam_deviation: [f64; 8] = Real(Number), "Seam sensor: what was seen of the deviation, m or rad";
        seam_along_rotation: [[f64; 3]; 8] = Real(Number), "Seam sensor: direction that a reading sees, per rad of rotation, axes of W";
        seam_along_translation: [[f64; 3]; 8] = Real(Number), "Seam sensor: direction that a reading sees, per m of displacement, axes of W";
        seam_noise: [f64; 8] = Real(Number), "Seam sensor: standard deviation of a reading's noise, m or rad";
        seam_age: [f64; 8] = Real(Time), "Seam sensor: how long ago a reading was taken";
        seam_ahead: [f64; 8] = Real(Length), "Seam sensor: how far ahead of the tool along the seam it looked";
        start_encoder: [f64; 6] = Real(Angle), "Encoder angles where the weld starts from rest; with torques all 0 the instruments' are taken";
        start_torque: [f64; 6] = Real(Torque), "Motor torques that hold the arm there";
    }
}

variables! {
    /// What a controller commands in one period.
    Commanded {
        torque: [f64; 6] = Real(Torque), "Motor torques, seen from the joint, within the drives' limits";
        correction_rotation: [f64; 3] = Real(Angle), "Correction of the set-point in force: rotation vector, axes of W";
        correction_translation: [f64; 3] = Real(Length), "Correction of the set-point in force: displacement, axes of W";
        corrected_rotation: [[f64; 3]; 3] = Real(Number), "Set-point with the correction: axes of T in B";
        corrected_position: [f64; 3] = Real(Length), "Set-point with the correction: TCP in B";
        force_error: f64 = Real(Force), "Force error as the force loop sees it";
        depth_correction: f64 = Real(Length), "Depth that the external controller adds";
        added_push: f64 = Real(Force), "Push that the parallel and the superposed controller add";
        limited: f64 = Integer, "What was held at a limit: 1 a drive's torque, 2 the force loop, 4 the compensation, or a sum";
        status: f64 = Integer, "0 in order; faults: 1 encoder, 2 force sensor, 3 set-point, 4 singular arm, 5 joint limit, 6 law. The torque is safe in any case";
        fault_joint: f64 = Integer, "Joint of a fault, 1 to 6; 0 where it is of none";
    }
}

variables! {
    /// What a cell shows beyond its instruments.
    Shown {
        link: [f64; 6] = Real(Angle), "Link angles, A1 first";
        link_rate: [f64; 6] = Real(AngularVelocity), "Link rates";
        motor: [f64; 6] = Real(Angle), "Motor angles, seen from the joint, before the encoders' step";
        motor_rate: [f64; 6] = Real(AngularVelocity), "Motor rates, seen from the joint";
        tool_rotation: [[f64; 3]; 3] = Real(Number), "Real tool: axes of T in B";
        tool_position: [f64; 3] = Real(Length), "Real tool: TCP in B";
        deviation_rotation: [f64; 3] = Real(Angle), "Real tool against the real seam: rotation vector, axes of W";
        deviation_translation: [f64; 3] = Real(Length), "Real tool against the real seam: along, across, into the material, axes of W";
        process_force: [f64; 3] = Real(Force), "Real force of the process on the tool, axes of W where the tool is";
        spindle_angle: f64 = Real(Angle), "Angle that the spindle has turned";
        applied_torque: [f64; 6] = Real(Torque), "Motor torques of the last period, as the drives gave them";
        torque_held: f64 = Integer, "Drives that were asked for more than their largest torque, which they gave: bit 0 is A1";
        phase: f64 = Integer, "Where the program is: 0 settles, 1 force rises, 2 feed rises, 3 steady, 4 feed falls, 5 stands";
        done: f64 = Boolean, "The program is over; the cell goes on standing";
    }
}

variables! {
    /// Motor torques from outside.
    DrivenByTorque {
        torque: [f64; 6] = Real(Torque), "Motor torques from here to the next communication point, seen from the joint";
    }
}

variables! {
    /// A correction from outside.
    DrivenByCorrection {
        correction_rotation: [f64; 3] = Real(Angle), "Correction that is asked of the set-point: rotation vector, axes of W";
        correction_translation: [f64; 3] = Real(Length), "Correction that is asked of the set-point: displacement, axes of W; depth is the force loop's";
    }
}

variables! {
    /// Parameters of a cell.
    CellParameters {
        seed: f64 = Integer, "Seed of the instruments' noise, not below 0";
    }
}

/// A matrix, row by row.
fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    // nalgebra stores columns.
    matrix.transpose().into()
}

fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_row_slice(rows.as_flattened())
}

fn pose(rotation: &[[f64; 3]; 3], position: [f64; 3]) -> Pose<f64> {
    Pose { rotation: matrix(rotation), position: position.into() }
}

impl Seen {
    /// A controller that is given nothing: axes of B everywhere, no load.
    pub(crate) fn nothing() -> Self {
        const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Self { setpoint_rotation: AXES, nominal_rotation: AXES, weld_axes: AXES, ..Self::ZERO }
    }

    /// What a cell's instruments and program give. `start`: encoder angles, rad, and torques, N·m.
    ///
    /// # Errors
    /// More readings of the seam sensor than there is room for.
    pub(crate) fn of(view: &CellView, start: &[JointVector<f64>; 2]) -> Result<Self, String> {
        let CellView { reference, readings, .. } = view;
        let Reference { nominal, setpoint, path, planned } = reference;
        let (sensed, measurements) = (&readings.sensed, &readings.measurements);
        if measurements.len() > READINGS_A_PERIOD {
            let count = measurements.len();
            return Err(format!(
                "{count} readings of the seam sensor came in one control period; expected at most {READINGS_A_PERIOD}"
            ));
        }
        let mut seen = Self {
            setpoint_rotation: rows(&setpoint.pose.rotation),
            setpoint_position: setpoint.pose.position.into(),
            nominal_rotation: rows(&nominal.rotation),
            nominal_position: nominal.position.into(),
            weld_axes: rows(&setpoint.b_from_w),
            force_closed: f64::from(setpoint.force.is_some()),
            push: setpoint.force.unwrap_or(0.0),
            spindle_rate: setpoint.spindle_speed,
            encoder: sensed.encoder.into(),
            encoder_rate: sensed.encoder_rate.into(),
            motor_torque: sensed.motor_torque.into(),
            wrench_moment: sensed.wrench.moment.into(),
            wrench_force: sensed.wrench.force.into(),
            path: *path,
            planned_moment: planned.moment.into(),
            planned_force: planned.force.into(),
            seam_count: measurements.len() as f64,
            start_encoder: start[0].into(),
            start_torque: start[1].into(),
            ..Self::ZERO
        };
        for (k, m) in measurements.iter().enumerate() {
            seen.seam_deviation[k] = m.deviation;
            seen.seam_along_rotation[k] = m.along.angular.into();
            seen.seam_along_translation[k] = m.along.linear.into();
            (seen.seam_noise[k], seen.seam_age[k], seen.seam_ahead[k]) = (m.noise, m.age, m.ahead);
        }
        Ok(seen)
    }

    /// What is asked of the tool.
    pub(crate) fn reference(&self) -> Reference {
        Reference {
            nominal: pose(&self.nominal_rotation, self.nominal_position),
            setpoint: Setpoint {
                pose: pose(&self.setpoint_rotation, self.setpoint_position),
                b_from_w: matrix(&self.weld_axes),
                force: (self.force_closed != 0.0).then_some(self.push),
                spindle_speed: self.spindle_rate,
            },
            path: self.path,
            planned: Wrench {
                moment: self.planned_moment.into(),
                force: self.planned_force.into(),
            },
        }
    }

    /// What the robot's own instruments read.
    pub(crate) fn sensed(&self) -> SensorReadings<f64> {
        SensorReadings {
            encoder: self.encoder.into(),
            encoder_rate: self.encoder_rate.into(),
            motor_torque: self.motor_torque.into(),
            wrench: Wrench { moment: self.wrench_moment.into(), force: self.wrench_force.into() },
        }
    }

    /// The readings of the seam sensor that count.
    ///
    /// # Errors
    /// A count that cannot be.
    pub(crate) fn measurements(&self) -> Result<Vec<DeviationMeasurement<f64>>, String> {
        let count = self.seam_count;
        if !(0.0..=READINGS_A_PERIOD as f64).contains(&count) {
            return Err(format!("seam_count is {count}; expected 0 to {READINGS_A_PERIOD}"));
        }
        let reading = |k: usize| DeviationMeasurement {
            deviation: self.seam_deviation[k],
            along: Twist {
                angular: self.seam_along_rotation[k].into(),
                linear: self.seam_along_translation[k].into(),
            },
            noise: self.seam_noise[k],
            age: self.seam_age[k],
            ahead: self.seam_ahead[k],
        };
        Ok((0..count as usize).map(reading).collect())
    }

    /// Encoder angles, rad, and motor torques, N·m, that a controller starts with.
    pub(crate) fn start(&self) -> [JointVector<f64>; 2] {
        let is_given = self.start_torque != [0.0; 6];
        let [encoder, torque] = if is_given {
            [self.start_encoder, self.start_torque]
        } else {
            [self.encoder, self.motor_torque]
        };
        [encoder.into(), torque.into()]
    }
}

impl Commanded {
    /// What a period of control gave. `reference`: what it was asked for.
    pub(crate) fn of(controlled: &Controlled, reference: &Reference) -> Self {
        let Controlled { command, correction_w, .. } = controlled;
        let (status, joint) = match command.fault {
            None => (0, None),
            Some(Fault::Encoder(joint)) => (1, Some(joint)),
            Some(Fault::Force) => (2, None),
            Some(Fault::Setpoint) => (3, None),
            Some(Fault::Singular) => (4, None),
            Some(Fault::Limit(joint)) => (5, Some(joint)),
            Some(Fault::Compensation) => (6, None),
        };
        let setpoint = &reference.setpoint;
        let corrected = setpoint.pose.displaced(&correction_w.rotated(&setpoint.b_from_w));
        let limited = command.limited;
        Self {
            torque: command.torque.into(),
            correction_rotation: correction_w.angular.into(),
            correction_translation: correction_w.linear.into(),
            corrected_rotation: rows(&corrected.rotation),
            corrected_position: corrected.position.into(),
            force_error: command.force_error,
            depth_correction: command.depth_correction,
            added_push: command.push,
            limited: f64::from(
                u8::from(limited.torque)
                    | u8::from(limited.force_loop) << 1
                    | u8::from(limited.compensation) << 2,
            ),
            status: f64::from(status),
            fault_joint: joint.map_or(0.0, |joint| (joint + 1) as f64),
        }
    }
}

impl DrivenByCorrection {
    /// As a demand of a law.
    pub(crate) fn demand(&self) -> Twist<f64> {
        Twist {
            angular: Vector3::from(self.correction_rotation),
            linear: Vector3::from(self.correction_translation),
        }
    }
}
