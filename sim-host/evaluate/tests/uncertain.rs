//! What is not known of a cell, number by number: how it is read, bound and drawn.

use trueweld_evaluate::certify::SampledCell;
use trueweld_evaluate::{Requirements, UncertainCell};
use trueweld_plant::effects::{EffectKind, Location};
use trueweld_plant::input::{InputFile, MeasuredNumber, Posterior, Process, RobotFile, Sensors};

fn fixture(name: &str) -> String {
    format!("{}/../../fixtures/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

fn requirements(uncertain: &str) -> Result<Requirements, String> {
    let text = std::fs::read_to_string(fixture("requirements/lap-weld")).expect("a fixture");
    Requirements::parse(&format!("{text}{uncertain}"), "r.toml").map_err(|e| e.to_string())
}

fn bound(requirements: &Requirements) -> Result<UncertainCell, String> {
    let robot = RobotFile::read(fixture("robots/kr500-mt")).expect("a fixture");
    let process = Process::read(fixture("processes/lap-weld-2024-t3")).expect("a fixture");
    let sensors = Sensors::read(fixture("sensors/kr500-mt")).expect("a fixture");
    requirements.uncertain_cell(&robot, &process, &sensors).map_err(|error| error.to_string())
}

/// One number with these lines.
fn one(lines: &str) -> Result<UncertainCell, String> {
    bound(&requirements(&format!("[[uncertain]]\n{lines}\nsource = \"test\"\n"))?)
}

const FRICTION: &str = "effect = \"joint-friction\"\nat = \"all\"\nparameter = \"coulomb_nm\"\n";

/// Values of the first two numbers in so many trials.
fn pairs(cell: &UncertainCell, trials: u64) -> Vec<[f64; 2]> {
    let values = |k| cell.values(&cell.draw(1, k));
    (0..trials).map(|k| [values(k)[0], values(k)[1]]).collect()
}

fn mean(of: impl Iterator<Item = f64> + Clone) -> f64 {
    of.clone().sum::<f64>() / of.count() as f64
}

fn correlation(pairs: &[[f64; 2]]) -> f64 {
    let [a, b] = [0, 1].map(|k| mean(pairs.iter().map(move |p| p[k])));
    let part = |f: fn(f64, f64) -> f64| mean(pairs.iter().map(move |p| f(p[0] - a, p[1] - b)));
    part(|x, y| x * y) / (part(|x, _| x * x) * part(|_, y| y * y)).sqrt()
}

#[test]
fn every_distribution_has_its_mean_and_keeps_its_ends() {
    // Means: (l + h)/2; (h − l)/ln(h/l); (l + m + h)/3; the mean; m exp(s²/2) for hardly any cut.
    for (lines, expected, deviation, ends) in [
        ("\"uniform\"\nlow = 10\nhigh = 30", 20.0, 5.8, [10.0, 30.0]),
        ("\"log-uniform\"\nlow = 10\nhigh = 40", 30.0 / 4_f64.ln(), 8.6, [10.0, 40.0]),
        ("\"triangular\"\nlow = 10\nmode = 20\nhigh = 60", 30.0, 10.8, [10.0, 60.0]),
        ("\"normal\"\nmean = 30\nsd = 5", 30.0, 5.0, [10.0, 50.0]),
        ("\"normal\"\nmean = 30\nsd = 20\nlow = 20\nhigh = 40", 30.0, 5.8, [20.0, 40.0]),
        ("\"lognormal\"\nmedian = 30\nspread = 0.1", 30.0 * 0.005_f64.exp(), 3.0, [20.1, 44.8]),
        ("\"fixed\"\nvalue = 7", 7.0, 0.0, [7.0, 7.0]),
    ] {
        let cell = one(&format!("{FRICTION}distribution = {lines}")).expect(lines);
        let trials = 4000;
        let values: Vec<f64> = pairs(&cell, trials).into_iter().map(|p| p[0]).collect();
        // Four standard errors.
        let tolerance = 4.0 * deviation / (trials as f64).sqrt() + 1e-12;
        let found = mean(values.iter().copied());
        assert!((found - expected).abs() <= tolerance, "{lines}: {found}, expected {expected}");
        let inside = |v: &f64| (ends[0] - 1e-9..=ends[1] + 1e-9).contains(v);
        assert!(values.iter().all(inside), "{lines}");
        let reach = [-40.0, 40.0].map(|z| cell.numbers[0].distribution.value(z));
        assert!((reach[0] - ends[0]).abs() < 0.1 && (reach[1] - ends[1]).abs() < 0.1, "{reach:?}");
    }
}

#[test]
fn numbers_of_a_group_are_correlated_as_stated_and_others_are_not() {
    let of = |group: &str| {
        let lines = format!("{FRICTION}distribution = \"normal\"\nmean = 0\nsd = 50\n{group}");
        correlation(&pairs(&one(&lines).expect("in order"), 4000))
    };
    // A standard error of a correlation is (1 − r²)/√n.
    let limit = |r: f64| 4.0 * (1.0 - r * r) / 4000_f64.sqrt();
    assert!(of("").abs() < limit(0.0));
    assert!((of("group = \"oil\"\ncorrelation = 0.6") - 0.6).abs() < limit(0.6));
    assert!((of("group = \"oil\"") - 1.0).abs() < 1e-12);
}

#[test]
fn a_number_more_leaves_the_others_as_they_were() {
    let short = bound(&requirements("").expect("in order")).expect("in order");
    let friction = one(&format!("{FRICTION}distribution = \"uniform\"\nlow = 0\nhigh = 50"))
        .expect("in order");
    let more = bound(
        &requirements(&format!(
            "[[uncertain]]\nseam = \"shift_y_m\"\ndistribution = \"uniform\"\nlow = 0\nhigh = 1e-3\n\
             source = \"x\"\n[[uncertain]]\n{FRICTION}distribution = \"uniform\"\nlow = 0\nhigh = 50\n\
             source = \"x\"\n"
        ))
        .expect("in order"),
    )
    .expect("in order");
    for k in 0..5 {
        let [bare, with, both] = [&short, &friction, &more].map(|u| SampledCell::new(u, 7, k));
        assert_eq!(with.latents.len(), 6);
        assert_eq!(both.latents[1..], with.latents);
        assert_eq!(SampledCell { latents: Vec::new(), ..with }, bare);
    }
    // As the short keys drew them before there were others.
    let first = SampledCell::new(&short, 1, 0);
    let text = serde_json::to_string(&first).expect("numbers");
    assert_eq!(text, include_str!("first_draw.json").trim());
}

#[test]
fn what_is_not_drawn_is_said() {
    let cell =
        one("effect = \"backlash\"\nat = \"A2\"\nparameter = \"half_gap_rad\"\ndistribution = \"uniform\"\nlow = 0\nhigh = 1e-4")
            .expect("in order");
    let left = cell.left_out();
    let is_left = |what: &str| left.iter().any(|name| name == what);
    assert!(is_left("backlash at A1, A3, A4, A5, A6") && is_left("seam shift_y_m"), "{left:?}");
    assert!(is_left("sensor seam.zero_m") && is_left("process memory_length_m"), "{left:?}");
    // The short keys draw these, under another name.
    for drawn in ["stiffness-error", "force-crosstalk", "drag-error", "process feed_drag_ns_m"] {
        assert!(!is_left(drawn), "{drawn} in {left:?}");
    }
    // Nothing of a weld depends on instruments that the controller does not read.
    assert!(!is_left("tracker-registration") && !is_left("link-encoder-offset"), "{left:?}");
}

#[test]
fn the_whole_cell_of_the_fixture_draws_every_kind() {
    let whole = Requirements::read(fixture("requirements/lap-weld-whole-cell")).expect("a fixture");
    let cell = bound(&whole).expect("numbers of the cell");
    let values = cell.values(&cell.draw(1, 0));
    assert!(values.len() > 100 && values.iter().all(|v| v.is_finite()));
    for kind in ["joint-friction", "backlash", "payload-error", "geometry-error", "seam", "sensor"]
    {
        assert!(cell.numbers.iter().any(|n| n.name.starts_with(kind)), "{kind}");
    }
}

#[test]
fn a_number_that_cannot_be_is_told_where_it_stands() {
    let uniform =
        |low: f64, high: f64| format!("distribution = \"uniform\"\nlow = {low:?}\nhigh = {high:?}");
    for (lines, expected) in [
        (
            format!("effect = \"joint-frictoin\"\n{}", uniform(0.0, 1.0)),
            "did you mean `joint-friction`",
        ),
        (
            format!("process = \"feed_drag\"\n{}", uniform(0.0, 1.0)),
            "did you mean `feed_drag_ns_m`",
        ),
        (format!("{FRICTION}{}", uniform(0.0, 1e9)), "reaches to 1000000000"),
        // As a file or `--effect` would be refused that states the drawn value.
        (format!("{FRICTION}relative = true\n{}", uniform(0.0, 1e3)), "this one reaches to"),
        (format!("{FRICTION}{}", uniform(2.0, 1.0)), "ends in their order"),
        (format!("{FRICTION}distribution = \"gaussian\""), "one of fixed, uniform"),
        (format!("seam = \"shift_y_m\"\nrelative = true\n{}", uniform(-0.1, 0.1)), "share of"),
        (format!("{FRICTION}correlation = 0.5\n{}", uniform(0.0, 1.0)), "a `group` beside it"),
        (format!("{}{}", FRICTION.replace("all", "A9"), uniform(0.0, 1.0)), "one of the joints A1"),
        (
            format!("process = \"lateral_ratio\"\n{}", uniform(0.1, 0.2)).replace("0.2", "200.0"),
            "reaches to 200",
        ),
    ] {
        let error = one(&lines).expect_err(&lines);
        assert!(error.starts_with("r.toml:") && error.contains(expected), "{error}");
    }
}

/// A stiffness, a friction and an encoder's zero that were measured, the first two together.
fn posterior() -> Posterior {
    let number = |id: &str, joint, value, between_logs| MeasuredNumber {
        kind: EffectKind::of(id).expect("of the library"),
        at: Location::Joint(joint),
        occurrence: 0,
        parameter: 0,
        value,
        between_logs,
    };
    Posterior {
        numbers: vec![
            number("stiffness-error", 1, 0.05, 0.0),
            number("joint-friction", 2, 30.0, 0.0),
            number("encoder-offset", 0, 1e-4, 4e-5),
        ],
        // Deviations 0.01 and 20, correlation −0.6; 3e-5.
        covariance: vec![1e-4, -0.12, 400.0, 0.0, 0.0, 9e-10],
        logs: vec!["static".to_owned()],
        campaign: "00".to_owned(),
        score: 1.0,
        at_bound: Vec::new(),
        undetermined: Vec::new(),
        not_measured: Vec::new(),
        seal: String::new(),
    }
}

fn measured(posterior: &Posterior) -> Result<UncertainCell, String> {
    let robot = RobotFile::read(fixture("robots/kr500-mt")).expect("a fixture");
    let process = Process::read(fixture("processes/lap-weld-2024-t3")).expect("a fixture");
    let sensors = Sensors::read(fixture("sensors/kr500-mt")).expect("a fixture");
    let assumed = "distribution = \"uniform\"\nlow = -90\nhigh = 90";
    one(&format!("{FRICTION}{assumed}"))?.measured(posterior, &robot, &process, &sensors)
}

#[test]
fn measured_numbers_are_drawn_together_and_in_place_of_what_is_assumed() {
    let cell = measured(&posterior()).expect("a covariance");
    let first = cell.numbers.iter().position(|n| n.is_measured()).expect("three of them");
    // Five of six frictions stay assumed.
    assert_eq!((first, cell.numbers.len()), (5, 8));
    let trials = 4000;
    let values: Vec<Vec<f64>> = (0..trials).map(|k| cell.values(&cell.draw(1, k))).collect();
    let of = |k: usize| values.iter().map(move |v| v[first + k]);
    let both: Vec<[f64; 2]> = values.iter().map(|v| [v[first], v[first + 1]]).collect();
    // Four standard errors: of a mean σ/√n, of a deviation σ/√(2n), of a correlation (1 − r²)/√n.
    let error = 4.0 / (trials as f64).sqrt();
    // What varies from log to log adds up: 3e-5 and 4e-5.
    for (k, (value, deviation)) in
        [(0.05, 0.01), (30.0, 20.0), (1e-4, 5e-5)].into_iter().enumerate()
    {
        let found = mean(of(k));
        assert!((found - value).abs() < error * deviation, "{k}: {found}");
        let spread = mean(of(k).map(|v| (v - found).powi(2))).sqrt();
        assert!((spread / deviation - 1.0).abs() < error / 2f64.sqrt() + 1e-3, "{k}: {spread}");
    }
    let found = correlation(&both);
    assert!((found + 0.6).abs() < error * 0.64, "{found}");

    // The short key draws the other stiffnesses as it did before.
    let plain = one(&format!("{FRICTION}distribution = \"fixed\"\nvalue = 1")).expect("in order");
    let [before, after] = [&plain, &cell].map(|cell| SampledCell::new(cell, 1, 3));
    for joint in 0..6 {
        let expected = if joint == 1 { 1.0 } else { before.stiffness[joint] };
        assert_eq!(after.stiffness[joint], expected, "{joint}");
    }
    assert_eq!((after.process, after.noise), (before.process, before.noise));
    let replaced: Vec<&str> = cell.replaced.iter().map(|r| r.number.as_str()).collect();
    assert_eq!(replaced, ["stiffness of A2", "joint-friction at A3: coulomb_nm"]);
    assert!(!cell.assumed_stiffness.contains(&"A2".to_owned()));
}

#[test]
fn a_measured_number_keeps_to_what_is_possible() {
    let mut posterior = posterior();
    // Half of it would lie below −0.5, softer than any drive may be.
    posterior.numbers[0].value = -0.5;
    let cell = measured(&posterior).expect("a covariance");
    let values = (0..200).map(|k| cell.values(&cell.draw(1, k))[5]);
    assert!(values.clone().all(|v| v >= -0.5) && values.clone().any(|v| v > -0.495));
}

#[test]
fn a_covariance_that_is_none_is_refused() {
    let mut posterior = posterior();
    posterior.covariance[1] = -0.3;
    assert!(measured(&posterior).unwrap_err().contains("variance below zero"));
}
