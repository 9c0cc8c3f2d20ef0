//! How exact predictions need be, beside the noise of what they are compared with.
//!
//! An error that nobody asks about has a scale of its own, which is stated for each channel, and is
//! no noise: rows near each other are off alike by it, so that a long log makes it no more
//! significant. Where a log does not state the noise of an instrument, what its readings scatter by
//! is the least that they are off by, and nothing says that they are true to it: then, if no accuracy
//! is stated either, the usual trueness of such an instrument stands in.

use super::compared::{Compared, ComparedQuantity};
use std::collections::BTreeMap;
use trueweld_logs::log::Log;
use trueweld_plant::input::Accuracy;

/// Trueness of a laser tracker at some metres, m (maximum permissible error 15 µm + 6 µm/m of
/// current trackers, as a standard deviation of about half), and of the rotation that three reflectors
/// a few decimetres apart give, rad.
const USUAL_POSITION: f64 = 2e-5;
const USUAL_ROTATION: f64 = 1e-4;
/// Graduation of a second encoder on the link, rad: ± 4″.
const USUAL_LINK_ENCODER: f64 = 2e-5;
/// Share of the largest reading that a torque from motor current, and a force sensor, is true to.
const USUAL_TORQUE_SHARE: f64 = 0.02;
const USUAL_FORCE_SHARE: f64 = 0.005;

/// Takes into the deviations what is asked for, and what is usual where nothing is stated.
pub(super) fn allow(compared: &mut [Compared], log: &Log, asked: Accuracy) {
    let mut largest: BTreeMap<(ComparedQuantity, u8), f64> = BTreeMap::new();
    for c in compared.iter() {
        let most = largest.entry((c.quantity, c.component)).or_default();
        *most = most.max(c.measured.abs());
    }
    for c in compared.iter_mut() {
        let largest = largest[&(c.quantity, c.component)];
        let stated = log.noise.states(c.quantity.channel());
        let usual = || if stated { 0.0 } else { usual(c.quantity, largest) };
        let accuracy = of(asked, c.quantity).unwrap_or_else(usual);
        let noise = c.deviation * c.deviation;
        c.deviation = c.deviation.hypot(accuracy);
        c.alike *= noise / (c.deviation * c.deviation);
        c.accuracy = accuracy;
    }
}

fn of(asked: Accuracy, quantity: ComparedQuantity) -> Option<f64> {
    match quantity {
        ComparedQuantity::Position => asked.tcp_position,
        ComparedQuantity::Rotation => asked.tcp_rotation,
        ComparedQuantity::LinkEncoder => asked.link_encoder,
        ComparedQuantity::MotorTorque => asked.motor_torque,
        ComparedQuantity::Force | ComparedQuantity::Ripple { .. } => asked.force,
        ComparedQuantity::Moment => asked.moment,
    }
}

fn usual(quantity: ComparedQuantity, largest: f64) -> f64 {
    match quantity {
        ComparedQuantity::Position => USUAL_POSITION,
        ComparedQuantity::Rotation => USUAL_ROTATION,
        ComparedQuantity::LinkEncoder => USUAL_LINK_ENCODER,
        ComparedQuantity::MotorTorque => USUAL_TORQUE_SHARE * largest,
        ComparedQuantity::Force | ComparedQuantity::Moment | ComparedQuantity::Ripple { .. } => {
            USUAL_FORCE_SHARE * largest
        }
    }
}
