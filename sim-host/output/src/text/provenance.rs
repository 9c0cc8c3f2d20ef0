//! What a result is of.

use super::{Scale, digits, signed_share};
use trueweld_plant::provenance::{CoreRecord, Provenance};

/// Everything but the files, a name and a value each.
pub(crate) fn options(of: &Provenance) -> Vec<[String; 2]> {
    let mut rows = vec![
        ("program", format!("trueweld {} {}", of.version, of.command)),
        ("sources, SHA-256", of.sources.clone()),
        ("robot", of.robot.clone()),
        ("effects", effects(of)),
    ];
    if let Some(s) = &of.simulation {
        rows.extend([
            ("weld", s.welds.join(", ")),
            ("controller", s.controllers.join(", ")),
            ("law", s.laws.join(", ")),
            ("error of the believed stiffness", signed_share(s.stiffness_error)),
            ("spindle", format!("{:.0} rev/min", s.spindle_rad_s * 60.0 / std::f64::consts::TAU)),
            ("control period", Scale { factor: 1e3, unit: "ms" }.quantity(s.control_period_s)),
            ("plant step", Scale { factor: 1e3, unit: "ms" }.quantity(s.plant_step_s)),
            ("passes", s.passes.to_string()),
            ("seed of the noise", s.noise_seed.to_string()),
        ]);
        rows.extend(s.draws_seed.map(|seed| ("seed of the draws", seed.to_string())));
        let step = |height: f64| Scale { factor: 1e-3, unit: "kN" }.quantity(height);
        rows.extend(s.force_step_n.map(|height| ("step of the push", step(height))));
        let core = |core: &CoreRecord| ("core", format!("{}: {}", core.weld, core.sha256));
        rows.extend(s.cores.iter().map(core));
    }
    rows.into_iter().map(|(name, value)| [name.to_owned(), value]).collect()
}

fn effects(of: &Provenance) -> String {
    let effects = of.effects.iter().map(|effect| {
        let values =
            effect.values.iter().map(|(name, value)| format!("{name} {}", digits(*value, 3)));
        let at = if effect.at.is_empty() { String::new() } else { format!(" at {}", effect.at) };
        format!("{}{at} ({})", effect.id, values.collect::<Vec<_>>().join(", "))
    });
    let all: Vec<String> = effects.collect();
    if all.is_empty() { "none".to_owned() } else { all.join("; ") }
}
