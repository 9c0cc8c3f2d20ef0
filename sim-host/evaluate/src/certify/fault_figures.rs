//! How instruments are made to fail in a certification, and the figures by which it is judged.

use crate::figure::FigureOf;
use crate::weld::Spread;
use trueweld_plant::sensors::{Failure, Instrument, InstrumentFault};
use trueweld_plant::simulate::{Phase, RecordRow, Recording};

/// Least steady time before a fault, and least time after the recovery over which it is judged, s.
pub(super) const JUDGED: f64 = 1.0;

/// Sizes of what instruments are made to read. Two numbers each: of each force, N, and of each
/// moment, N·m; of a seam sensor across the seam, m, and in tilt, rad.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FaultSizes {
    /// Ends of the force sensor's range.
    pub force_range: [f64; 2],
    /// Offset of a force sensor that lies, and what a drift comes to.
    pub force_offset: [f64; 2],
    /// Share by which a force sensor reads too much.
    pub force_gain: f64,
    /// Ends of the seam sensor's range.
    pub seam_range: [f64; 2],
    /// Offset of a seam sensor that lies.
    pub seam_offset: [f64; 2],
}

impl FaultSizes {
    /// Every instrument in every way that it fails. `noise`: standard deviations of the force
    /// sensor's noise, N and N·m.
    pub fn failures(&self, noise: [f64; 2]) -> Vec<(Instrument, Failure)> {
        let [linear, angular] = self.force_offset;
        let of_force = [
            Failure::Drift { linear, angular },
            Failure::Gain { relative: self.force_gain },
            Failure::Noise { linear: noise[0], angular: noise[1] },
        ];
        let force =
            common_failures(self.force_range, self.force_offset).into_iter().chain(of_force);
        let force = force.map(|failure| (Instrument::ForceSensor, failure));
        let seam = common_failures(self.seam_range, self.seam_offset).into_iter();
        force.chain(seam.map(|failure| (Instrument::SeamSensor, failure))).collect()
    }
}

/// The ways in which every instrument fails. `range`: its end; `offset`: what it reads too much.
fn common_failures(range: [f64; 2], offset: [f64; 2]) -> [Failure; 6] {
    [
        Failure::Nan,
        Failure::Stuck,
        Failure::Saturated { linear: range[0], angular: range[1] },
        Failure::Dropped,
        Failure::OutOfOrder,
        Failure::Offset { linear: offset[0], angular: offset[1] },
    ]
}

/// Figures of a fault case: the largest correction of the whole run; while the fault lasts and until
/// the tool must be over it, how far it leaves its line, how far depth goes from its mean before, and
/// where nobody detects the fault the largest share of any limit of the weld; after that the steady
/// figures again.
pub static FAULT_FIGURES: [FigureOf<FaultSpreads>; 8] = [
    FigureOf::new("correction_m", "correction, translation", "m", |f| f.correction[0]),
    FigureOf::new("correction_rad", "correction, rotation", "rad", |f| f.correction[1]),
    FigureOf::new(LATERAL, "lateral in the fault, largest", "m", |f| f.lateral_during.max_abs),
    FigureOf::new(DEPTH, "depth in the fault, largest change", "m", |f| f.depth_during.max_abs),
    FigureOf::new(UNDETECTED, "undetected, largest share of a limit", "1", |f| f.undetected),
    FigureOf::new("recovered_lateral_rms_m", "lateral after recovery, RMS", "m", |f| {
        f.lateral_after.rms
    }),
    FigureOf::new("recovered_lateral_max_m", "lateral after recovery, largest", "m", |f| {
        f.lateral_after.max_abs
    }),
    FigureOf::new(
        "recovered_push_error_rms_n",
        "push after recovery, RMS of its error",
        "N",
        |f| f.push_error_after.rms,
    ),
];

/// Keys of the figures that have limits of their own.
pub(super) const LATERAL: &str = "fault_lateral_max_m";
pub(super) const DEPTH: &str = "fault_depth_max_m";
pub(super) const UNDETECTED: &str = "undetected_of_limit";

/// What a run with a fault came to, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultSpreads {
    correction: [f64; 2],
    lateral_during: Spread,
    depth_during: Spread,
    /// Where nobody detects the fault, the largest share of any limit of the weld.
    pub(super) undetected: f64,
    lateral_after: Spread,
    push_error_after: Spread,
}

impl FaultSpreads {
    /// Of a whole run. `over`: when the tool must be over the fault, s.
    pub(super) fn of(recording: &Recording, fault: &InstrumentFault, over: f64) -> Self {
        let rows = || recording.rows.iter();
        let steady = || rows().filter(|r| r.phase == Phase::Steady);
        let before = steady().filter(|r| (fault.from - JUDGED..fault.from).contains(&r.time));
        let before = Spread::of(before.map(|r| r.deviation_w.linear.z)).mean;
        let during = || rows().filter(|r| (fault.from..over).contains(&r.time));
        let after =
            |of: fn(&RecordRow) -> f64| Spread::of(steady().filter(|r| r.time >= over).map(of));
        Self {
            correction: [
                Spread::of(rows().map(|r| r.correction_w.linear.norm())).max_abs,
                Spread::of(rows().map(|r| r.correction_w.angular.norm())).max_abs,
            ],
            lateral_during: Spread::of(during().map(|r| r.deviation_w.linear.y)),
            depth_during: Spread::of(during().map(|r| r.deviation_w.linear.z - before)),
            undetected: 0.0,
            lateral_after: after(|r| r.deviation_w.linear.y),
            push_error_after: after(|r| -r.force_w.z - r.force_desired.unwrap_or(0.0)),
        }
    }
}
