//! Placements of a part in space: a point for each, coloured by what it takes of what is allowed, and
//! the seams where the file has them and where they are best put.

use super::signals;
use super::writer::{RecordError, Store, Writer};
use crate::StudyLayoutReport;
use crate::color::{Rgb, run};
use crate::document::within_limit;
use re_sdk_types::archetypes::{LineStrips3D, Points3D, TextDocument, ViewCoordinates};
use re_sdk_types::components::MediaType;
use std::io::Write;
use trueweld_evaluate::study::{PlacedPart, Placement, numbers};
use trueweld_plant::simulate::Seam;

/// Entities of the map and of the seams.
pub(super) const MAP: &str = "/placements/share";
pub(super) const SEAMS: &str = "/seams";

/// Radius of a point and of a seam, m.
const POINT_RADIUS: f32 = 0.02;
const SEAM_RADIUS: f32 = 0.012;

/// Points of a drawn seam.
const SEAM_POINTS: usize = 40;

/// Writes the placements, the seams and the words.
pub(super) fn all<W: Write>(
    writer: &mut Writer<W>,
    about: String,
    report: &StudyLayoutReport<'_>,
) -> Result<(), RecordError> {
    let text = TextDocument::new(about).with_media_type(MediaType::MARKDOWN);
    writer.fixed(Store::Recording, "/about", &text)?;
    writer.fixed(Store::Recording, "/", &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    // Where several turns or inclinations are at one point, the best of them.
    let mut best: Vec<&PlacedPart> = Vec::new();
    for placed in report.grid.iter().filter_map(|placed| placed.outcome.as_ref().ok()) {
        let here = |other: &&mut &PlacedPart| {
            let [a, b] = [&other.placement, &placed.placement].map(numbers);
            a[..3] == b[..3]
        };
        match best.iter_mut().find(here) {
            Some(other) if placed.cost() < other.cost() => *other = placed,
            Some(_) => {}
            None => best.push(placed),
        }
    }
    let points = best.iter().map(|placed| place(&placed.placement));
    let colors: Vec<_> =
        best.iter().map(|placed| signals::rgb(within_limit(placed.limiting().share))).collect();
    let labels = best.iter().map(|placed| format!("{:.0} %", 100.0 * placed.limiting().share));
    let map = Points3D::new(points)
        .with_colors(colors)
        .with_radii([POINT_RADIUS])
        .with_labels(labels)
        .with_show_labels(false);
    writer.fixed(Store::Recording, MAP, &map)?;
    let filed = report.filed.as_ref().ok().map(|filed| ("as_filed", filed, run(0)));
    for (name, of, color) in filed.into_iter().chain([("chosen", report.chosen, run(1))]) {
        let strips = report.task.part.welds_at(&of.placed.placement);
        let strips = strips.iter().map(|weld| {
            let seam = Seam::of(weld);
            let at = |k: usize| {
                let path = seam.length * k as f64 / SEAM_POINTS as f64;
                seam.frame(path).position.map(|v| v as f32).data.0[0]
            };
            (0..=SEAM_POINTS).map(at).collect::<Vec<_>>()
        });
        let strips: Vec<_> = strips.collect();
        write_strips(writer, &format!("{SEAMS}/{name}"), strips, color)?;
    }
    Ok(())
}

fn write_strips<W: Write>(
    writer: &mut Writer<W>,
    entity: &str,
    strips: Vec<Vec<[f32; 3]>>,
    color: Rgb,
) -> Result<(), RecordError> {
    let lines =
        LineStrips3D::new(strips).with_radii([SEAM_RADIUS]).with_colors([signals::rgb(color)]);
    writer.fixed(Store::Recording, entity, &lines)
}

fn place(at: &Placement) -> [f32; 3] {
    [at.x_m as f32, at.y_m as f32, at.z_m as f32]
}
