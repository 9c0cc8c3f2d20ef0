//! `plate-waviness`: a plate that is not flat.
//!
//! Surface height along the path A sin(2π x/λ + φ), positive towards the tool.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, ProcessPoint, Term};
use std::f64::consts::TAU;

pub(super) static KIND: EffectKind = EffectKind {
    id: "plate-waviness",
    place: LocationKind::Cell,
    equation: "surface height along the path A sin(2π x/λ + φ), positive towards the tool",
    shows: "depth, or push, waves along the path",
    experiment: "the plate scanned, or a weld twice along the same line",
    parameters: &[
        Parameter {
            name: "amplitude_m",
            role: Role::Size { step: 2e-5, neutral: 0.0 },
            unit: "m",
            meaning: "amplitude A",
            low: 0.0,
            high: 0.002,
        },
        Parameter {
            name: "length_m",
            role: Role::Wavelength,
            unit: "m",
            meaning: "wavelength λ",
            low: 0.01,
            high: 2.0,
        },
        Parameter {
            name: "phase_rad",
            role: Role::Phase,
            unit: "rad",
            meaning: "phase φ",
            low: -3.15,
            high: 3.15,
        },
    ],
    action: Action::Term {
        port: |_| Port::PlateSurface,
        build: |v, _| Box::new(PlateWaviness { amplitude: v[0], length: v[1], phase: v[2] }),
    },
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
