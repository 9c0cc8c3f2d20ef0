//! Prints amplitudes at the spindle's order with drives that are held, with and without the notch:
//! what `docs/results.md` states of them. In a minute or two.

use trueweld_plant::simulate::ControllerKind;
use trueweld_tests::resonance::{Lines, fixtures, started_at, unscaled, usable, weld};

pub(crate) fn run() {
    let speeds = [500.0, 600.0, 700.0, 750.0, 800.0, 900.0, 1000.0, 1080.0, 1200.0];
    for (controller, faster) in [
        (ControllerKind::EXTERNAL, 1.0),
        (ControllerKind::EXTERNAL, 4.0),
        (ControllerKind::PARALLEL, 1.0),
    ] {
        println!("{} × {faster}: without filter, with", controller.name());
        println!(
            "| rpm | push, N | drives, µm | correction, µm | lateral, µm | tilt, 0.001° | envelope, N |"
        );
        for rpm in speeds {
            let [a, b] = [false, true].map(|told| weld(rpm, controller, faster, told));
            let pair = |f: fn(&Lines) -> f64, unit: f64, digits: usize| {
                format!("{:.digits$} {:.digits$}", f(&a) * unit, f(&b) * unit)
            };
            println!(
                "| {rpm} | {} | {} | {} | {} | {} | {} |",
                pair(|l| l.push, 1.0, 1),
                pair(|l| l.drives, 1e6, 2),
                pair(|l| l.correction, 1e6, 3),
                pair(|l| l.lateral, 1e6, 2),
                pair(|l| l.tilt.to_degrees(), 1e3, 2),
                pair(|l| l.envelope, 1.0, 0),
            );
        }
    }
    println!("usable gain without filter, start: {:.2}", usable(false, |g| fixtures(600.0, g)));
    for rpm in speeds {
        println!(
            "usable gain with filter at {rpm} rpm, start: {:.2}",
            usable(true, |g| fixtures(rpm, g))
        );
    }
    let middle = |g| started_at(1.0, fixtures(600.0, g));
    println!("middle, neither: {:.2}", usable(false, |g| unscaled(middle(g))));
    println!("middle, scaled: {:.2}", usable(false, middle));
    println!("middle, filter: {:.2}", usable(true, |g| unscaled(middle(g))));
    println!("middle, both: {:.2}", usable(true, middle));
}
