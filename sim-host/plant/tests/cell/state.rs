//! A run goes on from its state as if it had not been interrupted, to the last bit.

use crate::cell::support::Fixtures;
use trueweld_compensators::{Entry, library};
use trueweld_core::state::StateError;
use trueweld_plant::input::Weld;
use trueweld_plant::integrate::{Integrator, Tolerance};
use trueweld_plant::sensors::{Failure, Instrument, InstrumentFault};
use trueweld_plant::simulate::{
    ControllerKind, Scenario, Simulation, WeldProgram, restore_state, state_of,
};

/// A weld of a centimetre, whose force loop closes at once; every instrument is late and noisy.
fn short() -> Fixtures {
    let mut fixtures = Fixtures::of("vertical");
    let Weld { start, end, .. } = fixtures.weld;
    fixtures.weld.end = start + (end - start).normalize() * 0.01;
    (fixtures.weld.settle, fixtures.weld.force_ramp, fixtures.weld.feed_ramp) = (0.12, 0.24, 0.24);
    fixtures.sensors.force.jitter = 0.003;
    fixtures.sensors.torque_noise = [5.0; 6];
    let seam = fixtures.sensors.seam.as_mut().expect("a seam sensor");
    (seam.jitter, seam.ahead) = (0.03, 0.004);
    fixtures
}

/// Runs `before` periods, and from there on `after` periods twice: in one go, and from the state in
/// a run made anew.
fn goes_on(scenario: &Scenario<'_>, before: usize, after: usize) {
    let name = scenario.law.name();
    let mut whole = Simulation::new(scenario).expect("a start");
    for _ in 0..before {
        whole.step(scenario).expect("a period");
    }
    let state = whole.state().expect("a state");
    let mut restored = Simulation::new(scenario).expect("a start");
    restored.restore(&state).expect("its own state");
    assert_eq!(restored.state().as_deref(), Ok(&state[..]), "{name}");
    for k in 0..after {
        let [expected, found] =
            [&mut whole, &mut restored].map(|run| run.step(scenario).expect("a period"));
        assert_eq!(format!("{found:?}"), format!("{expected:?}"), "{name}, period {k}");
    }
    assert_eq!(restored.restore(&state[..state.len() - 1]), Err(StateError::Length), "{name}");
    let longer = [&state[..], &[0.0]].concat();
    assert_eq!(restored.restore(&longer), Err(StateError::Length), "{name}");
}

#[test]
fn every_law_and_controller_goes_on_from_its_state() {
    let fixtures = short();
    let cell = fixtures
        .cell(&["backlash:A5:half_gap_rad=2e-4", "hysteresis:A2:torque_nm=400,twist_rad=1e-4"]);
    let combined = trueweld_compensators::find("elastostatic+seam-tracking").expect("two laws");
    let laws: Vec<Entry> = library().iter().cloned().chain([combined]).collect();
    for (k, law) in laws.iter().enumerate() {
        let kinds =
            [ControllerKind::EXTERNAL, ControllerKind::PARALLEL, ControllerKind::SUPERPOSED];
        let scenario = fixtures.scenario(&cell, WeldProgram::Weld, kinds[k % 3], law);
        // Before the force loop closes, and while the tool moves.
        goes_on(&scenario, 5, 20);
        goes_on(&scenario, 60, 20);
    }
}

#[test]
fn a_run_goes_on_between_reading_and_control() {
    let fixtures = short();
    let cell = fixtures.cell(&["backlash:A5:half_gap_rad=2e-4"]);
    let law = trueweld_compensators::find("seam-tracking").expect("a law");
    let scenario = fixtures.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law);
    let mut whole = Simulation::new(&scenario).expect("a start");
    let mut restored = Simulation::new(&scenario).expect("a start");
    let mut readings = restored.cell.observe(&scenario).readings;
    for _ in 0..60 {
        whole.step(&scenario).expect("a period");
    }
    let mut seen = whole.cell.observe(&scenario);
    restored.restore(&whole.state().expect("a state")).expect("its own state");
    let of_readings = state_of(&mut seen.readings).expect("a state");
    restore_state(&mut readings, &of_readings).expect("the readings' own state");
    let mut again = restored.cell.observed(&scenario, seen.time, readings);
    assert_eq!(format!("{again:?}"), format!("{seen:?}"));
    for _ in 0..5 {
        let rows = [(&mut whole, &seen), (&mut restored, &again)]
            .map(|(run, seen)| format!("{:?}", run.control(&scenario, seen)));
        assert_eq!(rows[0], rows[1]);
        for run in [&mut whole, &mut restored] {
            run.cell.advance(&scenario).expect("a period");
        }
        [seen, again] = [&mut whole, &mut restored].map(|run| run.cell.observe(&scenario));
        assert_eq!(format!("{again:?}"), format!("{seen:?}"));
    }
}

#[test]
fn an_adaptive_step_and_a_failing_instrument_go_on_from_their_state() {
    let fixtures = short();
    let cell = fixtures.cell(&[]);
    let law = trueweld_compensators::find("seam-tracking").expect("a law");
    let scenario = fixtures.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law);
    let adaptive = Integrator::DormandPrince(Tolerance::REFERENCE);
    goes_on(&Scenario { integrator: adaptive, ..scenario }, 12, 3);
    for instrument in [Instrument::ForceSensor, Instrument::SeamSensor] {
        let failure = Failure::OutOfOrder;
        let fault = Some(InstrumentFault { instrument, failure, from: 0.3, until: 9.0 });
        goes_on(&Scenario { fault, ..scenario }, 40, 10);
    }
}

#[test]
fn a_state_with_a_number_that_cannot_be_is_refused() {
    let fixtures = short();
    let cell = fixtures.cell(&[]);
    let law = trueweld_compensators::find("none").expect("a law");
    let scenario = fixtures.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law);
    let mut run = Simulation::new(&scenario).expect("a start");
    let mut state = run.state().expect("a state");
    // How many periods are over.
    for wrong in [0.5, -1.0, f64::NAN, f64::INFINITY] {
        state[0] = wrong;
        assert_eq!(run.restore(&state), Err(StateError::Value), "{wrong}");
    }
}
