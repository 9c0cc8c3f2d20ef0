//! The PID loop: its law, its limits, and that its integrator neither winds up nor loses what it
//! was given.

use crate::support::{cases, wild};
use proptest::prelude::*;
use trueweld_core::pid::{Pid, PidGains};

const PERIOD: f64 = 0.012;

fn gains() -> impl Strategy<Value = PidGains<f64>> {
    (0.0..100.0, 0.0..100.0, 0.0..1.0).prop_map(|(kp, ki, kd)| PidGains { kp, ki, kd })
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn unlimited_it_is_the_textbook_law(gains in gains(), errors in prop::collection::vec(-1.0..1.0_f64, 1..50)) {
        let mut pid = Pid::new(gains);
        let (mut sum, mut before) = (0.0, errors[0]);
        for e in errors {
            sum += e * PERIOD;
            let expected = 7.0 + gains.kp * e + gains.ki * sum + gains.kd * (e - before) / PERIOD;
            before = e;
            let (output, limited) = pid.update(e, 7.0, f64::MAX, PERIOD);
            // Terms of up to 1e2 · some, 50 sums.
            prop_assert!((output - expected).abs() < 1e-11 && !limited);
        }
    }

    #[test]
    fn output_never_leaves_its_limit(gains in gains(), limit in 0.0..50.0_f64,
                                     steps in prop::collection::vec((wild(), wild()), 1..50)) {
        let mut pid = Pid::new(gains);
        for (error, feed_forward) in steps {
            let (output, _) = pid.update(error, feed_forward, limit, PERIOD);
            prop_assert!(output.abs() <= limit, "{output} for {error} and {feed_forward}");
            prop_assert!(pid.integral().is_finite(), "the integrator is lost after {error} and {feed_forward}");
        }
        // Whatever came before, an honest error is answered again once the difference has forgotten
        // it.
        let (held, _) = pid.update(0.0, 0.0, limit, PERIOD);
        prop_assert!(held.abs() <= limit);
    }

    #[test]
    fn saturation_ends_the_moment_the_error_turns(gains in gains(), push in 1.0..10.0_f64, back in 0.01..1.0_f64,
                                                  long in 1..2000_usize) {
        let limit = 5.0;
        let mut pid = Pid::new(PidGains { kd: 0.0, ..gains });
        for _ in 0..long {
            pid.update(push, 0.0, limit, PERIOD);
        }
        // What the integrator holds fits under the limit, however long the error has stood.
        prop_assert!(pid.integral() <= limit);
        let held = pid.integral();
        let (output, limited) = pid.update(-back, 0.0, limit, PERIOD);
        let expected = (held - gains.kp * back - gains.ki * back * PERIOD).max(-limit);
        prop_assert!((output - expected).abs() < 1e-12, "{output} instead of {expected}");
        prop_assert!(output < limit && (!limited || output == -limit));
    }

    #[test]
    fn preload_and_hand_over_are_bumpless(gains in gains(), load in -1e4..1e4_f64, other in -1e4..1e4_f64) {
        let mut pid = Pid::new(gains);
        pid.preload(load);
        prop_assert_eq!(pid.update(0.0, 0.0, 1e6, PERIOD), (load, false));
        // Taken out of the integrator and fed forward instead: the output stays, but for one
        // rounding.
        pid.transfer_integral(-other);
        prop_assert!((pid.update(0.0, other, 1e6, PERIOD).0 - load).abs() < 1e-11);
    }
}

#[test]
fn a_limit_that_is_none_leaves_no_output() {
    for limit in [-1.0, f64::NAN, 0.0] {
        let mut pid = Pid::new(PidGains { kp: 2.0, ki: 1.0, kd: 0.0 });
        assert_eq!(pid.update(1.0, 5.0, limit, 0.012), (0.0, true), "limit {limit}");
        assert_eq!(pid.integral(), 0.0);
    }
}
