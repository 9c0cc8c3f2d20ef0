//! `plate-waviness`: a plate that is not flat.
//!
//! Surface height along the path A sin(2π x/λ + φ), positive towards the tool.

use super::curve::{Curve, CurveAxis, SURFACE_HEIGHT};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::{Parameter, Role};
use crate::robot::{Port, ProcessPoint, Term};
use std::f64::consts::TAU;

pub(super) static PLATE_WAVINESS_EFFECT: EffectKind = EffectKind {
    id: "plate-waviness",
    place: LocationKind::Cell,
    equation: "surface height along the path A sin(2π x/λ + φ), positive towards the tool",
    shows: "depth, or push, waves along the path",
    experiment: "the plate scanned, or a weld twice along the same line",
    parameters: &[
        Parameter::size("amplitude_m", "m", "amplitude A", 2e-5, [0.0, 0.002]),
        Parameter::new("length_m", "m", "wavelength λ", Role::Wavelength, [0.002, 2.0]),
        Parameter::new("phase_rad", "rad", "phase φ", Role::Phase, [-3.15, 3.15]),
    ],
    sentence: "the plate is wavy, with an amplitude of {|0|} every {1}",
    curve: Curve::Quantity(&[SURFACE_HEIGHT], &[CurveAxis::Path]),
    drawn: Some(|d| {
        let length = d.seam * d.between(0.2, 0.6);
        (Location::Cell, vec![d.size * d.between(1e-4, 3e-4), length, d.phase()])
    }),
    action: Action::Term {
        port: |_| Port::PlateSurface,
        build: |v, _| Box::new(PlateWaviness { amplitude: v[0], length: v[1], phase: v[2] }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct PlateWaviness {
    amplitude: f64,
    length: f64,
    phase: f64,
}

impl Term for PlateWaviness {
    fn surface(&self, at: &ProcessPoint) -> f64 {
        self.amplitude * (TAU * at.position.x / self.length + self.phase).sin()
    }
}
