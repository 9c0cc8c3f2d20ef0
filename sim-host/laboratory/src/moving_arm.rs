//! An arm in motion without contact whose motors follow a given path.
//!
//! Equation (2.1), link side, integrated by Runge–Kutta at steps below the fastest mode's period.

use crate::error::CampaignError;
use crate::motion::{EncoderPath, Motor};
use crate::out_of_library::OutOfLibrary;
use crate::static_arm::{Unsettled, runge_kutta, settled};
use crate::track::Instant;
use nalgebra::{SVector, Vector3};
use trueweld_core::{Frames, JOINTS, JointVector, Wrench};
use trueweld_plant::cell::Cell;
use trueweld_plant::integrate::{TooFast, substeps};
use trueweld_plant::robot::{Drives, INTERNAL_STATES, JointMotion, TiltMotion};

/// Links (where bearings or base give, β of [`JointMotion`]), rates, effects' states, and place and velocity of what hangs on the tool.
type Moving = SVector<f64, { HUNG + 6 }>;

/// Where the effects' states begin, and those of what hangs on the tool.
const INTERNAL: usize = 2 * JOINTS;
const HUNG: usize = INTERNAL + INTERNAL_STATES;

/// Postures along a path at which the fastest mode is looked for.
const PATH_POSTURES: usize = 32;

/// An arm in motion without contact, its motors on a path.
#[derive(Debug)]
pub(crate) struct MovingArm<'a, P> {
    pub cell: &'a Cell,
    pub joint_names: &'a [String; JOINTS],
    pub foreign: Option<&'a OutOfLibrary>,
    pub path: &'a P,
}

impl<P: EncoderPath> MovingArm<'_, P> {
    /// The truth every `step` s from `start` to `end`, the log's own time being from 0 on: before
    /// it the arm runs in, and what remembers does not yet. It begins in balance at the rate that
    /// its motors have then.
    pub(crate) fn run(
        &self,
        start: f64,
        end: f64,
        step: f64,
    ) -> Result<Vec<Instant>, CampaignError> {
        let motor = self.path.at(start);
        // Motors that turn drag their links behind them; before a start from rest they came from
        // angles of 0.
        let came = if motor.rate.amax() > 0.0 { -motor.rate } else { motor.angle };
        let link = settled(self.cell, &motor, &came)?;
        let mut y = Moving::zeros();
        let standing = JointMotion::standing(&self.cell.robot, &link);
        y.fixed_rows_mut::<JOINTS>(0).copy_from(&standing.ok_or(Unsettled { time: start })?);
        y.fixed_rows_mut::<JOINTS>(JOINTS).copy_from(&motor.rate);
        let frames = self.cell.robot.frames(&link, &Wrench::zero(), 0.0);
        y.fixed_rows_mut::<3>(HUNG).copy_from(&frames.tcp.position);
        y.fixed_rows_mut::<3>(HUNG + 3).copy_from(&frames.twist(&motor.rate).linear);

        let count = ((end - start) / step).round() as usize;
        let along = |k: usize| start + (end - start) * k as f64 / PATH_POSTURES as f64;
        let postures = (0..=PATH_POSTURES).map(|k| self.path.at(along(k)).angle);
        let told = |mode: TooFast| mode.told(&self.joint_names[mode.0.joint]);
        let substeps = substeps(&self.cell.robot, postures, step, step)
            .map_err(|mode| CampaignError::TooFast(told(mode)))?;
        let h = step / substeps as f64;
        let mut instants = Vec::with_capacity(count + 1);
        for k in 0..=count {
            let time = start + k as f64 * step;
            instants.push(self.instant(time, &y));
            for k in 0..substeps {
                let begun = time + k as f64 * h;
                y += runge_kutta(&y, h, |after, y| self.slope(begun + after, y));
            }
            if !y.sum().is_finite() {
                return Err(Unsettled { time }.into());
            }
        }
        Ok(instants)
    }

    fn drives(motor: &Motor, y: &Moving) -> Drives {
        Drives {
            link: y.fixed_rows::<JOINTS>(0).into_owned(),
            link_rate: y.fixed_rows::<JOINTS>(JOINTS).into_owned(),
            motor: motor.angle,
            motor_rate: motor.rate,
        }
    }

    /// Frames, and the wrench of what hangs on the tool or shakes it.
    fn frames(&self, time: f64, drives: &Drives, y: &Moving) -> (Frames<f64>, Wrench<f64>) {
        let (robot, clock) = (&self.cell.robot, time.max(0.0));
        let free = robot.frames(&drives.link, &Wrench::zero(), clock);
        let Some(foreign) = self.foreign else {
            return (free, Wrench::zero());
        };
        let mut force = foreign.force(clock);
        if let Some(hung) = foreign.appendage() {
            let away = y.fixed_rows::<3>(HUNG) - free.tcp.position;
            let faster = y.fixed_rows::<3>(HUNG + 3) - free.twist(&drives.link_rate).linear;
            force += away * hung.stiffness + faster * hung.damping;
        }
        let wrench = Wrench { moment: Vector3::zeros(), force };
        (robot.frames(&drives.link, &wrench, clock), wrench)
    }

    fn slope(&self, time: f64, y: &Moving) -> Moving {
        let robot = &self.cell.robot;
        let motor = self.path.at(time);
        let drives = Self::drives(&motor, y);
        let internal = &y.as_slice()[INTERNAL..HUNG];
        let (frames, wrench) = self.frames(time, &drives, y);
        let motors = (&drives, &motor.acceleration);
        let moves = JointMotion::new(robot, &frames, motors, internal, &wrench);
        let mut slope = Moving::zeros();
        slope.fixed_rows_mut::<JOINTS>(0).copy_from(&drives.link_rate);
        let nowhere = JointVector::repeat(f64::NAN);
        let acceleration = moves.map_or(nowhere, |m| m.tilts.acceleration);
        slope.fixed_rows_mut::<JOINTS>(JOINTS).copy_from(&acceleration);
        if time >= 0.0 {
            let joints = moves.map_or(drives, |m| m.joints);
            robot.internal_rates(&joints, internal, &mut slope.as_mut_slice()[INTERNAL..HUNG]);
        }
        if let Some(hung) = self.foreign.and_then(OutOfLibrary::appendage) {
            let velocity = y.fixed_rows::<3>(HUNG + 3).into_owned();
            slope.fixed_rows_mut::<3>(HUNG).copy_from(&velocity);
            slope.fixed_rows_mut::<3>(HUNG + 3).copy_from(&(-wrench.force / hung.mass));
        }
        slope
    }

    fn instant(&self, time: f64, y: &Moving) -> Instant {
        let robot = &self.cell.robot;
        let motor = self.path.at(time);
        let drives = Self::drives(&motor, y);
        let internal = &y.as_slice()[INTERNAL..HUNG];
        let (frames, wrench) = self.frames(time, &drives, y);
        let motors = (&drives, &motor.acceleration);
        let moves = JointMotion::new(robot, &frames, motors, internal, &wrench);
        let nowhere = JointVector::repeat(f64::NAN);
        let JointMotion { joints, spring, tilts } = moves.unwrap_or(JointMotion {
            joints: drives,
            spring: nowhere,
            tilts: TiltMotion { rate: nowhere, ..TiltMotion::default() },
        });
        let friction = JointVector::from_fn(|i, _| {
            robot.friction(&joints, i, spring[i], internal, time.max(0.0)).value
        });
        Instant {
            motor: motor.angle,
            link: joints.link,
            torque: robot.model.rotor_inertia().component_mul(&motor.acceleration)
                + spring
                + friction,
            pose: robot.frames_in_motion(&joints.link, &tilts, &wrench, time.max(0.0)).tcp,
            wrench: Wrench::zero(),
        }
    }
}
