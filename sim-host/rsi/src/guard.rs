//! What the controller makes of a correction before the robot sees it.
//!
//! Each component is clamped, and nothing tells the client so (POSCORR); then the whole is monitored,
//! and RSI stops where it is too large (POSCORRMON). The defaults of both are public: 5 mm and 5°,
//! 6 mm and 6°.

use crate::frame::Frame;
use std::fmt;

/// Bounds of a correction, and how missing answers are taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CorrectionBounds {
    /// Largest component of the translation, mm: more is cut off.
    pub clamp_mm: f64,
    /// Largest component of the rotation and of an axis, degrees: more is cut off.
    pub clamp_deg: f64,
    /// Largest translation, mm: RSI stops above.
    pub monitor_mm: f64,
    /// Largest rotation, degrees: RSI stops above.
    pub monitor_deg: f64,
    /// True where a correction is an increment (`#RELATIVE`), false where it is an offset
    /// (`#ABSOLUTE`).
    pub relative: bool,
    /// True where the last correction holds while no answer comes (`HOLDON="1"`); false where the
    /// offset is taken away at once.
    pub hold: bool,
    /// Cycles in a row without an answer after which RSI stops.
    pub timeout: u32,
}

impl Default for CorrectionBounds {
    fn default() -> Self {
        Self {
            clamp_mm: 5.0,
            clamp_deg: 5.0,
            monitor_mm: 6.0,
            monitor_deg: 6.0,
            relative: false,
            hold: true,
            timeout: 10,
        }
    }
}

/// Why RSI stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// Too many cycles without an answer.
    Timeout,
    /// The correction was larger than is monitored (KSS29000).
    Correction,
    /// The client asked for it.
    Asked,
    /// The socket failed.
    Socket,
}

impl fmt::Display for StopReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Timeout => "no answer for too many cycles",
            Self::Correction => "the correction was larger than is monitored (KSS29000)",
            Self::Asked => "the client asked to stop",
            Self::Socket => "the socket failed",
        })
    }
}

/// The correction in force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guard {
    bounds: CorrectionBounds,
    /// Of the pose.
    pub pose: Frame,
    /// Of the axes, degrees.
    pub axes: [f64; 6],
}

impl Guard {
    /// Nothing corrected.
    pub fn new(bounds: CorrectionBounds) -> Self {
        Self { bounds, pose: [0.0; 6], axes: [0.0; 6] }
    }

    /// Takes a client's correction. True where something of it was cut off.
    ///
    /// # Errors
    /// [`StopReason::Correction`]; the correction in force stays as it was.
    pub fn take(&mut self, pose: &Frame, axes: &[f64; 6]) -> Result<bool, StopReason> {
        let CorrectionBounds { clamp_mm, clamp_deg, monitor_mm, monitor_deg, .. } = self.bounds;
        let most = [clamp_mm, clamp_mm, clamp_mm, clamp_deg, clamp_deg, clamp_deg];
        let (pose, pose_cut) = self.clamped(&self.pose, pose, &most);
        let (axes, axes_cut) = self.clamped(&self.axes, axes, &[clamp_deg; 6]);
        let [x, y, z, a, b, c] = pose;
        let size = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
        if size([x, y, z]) > monitor_mm
            || size([a, b, c]) > monitor_deg
            || axes.iter().any(|axis| axis.abs() > monitor_deg)
        {
            return Err(StopReason::Correction);
        }
        (self.pose, self.axes) = (pose, axes);
        Ok(pose_cut || axes_cut)
    }

    /// The correction that follows one before, within what is allowed, and whether it was cut.
    fn clamped(&self, before: &[f64; 6], given: &[f64; 6], most: &[f64; 6]) -> ([f64; 6], bool) {
        let (mut total, mut cut) = (*given, false);
        for ((total, before), most) in total.iter_mut().zip(before).zip(most) {
            if self.bounds.relative {
                *total += before;
            }
            cut |= total.abs() > *most;
            *total = total.clamp(-most, *most);
        }
        (total, cut)
    }

    /// A cycle without an answer.
    pub fn miss(&mut self) {
        if !self.bounds.hold && !self.bounds.relative {
            (self.pose, self.axes) = ([0.0; 6], [0.0; 6]);
        }
    }
}
