//! Health signals against double precision: how far approximate mathematics is off, and that it
//! would not do elsewhere.

use crate::support::{cases, seen, wrapped};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use trueweld_core::health::{SpindleLine, VibrationLevel};
use trueweld_core::monitor::{HealthMonitor, HealthSignals};

/// Sampling of the signals, s: a force channel at 1 kHz.
const PERIOD: f64 = 1e-3;

/// Time constant of the averages, s.
const TAU_S: f64 = 0.5;

/// Exact counterpart of [`VibrationLevel`]: weights (1 − s)ᵏ on the samples, from the newest back.
fn weighted_rms(samples: &[f64]) -> f64 {
    let share = PERIOD / (TAU_S + PERIOD);
    // The first sample stands for all before it.
    let weights: Vec<f64> = (0..samples.len())
        .map(|i| {
            let age = (samples.len() - 1 - i) as i32;
            (1.0 - share).powi(age) * if i == 0 { 1.0 } else { share }
        })
        .collect();
    let mean: f64 = weights.iter().zip(samples).map(|(w, x)| w * x).sum();
    weights.iter().zip(samples).map(|(w, x)| w * (x - mean).powi(2)).sum::<f64>().sqrt()
}

/// What a line of `amplitude` and `phase` in order `n` on a mean looks like at a spindle angle.
fn channel(mean: f64, amplitude: f64, phase: f64, order: u8, angle: f64) -> f64 {
    mean + amplitude * (f64::from(order) * angle - phase).cos()
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn vibration_level_is_the_weighted_rms(
        mean in -18e3..18e3_f64,
        amplitude in 1.0..2e3_f64,
        noise in prop::collection::vec(-1.0..1.0_f64, 1500),
    ) {
        let samples: Vec<f64> = noise.iter().map(|n| f64::from((mean + amplitude * n) as f32)).collect();
        let mut level = VibrationLevel::new(TAU_S as f32, PERIOD as f32).unwrap();
        for sample in &samples {
            level.update(*sample as f32);
        }
        let exact = weighted_rms(&samples);
        let off = f64::from(level.level()) / exact - 1.0;
        seen("vibration level too high, share", off);
        seen("vibration level too low, share", -off);
        // micromath's square root is (1 + m/2)/√(1 + m) ≤ 1.061 times the root; the rest is f32 at
        // a mean of up to 1e4 times the vibration. Measured +5.7 %.
        prop_assert!((-2e-3..0.062).contains(&off), "off by {off}");
    }

    #[test]
    fn spindle_line_is_found_under_the_push(
        push in -18e3..18e3_f64,
        amplitude in 20.0..500.0_f64,
        phase in -PI..PI,
        order in 1..4_u8,
        speed in 12.0..20.0_f64,
    ) {
        let mut line = SpindleLine::new(order, TAU_S as f32, PERIOD as f32).unwrap();
        let share = PERIOD / (TAU_S + PERIOD);
        let (mut mean, mut c, mut s) = (None, 0.0, 0.0);
        for k in 0..8000 {
            let angle = f64::from((TAU * speed * PERIOD * f64::from(k)).rem_euclid(TAU) as f32);
            let sample = f64::from(channel(push, amplitude, phase, order, angle) as f32);
            line.update(sample as f32, angle as f32);
            // The same demodulation in double precision with exact functions.
            let (sine, cosine) = (f64::from(order) * angle).sin_cos();
            let before = mean.unwrap_or(sample);
            let step = share * (sample - before - c * cosine - s * sine);
            mean = Some(before + step);
            c += 2.0 * step * cosine;
            s += 2.0 * step * sine;
        }
        // What was put in is found by exact functions to f32's rounding of 18 kN (the start is
        // forgotten to e⁻¹⁶) …
        let found = seen("double precision, share", (f64::hypot(c, s) / amplitude - 1.0).abs());
        prop_assert!(found < 1e-4 && wrapped(s.atan2(c) - phase).abs() < 1e-4);
        // … and by these as closely as the module says.
        let off = f64::from(line.amplitude()) / amplitude - 1.0;
        seen("line too high, share", off);
        seen("line too low, share", -off);
        let turned = seen("phase, rad", wrapped(f64::from(line.phase()) - phase).abs());
        prop_assert!((-5e-3..0.065).contains(&off), "amplitude off by {off}");
        prop_assert!(turned < 5e-3, "phase off by {turned} rad");
    }
}

#[test]
fn spindle_line_is_late_by_its_declared_delay() {
    // A phase that drifts by 0.2 rad/s, ten turns a second: after long, the line shows what was τ
    // ago.
    let mut line = SpindleLine::new(1, TAU_S as f32, PERIOD as f32).unwrap();
    let (drift, steps) = (0.2, 6000);
    let mut ahead = 0.0;
    for k in 1..=steps {
        let time = PERIOD * f64::from(k);
        let angle = (TAU * 10.0 * time).rem_euclid(TAU);
        line.update(channel(18e3, 1000.0, drift * time, 1, angle) as f32, angle as f32);
        if k > steps - 100 {
            // Over a whole turn, which takes the ripple out.
            ahead += wrapped(drift * time - f64::from(line.phase())) / 100.0;
        }
    }
    let late = ahead / drift;
    println!("late by {late:.3} s, declared {} s", line.delay());
    // The phase itself is known to 5e-3 rad.
    assert!((late - f64::from(line.delay())).abs() < 5e-3 / drift);
}

#[test]
fn what_is_no_number_is_passed_over() {
    let mut level = VibrationLevel::new(0.1, 1e-3).unwrap();
    let mut line = SpindleLine::new(2, 0.1, 1e-3).unwrap();
    for k in 0..500 {
        let angle = 0.3 * k as f32 % std::f32::consts::TAU;
        level.update((angle * 2.0).cos());
        line.update((angle * 2.0).cos(), angle);
    }
    let (before, line_before) = (level, line);
    for bad in [f32::NAN, f32::INFINITY, f32::MAX, f32::MIN] {
        assert!(level.update(bad).is_finite());
        line.update(1.0, f32::NAN);
        line.update(bad.signum() * f32::INFINITY, 0.0);
    }
    assert_eq!((level, line), (before, line_before));
    // Before anything was seen, and of a constant, there is nothing.
    level.reset();
    line.reset();
    assert_eq!((level.level(), line.amplitude(), line.phase()), (0.0, 0.0, 0.0));
    assert_eq!(level.update(18e3), 0.0);
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(VibrationLevel::new(bad, 1e-3), None);
        assert_eq!(SpindleLine::new(1, 0.1, bad), None);
    }
    assert_eq!(SpindleLine::new(0, 0.1, 1e-3), None);
}

/// What the watch sees of a push of 18 kN at 600 rpm and of drives that move at these rates, over so
/// many seconds at a control period of 12 ms.
fn watched(
    seconds: f64,
    line: impl Fn(f64) -> f64,
    rates: impl Fn(f64) -> [f64; 6],
) -> (HealthSignals, [f64; 2], [f64; 6]) {
    const CYCLE: f64 = 0.012;
    let mut monitor = HealthMonitor::new(CYCLE as f32).unwrap();
    let (mut last, mut climbs, mut rings) = (HealthSignals::default(), [0.0; 2], [0.0; 6]);
    for k in 1..=(seconds / CYCLE) as usize {
        let time = CYCLE * k as f64;
        let push = 18e3 + line(time) * (20.0 * PI * time - 1.0).cos();
        last = monitor.update(
            push as f32,
            Some(18e3),
            (20.0 * PI) as f32,
            &rates(time).map(|rate| rate as f32),
        );
        for (total, line) in climbs.iter_mut().zip(last.lines) {
            *total += CYCLE * f64::from(u8::from(line.climbs));
        }
        for (total, drive) in rings.iter_mut().zip(last.drives) {
            *total += CYCLE * f64::from(u8::from(drive.rings));
        }
    }
    (last, climbs, rings)
}

/// Noise between −1 and 1, without a line; another for each number.
fn noise(time: f64, number: f64) -> f64 {
    let x = ((time * 1000.0 + 7919.0 * number) * 12.9898).sin() * 43758.5453;
    2.0 * (x - x.floor()) - 1.0
}

#[test]
fn a_line_that_grows_is_warned_of_and_one_that_stays_is_not() {
    let still = |time: f64| [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|k| 1e-5 * noise(time, k));
    let (last, climbs, rings) = watched(40.0, |_| 100.0, still);
    assert_eq!((climbs, rings), ([0.0; 2], [0.0; 6]));
    let line = last.lines[0];
    assert!((0.99..1.07).contains(&(f64::from(line.amplitude) / 100.0)), "{line:?}");
    assert!((f64::from(line.phase) - 1.0).abs() < 6e-3, "{line:?}");
    // Three times from 20 s on: seen some seconds later, order 1 alone.
    let (_, climbs, _) = watched(40.0, |time| if time < 20.0 { 100.0 } else { 300.0 }, still);
    assert!((17.0..20.0).contains(&climbs[0]) && climbs[1] == 0.0, "{climbs:?}");
}

#[test]
fn a_drive_that_swings_longer_and_longer_is_warned_of_and_none_that_dies_away() {
    // e^(−ζωt) sin ωt, started anew every two seconds, or ten where it lasts; with noise, a line of the
    // spindle and a slow motion beside it, which a line has to stand out of.
    let drive = |time: f64, k: f64, size: f64, frequency: f64, damping: f64| {
        let omega = TAU * frequency;
        let since = time % if damping > 0.01 { 2.0 } else { 10.0 };
        let swing = (-damping * omega * since).exp() * (omega * since).sin();
        size * swing
            + 1e-4 * (0.1 * noise(time, k) + 3.0 * (20.0 * PI * time).sin())
            + 1e-3 * (0.7 * time).sin()
    };
    let rates = |time: f64| {
        [
            drive(time, 1.0, 1e-4, 16.5, -0.002),
            drive(time, 2.0, 1e-3, 16.5, 0.05),
            drive(time, 3.0, 1e-3, 7.0, 0.05),
            drive(time, 4.0, 1e-3, 7.0, 0.005),
            drive(time, 5.0, 1e-3, 24.0, 0.1),
            1e-4 * noise(time, 6.0),
        ]
    };
    let (last, _, rings) = watched(20.0, |_| 100.0, rates);
    println!("{rings:?} {:?}", last.drives);
    for (joint, rings) in rings.iter().enumerate() {
        assert_eq!(*rings > 5.0, joint == 0 || joint == 3, "A{}: {rings} s", joint + 1);
    }
    // acos of `micromath` is good to 0.03 rad.
    let off = f64::from(last.drives[0].frequency) - 16.5;
    assert!(off.abs() < 0.03 / (TAU * 0.012) + 0.05, "{off} Hz");
}

#[test]
fn approximate_sines_would_not_do_in_kinematics() {
    // The tool 2 m out on axis A1, all around: where exact functions put it, and where these would.
    let furthest = |functions: fn(f32) -> (f32, f32)| {
        (-20_000..20_000).fold(0.0, |furthest: f64, k| {
            let angle = k as f32 * 1.6e-4;
            let (s, c) = functions(angle);
            let exact = f64::from(angle).sin_cos();
            furthest.max(2.0 * f64::hypot(f64::from(s) - exact.0, f64::from(c) - exact.1))
        })
    };
    let (approximate, single) = (furthest(micromath::F32Ext::sin_cos), furthest(f32::sin_cos));
    println!(
        "2 m out: {:.2} mm with micromath, {:.1e} mm with f32's own",
        approximate * 1e3,
        single * 1e3
    );
    // A weld is held to tenths of a millimetre; f32 itself knows 2 m to 1.2e-7 m.
    assert!(approximate > 1e-3 && single < 3e-7);
}
