//! Figures that studies ask of a weld: those of its steady part that process engineers and control
//! engineers read, and the margins of the loop in its middle.

use crate::certify::FigureValues;
use crate::figure::{Figure, FigureOf};
use crate::margins::{MARGIN_FIGURES, Margins};
use crate::weld::WeldFigures;

/// Figures of a weld that studies ask for.
pub(crate) static STUDY_FIGURES: [FigureOf<WeldFigures>; 7] = [
    FigureOf::new("lateral_rms_m", "lateral, RMS", "m", |f| f.lateral.rms),
    FigureOf::new("lateral_max_m", "lateral, largest", "m", |f| f.lateral.max_abs),
    FigureOf::new("longitudinal_max_m", "along the seam, largest", "m", |f| f.longitudinal.max_abs),
    FigureOf::new("tilt_rms_rad", "tilt, RMS", "rad", |f| f.tilt.rms),
    FigureOf::new("depth_rms_m", "depth about its mean, RMS", "m", |f| {
        (f.depth.rms.powi(2) - f.depth.mean.powi(2)).max(0.0).sqrt()
    }),
    FigureOf::new("push_envelope_n", "push, largest less smallest", "N", |f| f.force.envelope),
    FigureOf::new("push_error_rms_n", "push, RMS of its error", "N", |f| f.force.error_rms),
];

/// Margins among [`MARGIN_FIGURES`] that studies ask for: of corrections and force loop.
pub const MARGINS_ASKED: usize = 5;

/// The figures of a study, with margins or without.
pub(crate) fn asked(margins: bool) -> impl Iterator<Item = &'static Figure> {
    let of_loop = MARGIN_FIGURES.iter().take(if margins { MARGINS_ASKED } else { 0 });
    STUDY_FIGURES.iter().map(|of| &of.figure).chain(of_loop.map(|of| &of.figure))
}

/// The figure of a key that studies ask for.
pub fn study_figure(key: &str) -> Option<&'static Figure> {
    asked(true).find(|figure| figure.key == key)
}

/// The least of every margin that is asked for, by its key.
pub(super) fn margins_asked(all: &[Margins]) -> FigureValues {
    let least = |of: &FigureOf<Margins, crate::margins::LeastMargin>| {
        all.iter().map(|margins| (of.value)(margins).0).fold(f64::INFINITY, f64::min)
    };
    let figures = MARGIN_FIGURES.iter().take(MARGINS_ASKED);
    let values = figures.map(|of| (of.figure.key.to_owned(), least(of)));
    values.filter(|(_, value)| value.is_finite()).collect()
}
