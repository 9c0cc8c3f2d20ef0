//! Certification of laws that are good and of laws that are bad on purpose: each fails for the
//! reason that it was made with.
//!
//! The weld is the first 220 mm of the first published one.

use std::sync::LazyLock;
use trueweld_compensators::{
    Elastostatic, ElastostaticGains, Entry, FeedForward, GainError, Law, NoGains, Setup,
    TrackingGains,
};
use trueweld_core::compensation::{Compensator, LoopLimits, Observation};
use trueweld_core::{Fault, Robot, Twist};
use trueweld_evaluate::certify::{
    Certification, Evidence, EvidenceKind, FigureValues, Held, NominalCell, Reason,
    RequiredCorrection, Requirement, SampledCell, Shortfall, Symptom, Trial, Verdict, WorstCase,
    accepted_faults, drawn_figure, draws, judge, rare_failure, search,
};
use trueweld_evaluate::{
    ASKED_FIGURES, Faults, IdleLimit, Rate, Requirements, Spread, UncertainCell, WELD_FIGURES,
    WeldFigures,
};
use trueweld_plant::cell::Cell;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{Control, InputFile};
use trueweld_plant::sensors::{Failure, Instrument, InstrumentFault};
use trueweld_plant::simulate::{
    ControllerKind, Recording, RunError, Scenario, WeldProgram, run, run_passes,
};
use trueweld_tests::cell::{Fixtures, law};

/// So many draws, few as they are, show a share of a half at 75 %: 0.5³ = 0.125.
const DRAWS: u64 = 3;

const SEARCH: usize = 4;

static REQUIREMENTS: LazyLock<Requirements> = LazyLock::new(|| requirements(""));

fn requirements(more: &str) -> Requirements {
    let text = r#"
        schema = "requirements/1"
        failure_probability = 0.5
        confidence = 0.75
        [limits]
        lateral_rms_m = 3.0e-4
        lateral_max_m = 6.0e-4
        push_error_rms_n = 400.0
        correction_m = 0.010
        correction_rad = 0.015
        [uncertainty]
        stiffness = 0.1
        process = 0.1
        ripple = 0.5
        crosstalk = 0.01
        delay_periods = [1.0, 2.0]
        [margins]
        places = 2
        gain_margin = 1.5
        modulus_margin = 0.3
        [faults]
        places = 1
        duration_s = 1.0
        recovery_s = 9.0
        lateral_max_m = 2.5e-3
        depth_max_m = 2.3e-3
        force_range_n = 30000.0
        force_range_nm = 5000.0
        force_offset_n = 300.0
        force_offset_nm = 50.0
        force_gain = 0.15
        seam_range_m = 0.010
        seam_range_rad = 0.17
        seam_offset_m = 0.0003
        seam_offset_rad = 0.002
        [[faults.not_required]]
        fault = "force-gain"
        figures = ["undetected_of_limit"]
        reason = "the force loop holds what its sensor reads"
    "#;
    Requirements::parse(&format!("{text}{more}"), "requirements").expect("in order")
}

/// What is not known of the cell.
static UNCERTAIN: LazyLock<UncertainCell> = LazyLock::new(|| uncertain(&REQUIREMENTS));

fn uncertain(requirements: &Requirements) -> UncertainCell {
    let Fixtures { robot, process, sensors, .. } = &*FIXTURES;
    requirements.uncertain_cell(robot, process, sensors).expect("numbers of the cell")
}

static FIXTURES: LazyLock<Fixtures> = LazyLock::new(|| {
    // The weld as published, its beginning, within an authority of 10 mm.
    let mut fixtures = Fixtures::of("published-vertical");
    let weld = &mut fixtures.weld;
    weld.end = weld.start + (weld.end - weld.start).normalize() * 0.22;
    fixtures.control.compensation.lateral.size = 0.010;
    fixtures
});

static CELL: LazyLock<Cell> = LazyLock::new(|| FIXTURES.cell(&[]));

/// Everything of one law.
struct Certified {
    /// What is asked of the weld.
    asked: Requirements,
    evidence: Evidence,
    requirements: Vec<Requirement>,
}

/// Requirements as they are asked of a weld of the fixtures.
fn asked(requirements: &Requirements, of: &Fixtures) -> Result<Requirements, IdleLimit> {
    requirements.of_weld(&of.weld, &of.process, &of.control.compensation)
}

impl Certified {
    /// Of a law under the faults of these instruments.
    fn of(law: &Entry, control: &Control, instruments: &[Instrument]) -> Self {
        let fixtures = &*FIXTURES;
        let mut scenario =
            fixtures.scenario(&CELL, WeldProgram::Weld, ControllerKind::EXTERNAL, law);
        scenario.control = control;
        let asked = REQUIREMENTS.of_weld(&fixtures.weld, &fixtures.process, &control.compensation);
        let asked = asked.expect("limits that can be exceeded");
        let requirements = &asked;
        let cell =
            NominalCell { robot: &fixtures.robot.robot, effects: &[], uncertain: &UNCERTAIN };
        let needed =
            RequiredCorrection::of(&scenario, &cell).expect("a weld").expect("a steady part");
        let certification =
            Certification { scenario, cell, requirements, needed: &needed, passes: 1, seed: 7 };
        let trials: Vec<Trial> = (0..DRAWS).map(|k| certification.trial(k)).collect();
        let nominal = certification.nominal();
        let worst = search(requirements, &UNCERTAIN, 7, &nominal, &trials, SEARCH, |batch| {
            Ok::<_, RunError>(
                batch.iter().map(|(k, draw)| certification.weld(*k, draw.clone())).collect(),
            )
        });
        let faults = certification.faults().expect("long enough");
        let faults = faults.iter().filter(|f| instruments.contains(&f.fault.instrument));
        let faults = faults.map(|f| certification.run_fault(f)).collect();
        let worst = WorstCase::among(requirements, &nominal, &trials, worst.expect("no errors"));
        let evidence = Evidence {
            rare: None,
            nominal,
            trials,
            worst,
            margins: certification.margins().expect("within reach"),
            faults,
        };
        let requirements = judge(requirements, &evidence);
        Self { asked, evidence, requirements }
    }

    /// The reasons of a section.
    fn reasons(&self, case: EvidenceKind) -> Vec<&Reason> {
        let failed =
            self.requirements.iter().filter(|r| r.case == case && r.verdict != Verdict::Pass);
        failed.map(|r| r.reason.as_ref().expect("a reason with every failure")).collect()
    }
}

/// What stands out in the loop of a run.
fn symptom(reason: &Reason) -> Option<Symptom> {
    if let Reason::Run(run) = reason { run.symptom } else { None }
}

/// Feed-forward the other way.
struct SignFlipped;

impl Law<f64> for SignFlipped {
    const NAME: &'static str = "sign-flipped";
    const SUMMARY: &'static str = "Feed-forward the other way";
    type Gains = NoGains;
    type Built = Scaled<FeedForward>;

    fn build(_: &NoGains, _: &Setup<f64>) -> Result<Self::Built, GainError> {
        Ok(Scaled(FeedForward, -1.0))
    }
}

/// Elastostatic, 1.6 times: what it gives, the material answers with more force than that took.
struct GainAboveOne;

impl Law<f64> for GainAboveOne {
    const NAME: &'static str = "gain-above-one";
    const SUMMARY: &'static str = "Elastostatic, 1.6 times";
    type Gains = ElastostaticGains;
    type Built = Scaled<Elastostatic<f64>>;

    fn build(gains: &ElastostaticGains, setup: &Setup<f64>) -> Result<Self::Built, GainError> {
        Ok(Scaled(Elastostatic::new(gains, setup.period)?, 1.6))
    }
}

struct Scaled<L>(L, f64);

impl<L: Compensator<f64>> Compensator<f64> for Scaled<L> {
    fn reset(&mut self) {
        self.0.reset();
    }

    fn demand(
        &mut self,
        robot: &Robot<f64>,
        observation: &Observation<'_, f64>,
    ) -> Result<Twist<f64>, Fault> {
        let demand = self.0.demand(robot, observation)?;
        Ok(Twist { angular: demand.angular * self.1, linear: demand.linear * self.1 })
    }
}

/// An integrator of what the seam sensor says, whatever it says.
struct Trusting {
    share: f64,
    learned: Twist<f64>,
}

impl Law<f64> for Trusting {
    const NAME: &'static str = "trusting";
    const SUMMARY: &'static str = "An integrator of what the seam sensor says";
    type Gains = TrackingGains;
    type Built = Self;

    fn build(gains: &TrackingGains, setup: &Setup<f64>) -> Result<Self, GainError> {
        Ok(Self { share: gains.rate_rad_s * setup.period, learned: Twist::zero() })
    }
}

/// The control file with an integrator of so many rad/s.
fn trusting(rate: f64) -> Control {
    let mut control = FIXTURES.control.clone();
    control.laws.insert(
        Trusting::NAME.into(),
        toml::Table::from_iter([("rate_rad_s".to_owned(), rate.into())]),
    );
    control
}

impl Compensator<f64> for Trusting {
    fn reset(&mut self) {
        self.learned = Twist::zero();
    }

    fn demand(
        &mut self,
        robot: &Robot<f64>,
        observation: &Observation<'_, f64>,
    ) -> Result<Twist<f64>, Fault> {
        for measurement in observation.measurements.iter().filter(|s| s.is_usable()) {
            self.learned.linear -= measurement.along.linear * (measurement.deviation * self.share);
        }
        Ok(FeedForward.demand(robot, observation)? + self.learned)
    }
}

#[test]
fn a_good_law_meets_what_bad_ones_are_asked_for() {
    let certified = Certified::of(
        &law("seam-tracking"),
        &FIXTURES.control,
        &[Instrument::ForceSensor, Instrument::SeamSensor],
    );
    for r in &certified.requirements {
        assert!(r.verdict == Verdict::Pass && r.reason.is_none(), "{r:?}");
    }
    for case in
        [EvidenceKind::Nominal, EvidenceKind::Draws, EvidenceKind::Margins, EvidenceKind::Faults]
    {
        assert!(certified.requirements.iter().any(|r| r.case == case), "{case:?}");
    }
    assert_eq!(certified.evidence.faults.len(), 15);
    // A scale that is off nobody can see: that is told, and fails unless the requirements say that it
    // is not required.
    let faults = REQUIREMENTS.faults.clone().expect("asked for");
    let strict = Requirements {
        faults: Some(Faults { not_required: Vec::new(), ..faults }),
        ..REQUIREMENTS.clone()
    };
    let judged = judge(&strict, &certified.evidence);
    let failed: Vec<&str> =
        judged.iter().filter(|r| r.verdict == Verdict::Fail).map(|r| r.name).collect();
    assert_eq!(failed, ["undetected_of_limit"]);
    let accepted = accepted_faults(&REQUIREMENTS, &certified.evidence.faults);
    assert_eq!(accepted.len(), 1);
    for of in &accepted {
        assert!(of.fault == "force-gain" && of.judged.achieved > of.judged.limit, "{of:?}");
    }
    // A reading that repeats is reported within the periods that it takes to count to four, and so is
    // noise about zero, which the drives contradict.
    let reported = |name: &str| {
        let trial = certified.evidence.faults.iter().find(|t| t.name == name).expect("tried");
        trial.detected
    };
    for name in ["force-stuck", "force-saturated", "force-dropped", "force-noise"] {
        assert!(reported(name).is_some_and(|after| after < 4.0 * 0.012 + 1e-9), "{name}");
    }
    assert!(reported("force-nan").is_some_and(|after| after < 0.012 + 1e-9));
    for name in ["force-offset", "force-drift", "force-gain", "seam-offset"] {
        assert_eq!(reported(name), None, "{name}");
    }
    // Nothing that the search gives is better than what the draws had shown, but for what drives give
    // in any cell.
    let limits = certified.asked.limits.iter().filter(|l| !l.figure.key.contains("share_max"));
    let of_limit =
        |t: &Trial| limits.clone().map(|l| t.figure(l.figure.key) / l.value).fold(0.0, f64::max);
    let drawn = certified.evidence.trials.iter().map(of_limit).fold(0.0, f64::max);
    let worst = &certified.evidence.worst;
    assert!(
        worst.of_limit >= drawn && worst.runs.len() == SEARCH,
        "{} against {drawn}",
        worst.of_limit
    );
}

#[test]
fn a_law_with_its_sign_flipped_is_told_that_it_goes_the_wrong_way() {
    let certified = Certified::of(&Entry::of::<SignFlipped>(), &FIXTURES.control, &[]);
    let nominal = certified.reasons(EvidenceKind::Nominal);
    assert!(
        nominal.iter().any(|r| matches!(symptom(r), Some(Symptom::WrongWay(_)))),
        "{nominal:?}"
    );
    let draws = certified.reasons(EvidenceKind::Draws);
    let told = |r: &&Reason| {
        matches!(r, Reason::Draws { of: 3, worst, .. }
            if matches!(worst.symptom, Some(Symptom::WrongWay(_))))
    };
    assert!(draws.iter().any(told), "{draws:?}");
}

#[test]
fn a_law_with_too_much_gain_is_told_that_it_swings() {
    // Sensor, correction and position loop are late together by more than an integrator of 100
    // rad/s bears.
    let certified = Certified::of(&Entry::of::<Trusting>(), &trusting(100.0), &[]);
    let nominal = certified.reasons(EvidenceKind::Nominal);
    assert!(
        nominal.iter().any(|r| matches!(symptom(r), Some(Symptom::Oscillates { .. }))),
        "{nominal:?}"
    );
    let margins = certified.reasons(EvidenceKind::Margins);
    assert!(margins.iter().any(|r| matches!(r, Reason::Unstable { .. })), "{margins:?}");
}

#[test]
fn a_law_that_feeds_itself_is_told_that_only_its_authority_holds_it() {
    let certified = Certified::of(&Entry::of::<GainAboveOne>(), &FIXTURES.control, &[]);
    let nominal = certified.reasons(EvidenceKind::Nominal);
    let told = |r: &&Reason| {
        matches!(r, Reason::Run(Shortfall { symptom: Some(_), held: Some(Held::Authority(_)), .. }))
    };
    assert!(nominal.iter().any(told), "{nominal:?}");
    let margins = certified.reasons(EvidenceKind::Margins);
    assert!(margins.iter().any(|r| matches!(r, Reason::Unstable { .. })), "{margins:?}");
}

#[test]
fn a_law_without_an_authority_is_told_which_fault_drives_it_beyond() {
    let mut control = trusting(2.0);
    control.compensation.lateral =
        LoopLimits { size: 0.1, rate: 0.1, ..control.compensation.lateral };
    let certified = Certified::of(&Entry::of::<Trusting>(), &control, &[Instrument::SeamSensor]);
    // While the sensor is in order there is nothing wrong with it.
    assert!(
        certified.reasons(EvidenceKind::Nominal).is_empty(),
        "{:?}",
        certified.reasons(EvidenceKind::Nominal)
    );
    let faults = certified.reasons(EvidenceKind::Faults);
    let told = |r: &&Reason| {
        matches!(r, Reason::Fault { trial, .. }
            if trial.name == "seam-saturated" && trial.figure("correction_m") > 0.01)
    };
    assert!(faults.iter().any(told), "{faults:?}");
}

#[test]
fn the_effects_of_a_cell_are_in_every_run_of_its_certification() {
    let fixtures = &*FIXTURES;
    let text = "nonlinear-stiffness:A2:gain=-0.3,twist_rad=1e-3";
    let effects = [Effect::parse(text, &fixtures.robot).expect("in the library")];
    let real = fixtures.cell(&[text]);
    let law = law("seam-tracking");
    let scenario = fixtures.scenario(&real, WeldProgram::Weld, ControllerKind::EXTERNAL, &law);
    let certification = |effects| {
        let cell = NominalCell { robot: &fixtures.robot.robot, effects, uncertain: &UNCERTAIN };
        let needed =
            RequiredCorrection::of(&scenario, &cell).expect("a weld").expect("a steady part");
        let certification = Certification {
            scenario,
            cell,
            requirements: &REQUIREMENTS,
            needed: &needed,
            passes: 1,
            seed: 7,
        };
        let fault = &certification.faults().expect("long enough")[0];
        let runs = [certification.nominal().figures, certification.trial(0).figures];
        (needed.clone(), runs, certification.run_fault(fault).figures, certification.margins())
    };
    let (bare, with) = (certification(&[]), certification(&effects));
    assert!(bare.0 != with.0, "the correction that is needed");
    for k in 0..2 {
        assert!(bare.1[k] != with.1[k], "{:?}", with.1[k]);
    }
    assert!(bare.2 != with.2, "{:?}", with.2);
    assert!(bare.3.expect("within reach") != with.3.expect("within reach"));
    // The nominal run is the weld that `trueweld weld` makes in the same cell.
    let weld = WeldFigures::of(&run(&scenario, |_| {}).expect("the run ends")).expect("steady");
    let lateral = with.1[0].as_ref().expect("figures")["lateral_rms_m"];
    assert!((lateral - weld.lateral.rms).abs() < 1e-12, "{lateral} against {}", weld.lateral.rms);
}

/// What a run gives whose figures grow with how far a few numbers are from the believed ones.
fn formula(index: u64, draw: SampledCell) -> Trial {
    let towards: f64 =
        3.0 * (1.0 - draw.stiffness[1]) + 2.0 * (draw.stiffness[2] - 1.0) + (draw.process[4] - 1.0);
    let figure = 1e-5 * (1.0 + towards + 4.0 * (draw.stiffness[1] - 1.0) * (draw.process[0] - 1.0));
    let mut figures: FigureValues =
        WELD_FIGURES.iter().map(|of| (of.figure.key.to_owned(), 0.0)).collect();
    figures.insert("lateral_rms_m".to_owned(), figure);
    Trial { index, draw, figures: Some(figures), symptoms: None, failed: None }
}

#[test]
fn the_search_comes_to_the_worst_corner_of_a_set_and_to_the_same_again() {
    let u = REQUIREMENTS.uncertainty;
    // Softest A2, stiffest A3, highest lateral ratio, and the lower depth stiffness, which counts
    // with a soft A2.
    let worst = 1e-5 * (1.0 + 6.0 * u.stiffness + 4.0 * u.stiffness * u.process);
    let trials: Vec<Trial> =
        (0..DRAWS).map(|k| formula(k, SampledCell::new(&UNCERTAIN, 7, k))).collect();
    let drawn = trials.iter().map(|t| t.figure("lateral_rms_m")).fold(0.0, f64::max);
    let go = |seed| {
        let nominal = formula(0, SampledCell::nominal(1));
        let found = search(&REQUIREMENTS, &UNCERTAIN, seed, &nominal, &trials, 60, |batch| {
            Ok::<_, RunError>(batch.iter().map(|(k, draw)| formula(*k, draw.clone())).collect())
        });
        WorstCase::among(&REQUIREMENTS, &nominal, &trials, found.expect("no errors"))
    };
    for seed in 0..20 {
        let found = go(seed);
        let figure = found.worst.as_ref().expect("runs were made").figure("lateral_rms_m");
        assert!(
            figure > 0.999 * worst && figure > drawn,
            "seed {seed}: {figure}, worst {worst}, drawn {drawn}"
        );
        assert_eq!((found.name, found.runs.len()), ("lateral_rms_m", 60));
        assert!(found == go(seed), "seed {seed}");
        for run in &found.runs {
            let shares = run.draw.stiffness.iter().map(|k| (k - 1.0).abs() / u.stiffness);
            assert!(shares.fold(0.0, f64::max) < 1.0 + 1e-9, "outside the set: {:?}", run.draw);
        }
    }
}

#[test]
fn too_few_draws_to_tell_are_no_failure_and_no_pass() {
    // One in twenty may fail, at 95 %. 59 without one show it (Wilks 1941: 0.95⁵⁹ = 0.0485), 20 do
    // not; of 20, one beyond is one in twenty; four beyond show that it is more: that many or more
    // come with a probability of 1.6 % where one in twenty fails.
    let asked = Requirements { failure_probability: 0.05, confidence: 0.95, ..requirements("") };
    let judged = |trials: u64, beyond: u64| {
        let figure = |k| if k < beyond { 1.0 } else { 0.0 };
        let run = |k| {
            let mut trial = formula(k, SampledCell::nominal(k));
            trial.figures.iter_mut().for_each(|figures| {
                figures.insert("lateral_rms_m".to_owned(), figure(k));
            });
            trial
        };
        let nominal = run(beyond);
        let trials: Vec<Trial> = (0..trials).map(run).collect();
        let evidence = Evidence {
            rare: None,
            worst: WorstCase::among(&asked, &nominal, &trials, Vec::new()),
            nominal,
            trials,
            margins: Vec::new(),
            faults: Vec::new(),
        };
        let judged = judge(&asked, &evidence);
        judged.into_iter().find(|r| r.case == EvidenceKind::Draws).expect("a limit")
    };
    assert_eq!(judged(59, 0).verdict, Verdict::Pass);
    assert_eq!(judged(20, 0).verdict, Verdict::NotShown);
    assert_eq!(judged(20, 1).verdict, Verdict::NotShown);
    assert_eq!(judged(20, 4).verdict, Verdict::Fail);
    assert_eq!(judged(0, 0).verdict, Verdict::NotShown);
    // Whether more would help: 93 with one beyond are the next to show it (Clopper and Pearson). With
    // one in twenty beyond no number does; with five of 60, one in twelve, more of them show the
    // opposite: at 5 %, 10 or more of 120 come with a probability of 7.9 %, 15 or more of 180 of 3.7 %.
    let reason = |trials, beyond| judged(trials, beyond).reason.expect("not shown");
    let Reason::TooFewDraws { enough, at_this_rate, .. } = reason(20, 1) else { panic!() };
    assert_eq!((enough, at_this_rate), (Some(93), None));
    let Reason::TooFewDraws { at_this_rate: Some(more), .. } = reason(60, 1) else { panic!() };
    let [before, then] = [more - 60, more].map(|of| Rate { hits: of / 60, of }.at_most(0.95));
    assert!(then <= 0.05 && before > 0.05, "{more}: {before}, {then}");
    let Reason::Draws { decided, .. } = reason(60, 5) else { panic!() };
    assert_eq!(decided, Some(180));
}

#[test]
fn a_limit_of_the_worst_case_is_a_requirement() {
    let strict = requirements("[worst_case]\nlateral_rms_m = 1.2e-5\n");
    let trials: Vec<Trial> =
        (0..DRAWS).map(|k| formula(k, SampledCell::new(&UNCERTAIN, 7, k))).collect();
    let nominal = formula(0, SampledCell::nominal(1));
    let worst = search(&strict, &UNCERTAIN, 7, &nominal, &trials, 60, |batch| {
        Ok::<_, RunError>(batch.iter().map(|(k, draw)| formula(*k, draw.clone())).collect())
    });
    let evidence = Evidence {
        rare: None,
        worst: WorstCase::among(&strict, &nominal, &trials, worst.expect("no errors")),
        nominal,
        trials,
        margins: Vec::new(),
        faults: Vec::new(),
    };
    let judged = judge(&strict, &evidence);
    let worst: Vec<&Requirement> =
        judged.iter().filter(|r| r.case == EvidenceKind::WorstCase).collect();
    assert_eq!(worst.len(), 1);
    assert!(
        worst[0].verdict == Verdict::Fail && matches!(worst[0].reason, Some(Reason::Run(_))),
        "{worst:?}"
    );
    // Faults were asked for and none was tried: that shows nothing.
    let faults = judged.iter().filter(|r| r.case == EvidenceKind::Faults);
    assert!(faults.clone().count() > 0 && faults.clone().all(|r| r.verdict == Verdict::NotShown));
}

#[test]
fn a_worst_case_that_nobody_searched_for_is_not_shown_and_one_that_draws_exceed_fails() {
    let asked = |limit: f64| requirements(&format!("[worst_case]\nlateral_rms_m = {limit}\n"));
    let trials: Vec<Trial> =
        (0..DRAWS).map(|k| formula(k, SampledCell::new(&UNCERTAIN, 7, k))).collect();
    let most = trials.iter().map(|t| t.figure("lateral_rms_m")).fold(0.0, f64::max);
    let verdict = |limit: f64| {
        let (asked, nominal) = (asked(limit), formula(0, SampledCell::nominal(1)));
        let worst = WorstCase::among(&asked, &nominal, &trials, Vec::new());
        let (trials, margins, faults) = (trials.clone(), Vec::new(), Vec::new());
        let judged =
            judge(&asked, &Evidence { rare: None, nominal, trials, worst, margins, faults });
        judged.iter().find(|r| r.case == EvidenceKind::WorstCase).expect("asked for").verdict
    };
    assert_eq!(verdict(1.1 * most), Verdict::NotShown);
    assert_eq!(verdict(0.9 * most), Verdict::Fail);
}

#[test]
fn a_weld_that_misses_any_limit_has_failed() {
    // Every third cell misses the one limit, another third the other: 45 % may miss one, and two thirds
    // miss one of them. Of 60, 20 beyond show at most 44.7 % at 95 %; 40 show 55 % at least.
    let asked = Requirements { failure_probability: 0.45, confidence: 0.95, ..requirements("") };
    let keys = ["lateral_rms_m", "push_error_rms_n"];
    let limits = asked.limits.iter().filter(|limit| keys.contains(&limit.figure.key)).cloned();
    let asked = Requirements { limits: limits.collect(), ..asked };
    assert_eq!(asked.limits.len(), 2);
    let trial = |k: u64| {
        let mut trial = formula(k, SampledCell::nominal(k));
        for (i, key) in keys.iter().enumerate() {
            let figure = if k % 3 == i as u64 { 1e9 } else { 0.0 };
            let figures = trial.figures.as_mut().expect("a weld");
            figures.insert((*key).to_owned(), figure);
        }
        trial
    };
    let trials: Vec<Trial> = (0..60).map(trial).collect();
    let judged = draws(&asked, &trials);
    let verdicts: Vec<(&str, Verdict)> = judged.iter().map(|r| (r.name, r.verdict)).collect();
    assert_eq!(
        verdicts,
        [
            (asked.limits[0].figure.key, Verdict::Pass),
            (asked.limits[1].figure.key, Verdict::Pass),
            ("of_limit", Verdict::Fail)
        ]
    );
    assert_eq!(judged[2].draws.expect("of draws").beyond, 40);
    // The reason names the limit that most miss: both by 20, the one farther beyond.
    let reason = judged[2].reason.as_ref();
    let Some(Reason::Draws { most: Some(most), .. }) = reason else { panic!("{reason:?}") };
    assert_eq!((most.name, most.beyond, most.worst), ("lateral_rms_m", 20, 1e9));
    assert!(drawn_figure(&judged, &judged[2], &trials[0]) > 1.0);
    assert!(drawn_figure(&judged, &judged[2], &trials[2]) < 1.0);
}

#[test]
fn a_correction_at_its_authority_does_not_hide_what_may_fail() {
    // Every weld stands within a millionth of the authority of 10 mm, or at it, and the tool leaves its
    // line by more than allowed where A2 is soft: uniform over 0.9 to 1.1, below 0.9005 in 1 of 400.
    let weld = |index: u64, draw: SampledCell| {
        let mut trial = formula(index, draw);
        let soft = (1.1 - trial.draw.stiffness[1]) / 0.2;
        let figures = trial.figures.as_mut().expect("a weld");
        figures.insert("lateral_rms_m".to_owned(), 3e-4 * soft / 0.9975);
        let noise = (trial.draw.noise % 1000) as f64 / 1000.0;
        figures.insert("correction_m".to_owned(), (0.01 + 1e-8 * (noise - 0.8)).min(0.01));
        trial
    };
    let trials: Vec<Trial> =
        (0..200).map(|k| weld(k, SampledCell::new(&UNCERTAIN, 7, k))).collect();
    let found = |authority: f64| {
        let Fixtures { weld: of, process, control, .. } = &*FIXTURES;
        let mut limits = control.compensation.clone();
        limits.lateral.size = authority;
        let asked = REQUIREMENTS.of_weld(of, process, &limits).expect("limits");
        let nominal = formula(0, SampledCell::nominal(1));
        let run = |batch: &[(u64, SampledCell)]| {
            Ok::<_, RunError>(batch.iter().map(|(k, draw)| weld(*k, draw.clone())).collect())
        };
        rare_failure(&asked, &nominal, &UNCERTAIN, 3, &trials, 1e-3, run).expect("no errors")
    };
    let subset = found(0.01).subset;
    assert!(subset.reached, "{subset:?}");
    assert!(subset.at_least(0.95) < 2.5e-3 && subset.at_most(0.95) > 2.5e-3, "{subset:?}");
    // A limit that may be exceeded counts, though no weld does.
    let subset = found(0.011).subset;
    assert!(!subset.reached, "{subset:?}");
}

fn struck(law: &Entry, fault: Option<InstrumentFault>) -> Recording {
    let scenario = FIXTURES.scenario(&CELL, WeldProgram::Weld, ControllerKind::EXTERNAL, law);
    run(&Scenario { fault, ..scenario }, |_| {}).expect("the run ends")
}

#[test]
fn a_fault_changes_nothing_before_it_begins_and_nothing_but_the_readings() {
    let fault = |instrument, failure| {
        Some(InstrumentFault { instrument, failure, from: 12.0, until: 12.6 })
    };
    let sound = struck(&law("seam-tracking"), None);
    let pairs = |other: &Recording| {
        let same = sound.rows.iter().zip(&other.rows).take_while(|(a, b)| {
            a.real.position == b.real.position && (a.force_sensed_w == b.force_sensed_w)
        });
        same.count() as f64 * sound.period
    };
    let lost = struck(&law("seam-tracking"), fault(Instrument::SeamSensor, Failure::Dropped));
    let zero = struck(&law("seam-tracking"), fault(Instrument::ForceSensor, Failure::Dropped));
    for (name, run) in [("seam", &lost), ("force", &zero)] {
        let until = pairs(run);
        assert!((11.95..12.2).contains(&until), "{name} sensor: the same until {until} s");
    }
    // Without anybody who reads it a seam sensor may say what it likes.
    let bare = [None, fault(Instrument::SeamSensor, Failure::Nan)].map(|f| struck(&law("none"), f));
    assert!(
        bare[0].rows.iter().zip(&bare[1].rows).all(|(a, b)| a.real.position == b.real.position)
    );
}

#[test]
fn a_force_sensor_reads_what_its_fault_makes_of_it() {
    let during = |failure| {
        let fault = InstrumentFault {
            instrument: Instrument::ForceSensor,
            failure,
            from: 12.0,
            until: 12.6,
        };
        let recording = struck(&law("seam-tracking"), Some(fault));
        let rows = recording.rows.into_iter().filter(|r| fault.is_on(r.time));
        rows.map(|r| r.force_sensed_w).collect::<Vec<_>>()
    };
    assert!(during(Failure::Nan).iter().all(|f| f.iter().all(|v| v.is_nan())));
    assert!(during(Failure::Dropped).iter().all(|f| f.norm() == 0.0));
    // In axes of W a reading that stands still in T turns with the tool, by milliradians.
    let stuck = during(Failure::Stuck);
    assert!(stuck.iter().all(|f| (f - stuck[0]).norm() < 100.0 && f.norm() > 10e3));
    let saturated = during(Failure::Saturated { linear: 30e3, angular: 5e3 });
    assert!(
        saturated.iter().all(|f| (f.norm() - 3_f64.sqrt() * 30e3).abs() < 1.0 && f.z < 0.0),
        "{:?}",
        saturated[0]
    );
    // Noise of 25 N a channel, and of the 18 kN of push nothing.
    let noise = during(Failure::Noise { linear: 25.0, angular: 5.0 });
    let rms =
        (noise.iter().map(|f| f.norm_squared() / 3.0).sum::<f64>() / noise.len() as f64).sqrt();
    // 150 numbers: their RMS is known to 6 % (one standard deviation).
    assert!((rms - 25.0).abs() < 6.0 && noise[0] != noise[1], "{rms}");
}

#[test]
fn a_force_sensor_whose_scale_is_off_takes_the_push_along_with_it() {
    let fault = InstrumentFault {
        instrument: Instrument::ForceSensor,
        failure: Failure::Gain { relative: 0.05 },
        from: 12.0,
        until: 18.0,
    };
    let recording = struck(&law("seam-tracking"), Some(fault));
    let rows = recording.rows.into_iter().filter(|r| (16.0..18.0).contains(&r.time));
    let push = Spread::of(rows.map(|r| -r.force_w.z)).mean;
    // The force loop makes the reading 18 kN; tenths of a per cent are of the ripple and of a loop
    // that still settles.
    assert!((push - 18e3 / 1.05).abs() < 60.0, "{push}");
}

#[test]
fn requirements_say_where_they_are_wrong() {
    let text = std::fs::read_to_string(trueweld_tests::fixture("requirements/lap-weld.toml"))
        .expect("a fixture");
    for (right, wrong, expected) in [
        ("recovery_s", "recover_s", "unknown key `recover_s` in [faults]"),
        ("recovery_s", "recovery_s = -1.0 #", "above 0"),
        ("fault = \"force-gain\"", "fault = \"force-gane\"", "one of force-nan, force-stuck"),
        ("figures = [", "figures = [\"speed\", ", "no figure of a fault"),
        // What any law meets is no requirement.
        ("confidence = 0.95", "confidence = 1e-9", "confidence"),
        ("lateral_rms_m = 5.0e-5", "lateral_rms_m = 1e12", "lateral_rms_m"),
    ] {
        assert!(text.contains(right));
        let error = Requirements::parse(&text.replacen(right, wrong, 1), "requirements.toml");
        let error = error.expect_err("a mistake").to_string();
        assert!(error.contains("requirements.toml:") && error.contains(expected), "{error}");
    }
}

/// A weld of the coupon with another push, and the figures that the nominal run of its certificate has.
struct Coupon {
    of: Fixtures,
    effects: Vec<Effect>,
    cell: Cell,
}

impl Coupon {
    fn new(push: f64, effects: &[&str]) -> Self {
        let mut of = Fixtures::of("coupon");
        of.weld.force = push;
        let cell = of.cell(effects);
        let parse = |text: &&str| Effect::parse(text, &of.robot).expect("in the library");
        Self { effects: effects.iter().map(parse).collect(), of, cell }
    }

    /// The weld, and what a certificate with these requirements says of it: of its nominal run, and
    /// of so many draws.
    fn certified(
        &self,
        requirements: &Requirements,
        law: &Entry,
        draws: u64,
    ) -> (WeldFigures, Vec<Requirement>) {
        let Self { of, effects, cell } = self;
        let uncertain = uncertain(requirements);
        let requirements = asked(requirements, of).expect("limits that can be exceeded");
        let scenario = of.scenario(cell, WeldProgram::Weld, ControllerKind::EXTERNAL, law);
        let cell = NominalCell { robot: &of.robot.robot, effects, uncertain: &uncertain };
        let needed =
            RequiredCorrection::of(&scenario, &cell).expect("a weld").expect("a steady part");
        let certification = Certification {
            scenario,
            cell,
            requirements: &requirements,
            needed: &needed,
            passes: 1,
            seed: 7,
        };
        let nominal = certification.nominal();
        let trials: Vec<Trial> = (0..draws).map(|k| certification.trial(k)).collect();
        let worst = WorstCase::among(&requirements, &nominal, &trials, Vec::new());
        let (margins, faults) = (Vec::new(), Vec::new());
        let evidence = Evidence { rare: None, nominal, trials, worst, margins, faults };
        let weld = WeldFigures::of(&run(&scenario, |_| {}).expect("the run ends"));
        (weld.expect("steady"), judge(&requirements, &evidence))
    }
}

/// Requirements that limit what no law can exceed, and so leave all to what is asked of every weld.
fn nothing_of_its_own() -> Requirements {
    Requirements::parse(
        "schema = \"requirements/1\"\nfailure_probability = 0.5\nconfidence = 0.75\n\
         [limits]\ncorrection_m = 0.013\n\
         [uncertainty]\nstiffness = 0.3\nprocess = 0.3\nripple = 0.5\ncrosstalk = 0.02\n\
         delay_periods = [1.0, 2.0]\n",
        "requirements",
    )
    .expect("in order")
}

#[test]
fn a_certificate_and_a_weld_of_the_same_cell_never_disagree() {
    let requirements = nothing_of_its_own();
    let soft = "thermal-softening::share=0.85,time_s=10";
    let (mut met, mut missed) = (0, Vec::new());
    for (push, effects, name) in [
        (18e3, &[][..], "seam-tracking"),
        (18e3, &[], "none"),
        (18e3, &[soft], "seam-tracking"),
        (12e3, &[soft], "feed-forward"),
        (16e3, &["backlash:A5:half_gap_rad=2e-4"], "elastostatic"),
        (21e3, &["stiffness-error:A2:relative=-0.5"], "none"),
        (22e3, &["drag-error::relative=0.4"], "seam-tracking"),
        (25e3, &[], "seam-tracking"),
    ] {
        let (weld, judged) = Coupon::new(push, effects).certified(&requirements, &law(name), 0);
        let nominal: Vec<&Requirement> =
            judged.iter().filter(|r| r.case == EvidenceKind::Nominal).collect();
        // No row but these: the correction is held to 13 mm by the control file.
        assert_eq!(nominal.len(), weld.judged.len());
        for (key, of_weld) in ASKED_FIGURES.iter().zip(&weld.judged) {
            let row = nominal.iter().find(|r| r.name == *key).expect("asked of every weld");
            let told = format!("{push} N, {effects:?}, {name}: {row:?} against {of_weld:?}");
            assert_eq!(row.verdict == Verdict::Pass, of_weld.met, "{told}");
            if !of_weld.met {
                missed.push(*key);
            }
        }
        assert_eq!(Verdict::of(nominal.iter().copied()) == Verdict::Pass, weld.met);
        met += usize::from(weld.met);
    }
    // The cells tell: some are as asked for, and others miss it by the line, the depth and the drives.
    assert!((1..8).contains(&met), "{met}");
    for key in ["lateral_max_m", "depth_error_max_m", "torque_share_max"] {
        assert!(missed.contains(&key), "{missed:?}");
    }
}

#[test]
fn no_certificate_passes_with_a_drive_at_its_torque_limit_and_the_reason_names_the_drive() {
    let requirements = nothing_of_its_own();
    let (weld, judged) =
        Coupon::new(25e3, &[]).certified(&requirements, &law("seam-tracking"), DRAWS);
    // In time: a third of the steady part and more, and all of it A2's.
    assert!(weld.at_limit_s > 1.0 && weld.drives[1].at_torque_limit > 0.05, "{:?}", weld.drives);
    for case in [EvidenceKind::Nominal, EvidenceKind::Draws] {
        let of_torque = |r: &&Requirement| r.case == case && r.name == "torque_share_max";
        let row = judged.iter().find(of_torque).expect("asked of every weld");
        assert_eq!(row.verdict, Verdict::Fail, "{row:?}");
        let run = match row.reason.as_ref().expect("a reason") {
            Reason::Run(run) | Reason::Draws { worst: run, .. } => run,
            other => panic!("{other:?}"),
        };
        assert!(matches!(run.held, Some(Held::Torque(1, share)) if share > 0.05), "{run:?}");
    }
    // At the push of the file no drive is near its limit.
    let (weld, judged) =
        Coupon::new(18e3, &[]).certified(&requirements, &law("seam-tracking"), DRAWS);
    assert!(weld.met && weld.at_limit_s == 0.0, "{weld:?}");
    assert!(judged.iter().all(|r| r.verdict == Verdict::Pass), "{judged:?}");
}

#[test]
fn a_limit_that_can_show_nothing_is_refused_or_is_no_requirement() {
    let of = |text: &str| {
        let all = format!(
            "schema = \"requirements/1\"\nfailure_probability = 0.5\nconfidence = 0.75\n{text}\n\
             [uncertainty]\nstiffness = 0.3\nprocess = 0.3\nripple = 0.5\ncrosstalk = 0.02\n\
             delay_periods = [1.0, 2.0]\n"
        );
        Requirements::parse(&all, "requirements").expect("possible numbers")
    };
    let coupon = Fixtures::of("coupon");
    let refused = |text: &str, of_weld: &Fixtures, expected: [&str; 2]| {
        let error = asked(&of(text), of_weld).expect_err(text).to_string();
        assert!(expected.iter().all(|words| error.contains(words)), "{error}");
    };
    // Half the pin of 5 mm, a pin, half a degree; beyond them it is not the weld that was asked for.
    for (text, place, most) in [
        (
            "[limits]\nlateral_max_m = 0.008",
            "`lateral_max_m` in [limits] is 0.008 m",
            "at most 0.0025 m",
        ),
        ("[limits]\nlateral_rms_m = 0.009", "`lateral_rms_m` in [limits]", "at most 0.0025 m"),
        ("[limits]\ntilt_max_rad = 0.05", "`tilt_max_rad` in [limits]", "at most 0.0087 rad"),
        ("[limits]\npush_error_mean_n = 5e3", "`push_error_mean_n` in [limits]", "at most 900 N"),
        (
            "[limits]\n[limits.end]\nlongitudinal_max_m = 0.015",
            "in [limits.end]",
            "at most 0.005 m",
        ),
        ("[limits]\n[worst_case]\nlateral_max_m = 0.01", "in [worst_case]", "at most 0.0025 m"),
    ] {
        refused(text, &coupon, [place, most]);
    }
    // A part that the weld has not got: its figures are no numbers, and no limit of them is kept.
    let mut unsettled = Fixtures::of("coupon");
    unsettled.weld.settle = 0.0;
    let start = "[limits]\n[limits.start]\nlateral_max_m = 1e-4";
    refused(start, &unsettled, ["in [limits.start]", "settle_s of the weld is 0"]);
    assert!(asked(&of(start), &coupon).is_ok());
    let (cell, law) = (unsettled.cell(&[]), law("none"));
    let scenario = unsettled.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law);
    let weld = WeldFigures::of(&run(&scenario, |_| {}).expect("the run ends")).expect("steady");
    for of in WELD_FIGURES.iter().filter(|of| of.figure.phase() == "start") {
        assert!((of.value)(&weld).is_nan(), "{}", of.figure.key);
    }
    // The correction is held to 13 mm by the control file: a limit of as much is information, a
    // smaller one a requirement.
    for (limit, counts) in [(0.013, false), (0.012, true)] {
        let stated =
            of(&format!("[limits]\ncorrection_m = {limit}\n[worst_case]\ncorrection_m = {limit}"));
        let asked = asked(&stated, &coupon).expect("in order");
        assert_eq!(asked.limit("correction_m").is_some(), counts);
        assert_eq!(asked.worst_case.len(), usize::from(counts));
        assert_eq!(stated.held(&asked).len(), usize::from(!counts));
        // A limit of the file's own does not switch off what is asked of every weld.
        assert!(ASKED_FIGURES.iter().all(|key| asked.limit(key).is_some()));
    }
}

#[test]
fn a_seam_that_lies_beside_the_taught_one_is_followed_by_who_sees_it() {
    const BESIDE: f64 = 5e-4;
    let requirements = requirements(&format!(
        "[[uncertain]]\nseam = \"shift_y_m\"\ndistribution = \"fixed\"\nvalue = -{BESIDE}\n\
         source = \"test\"\n[limits.start]\nlateral_max_m = 1.0e-3\n"
    ));
    let uncertain = uncertain(&requirements);
    let lateral = |name: &str| {
        let (law, fixtures) = (law(name), &*FIXTURES);
        let scenario = fixtures.scenario(&CELL, WeldProgram::Weld, ControllerKind::EXTERNAL, &law);
        let cell =
            NominalCell { robot: &fixtures.robot.robot, effects: &[], uncertain: &uncertain };
        let needed =
            RequiredCorrection::of(&scenario, &cell).expect("a weld").expect("a steady part");
        let certification = Certification {
            scenario,
            cell,
            requirements: &requirements,
            needed: &needed,
            passes: 1,
            seed: 7,
        };
        let beside = SampledCell { latents: vec![0.0], ..SampledCell::nominal(1) };
        let runs = [SampledCell::nominal(1), beside].map(|draw| certification.weld(0, draw));
        runs.map(|run| ["start.lateral_max_m", "lateral_rms_m"].map(|key| run.figure(key)))
    };
    let [believed, beside] = lateral("feed-forward");
    // Nobody sees it: the tool is off by it from the start to the end, to the side where the load
    // drives it, but for a few hundredths that load and noise make of it.
    assert!((beside[0] - believed[0] - BESIDE).abs() < 0.1 * BESIDE, "{beside:?}");
    assert!((beside[1] - BESIDE).abs() < 0.1 * BESIDE, "{beside:?}");
    // The steady part of the short weld begins before all of it is taken up.
    let [_, beside] = lateral("seam-tracking");
    assert!(beside[1] < 0.2 * BESIDE, "{beside:?}");
}

#[test]
fn a_link_mounted_off_does_not_come_back_as_the_force_loop_closes() {
    // 1 mrad at A4: taught with the real arm, so that the start is on the line, and 1.65 mm off it
    // where the law demands the pose that the model has for the load.
    let off = "geometry-error:A4:x_m=0,y_m=0,z_m=0,rx_rad=0,ry_rad=1e-3,rz_rad=0";
    let fixtures = &*FIXTURES;
    let rise = |effects: &[&str], name: &str| {
        let (cell, law) = (fixtures.cell(effects), law(name));
        let scenario = fixtures.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law);
        let recording = run(&scenario, |_| {}).expect("the run ends");
        WeldFigures::of(&recording).expect("a steady part").phases[1].lateral.max_abs
    };
    for name in ["feed-forward", "elastostatic", "observer", "seam-tracking"] {
        let (with, without) = (rise(&[off], name), rise(&[], name));
        assert!((with - without).abs() < 0.1e-3, "{name}: {with} m, {without} m without");
    }
}

#[test]
fn learning_does_not_grow_from_pass_to_pass_on_firm_or_soft_material() {
    // Across the seam 30 % firmer with two thirds of the drag under a stiffer arm: 0.06 mm grow to
    // 0.3 mm in eight passes where all that seam tracking added is learned. And a tenth as firm.
    for (firmness, drag, arm) in [(1.3, 0.64, 1.25), (0.1, 1.0, 1.0)] {
        let mut process = FIXTURES.process.clone();
        process.scale("lateral_stiffness_n_m", firmness);
        process.scale("feed_drag_ns_m", drag);
        let stiffness = [1.0, arm, arm, 1.0, 1.0, 1.0];
        let robot = FIXTURES.robot.robot.with_stiffness_scaled(&stiffness.into());
        let cell = Cell::new(&robot.expect("a robot"), &[], &process, CELL.seam.clone());
        let (cell, law) = (cell.expect("a cell"), law("learning"));
        let scenario = FIXTURES.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law);
        // RMS and largest, the means over three seeds: of the noise alone the RMS of one weld on soft
        // material scatters by 6 µm, its largest by 20 µm.
        let seeds = [1, 2, 3];
        let lateral = [1, 2, 4, 8].map(|passes| {
            let all = seeds.map(|seed| {
                let scenario = Scenario { seed, ..scenario };
                let recording = run_passes(&scenario, passes, |_| {}).expect("the run ends");
                let Spread { rms, max_abs, .. } =
                    WeldFigures::of(&recording).expect("a steady part").lateral;
                [rms, max_abs]
            });
            [0, 1].map(|k| all.iter().map(|of| of[k]).sum::<f64>() / seeds.len() as f64)
        });
        for (before, after) in lateral.iter().zip(&lateral[1..]) {
            assert!(after[0] < before[0] + 5e-6, "{firmness}: {lateral:?}");
            assert!(after[1] < before[1] + 20e-6, "{firmness}: {lateral:?}");
        }
    }
}
