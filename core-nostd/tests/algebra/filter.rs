//! Filters as signal theory has them: declared delay, corner, notch, steady state.

use crate::support::cases;
use proptest::prelude::*;
use trueweld_core::control::{LONGEST_DELAY, SpindleFilter};
use trueweld_core::filter::{Biquad, Filter, FilterBank, MovingAverage};

/// Control period of the tests, s: the published controller's.
const PERIOD: f64 = 0.012;

/// How far a slow ramp comes out late, s, when everything else has died away.
fn lag(filter: &mut impl Filter<f64>) -> f64 {
    filter.initialize(0.0);
    let mut late = 0.0;
    for k in 1..=20_000 {
        let time = f64::from(k) * PERIOD;
        late = time - filter.update(time);
    }
    late
}

/// Amplitude of what comes out of a unit sine of `frequency` Hz, by correlation over whole turns.
fn gain(filter: &mut impl Filter<f64>, frequency: f64, period: f64) -> f64 {
    filter.initialize(0.0);
    // 2^15 samples to forget the start; then as many turns as fit whole into a window near 2^15
    // samples.
    let turns = (32768.0 * frequency * period).round().max(1.0);
    let window = 32768;
    let frequency = turns / (f64::from(window) * period);
    let (mut s, mut c) = (0.0, 0.0);
    for k in 0..2 * window {
        let phase = core::f64::consts::TAU * frequency * period * f64::from(k);
        let out = filter.update(phase.sin());
        if k >= window {
            s += out * phase.sin();
            c += out * phase.cos();
        }
    }
    2.0 / f64::from(window) * f64::hypot(s, c)
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn declared_delay_is_the_lag_of_a_ramp(corner in 0.5..35.0_f64, width in 0.5..10.0_f64) {
        // The ramp ends at 240 s, an ulp of 3e-14 fed back through some hundreds of samples; the
        // slowest filter here forgets within 2 s.
        let mut low = Biquad::low_pass(corner, PERIOD).unwrap();
        prop_assert!((lag(&mut low) - low.delay()).abs() < 1e-9, "{} against {}", lag(&mut low), low.delay());
        let mut notch = Biquad::notch(corner, width, PERIOD).unwrap();
        prop_assert!((lag(&mut notch) - notch.delay()).abs() < 1e-9, "{} against {}", lag(&mut notch), notch.delay());
        let mut mean = MovingAverage::<f64, 9>::new(PERIOD);
        prop_assert!((lag(&mut mean) - mean.delay()).abs() < 1e-9);
        // Nine samples: the middle one is four periods old.
        prop_assert!((mean.delay() - 4.0 * PERIOD).abs() < 1e-15);
    }

    #[test]
    fn low_pass_is_three_decibels_down_at_its_corner(corner in 1.0..35.0_f64) {
        let turns = (32768.0 * corner * PERIOD).round();
        let corner = turns / (32768.0 * PERIOD);
        let mut low = Biquad::low_pass(corner, PERIOD).unwrap();
        let at = gain(&mut low, corner, PERIOD);
        prop_assert!((at - core::f64::consts::FRAC_1_SQRT_2).abs() < 1e-9, "gain {at}");
        // Second-order Butterworth with the corner pre-warped: |H|² = 1 / (1 + (tan πfT / tan
        // πf_cT)⁴).
        let warp = |f: f64| (core::f64::consts::PI * f * PERIOD).tan();
        let half = (turns * 0.5).round() / (32768.0 * PERIOD);
        let expected = 1.0 / (1.0 + (warp(half) / warp(corner)).powi(4)).sqrt();
        prop_assert!((gain(&mut low, half, PERIOD) - expected).abs() < 1e-9);
    }

    #[test]
    fn notch_removes_its_frequency_and_little_else(center in 4.0..35.0_f64) {
        let turns = (32768.0 * center * PERIOD).round();
        let center = turns / (32768.0 * PERIOD);
        let mut notch = Biquad::notch(center, 1.0, PERIOD).unwrap();
        prop_assert!(gain(&mut notch, center, PERIOD) < 1e-9);
        // A tenth of the centre's frequency, well outside a width of 1 Hz, passes: 1 − gain ≈
        // (0.1·w/f)²/2 ≤ 4e-4.
        prop_assert!((gain(&mut notch, 0.1 * center, PERIOD) - 1.0).abs() < 2e-3);
    }

    #[test]
    fn notch_is_as_wide_as_asked(center in 4.0..20.0_f64, width in 0.2..1.0_f64) {
        // Slow against Nyquist the −3 dB points lie a width apart; the bilinear transform bends
        // them by about (πfT)²/3.
        let period = 1e-3;
        let mut notch = Biquad::notch(center, width, period).unwrap();
        // −3 dB where f/f₀ − f₀/f = ± w/f₀, so f = ±w/2 + √(f₀² + w²/4).
        let root = (center * center + width * width / 4.0).sqrt();
        for edge in [root - width / 2.0, root + width / 2.0] {
            let at = gain(&mut notch, edge, period);
            // The window fits whole turns to 0.015 Hz, an eighth of the narrowest half width: gain
            // slope 0.35 per half width, plus the bending above.
            prop_assert!((at - core::f64::consts::FRAC_1_SQRT_2).abs() < 0.06, "gain {at} at {edge} Hz");
        }
    }

    #[test]
    fn settled_filters_stand_still(value in -2e4..2e4_f64, corner in 0.5..35.0_f64) {
        let mut low = Biquad::low_pass(corner, PERIOD).unwrap();
        let mut notch = Biquad::notch(corner, 2.0, PERIOD).unwrap();
        let mut mean = MovingAverage::<f64, 7>::new(PERIOD);
        low.initialize(value);
        notch.initialize(value);
        mean.initialize(value);
        for _ in 0..100 {
            // Gain one at rest. A slow corner forms it from coefficients of (πf_cT)² ≈ 4e-4: 1/4e-4
            // ε.
            prop_assert!((low.update(value) - value).abs() <= 1e-12 * value.abs());
            prop_assert!((notch.update(value) - value).abs() <= 1e-12 * value.abs());
            prop_assert!((mean.update(value) - value).abs() <= 1e-15 * 7.0 * value.abs());
        }
    }

    #[test]
    fn moving_average_is_the_mean(samples in prop::collection::vec(-1e4..1e4_f64, 1..40)) {
        let mut filter = MovingAverage::<f64, 5>::new(PERIOD);
        for (k, sample) in samples.iter().enumerate() {
            let window = &samples[(k + 1).saturating_sub(5)..=k];
            let mean = window.iter().sum::<f64>() / window.len() as f64;
            prop_assert!((filter.update(*sample) - mean).abs() < 1e-11);
        }
    }

    #[test]
    fn a_bank_filters_every_channel_alone(samples in prop::collection::vec(prop::array::uniform3(-1e4..1e4_f64), 1..40)) {
        let one = Biquad::low_pass(8.0, PERIOD).unwrap();
        let mut bank = FilterBank::<_, 3>::new(one);
        let mut alone = [one; 3];
        bank.initialize(&samples[0].into());
        alone.iter_mut().zip(samples[0]).for_each(|(f, v)| f.initialize(v));
        for sample in samples {
            let out = bank.update(&sample.into());
            for i in 0..3 {
                prop_assert_eq!(out[i], alone[i].update(sample[i]));
            }
        }
    }
}

#[test]
fn moving_average_of_one_turn_removes_the_spindle() {
    // 600 rpm, sampled 20 times a turn.
    let period = 0.1 / 20.0;
    for order in [10.0, 20.0, 50.0] {
        let mut mean = MovingAverage::<f64, 20>::new(period);
        for k in 0..200 {
            let out = mean.update((core::f64::consts::TAU * order * period * f64::from(k)).sin());
            assert!(k < 20 || out.abs() < 1e-13, "{order} Hz leaves {out}");
        }
    }
}

#[test]
fn impossible_filters_are_refused() {
    for corner in [0.0, -1.0, 0.5 / PERIOD, 100.0, f64::NAN, f64::INFINITY] {
        assert!(Biquad::low_pass(corner, PERIOD).is_none(), "low-pass at {corner}");
        assert!(Biquad::notch(corner, 1.0, PERIOD).is_none(), "notch at {corner}");
    }
    for bad in [0.0, -1.0, f64::NAN] {
        assert!(Biquad::low_pass(1.0, bad).is_none(), "period {bad}");
        assert!(Biquad::notch(1.0, bad, PERIOD).is_none(), "width {bad}");
    }
}

#[test]
fn single_precision_keeps_the_design() {
    // A 2 Hz corner at 1 kHz, the slowest in sight: coefficients of (πf_cT)² = 4e-5, so 18 kN
    // settle to 18 kN · 3e-3.
    let mut low = Biquad::<f32>::low_pass(2.0, 1e-3).unwrap();
    low.initialize(18_000.0);
    for _ in 0..2000 {
        assert!((low.update(18_000.0) - 18_000.0).abs() < 50.0);
    }
    let double = Biquad::<f64>::low_pass(2.0, 1e-3).unwrap();
    assert!((f64::from(low.delay()) / double.delay() - 1.0).abs() < 3e-3);
}

/// A spindle's filter at so many turns a minute.
fn spindle(rpm: f64) -> SpindleFilter<f64> {
    let mut filter = SpindleFilter::new(PERIOD);
    filter.tune(rpm * core::f64::consts::TAU / 60.0);
    filter
}

/// Where a line of `frequency` Hz appears in samples, Hz.
fn folded(frequency: f64) -> f64 {
    let rate = 1.0 / PERIOD;
    (frequency - rate * (frequency / rate).round()).abs()
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn spindle_lines_are_gone_where_they_appear(turns in 2000..80_000_u32, backwards in any::<bool>()) {
        // Whole turns in the window of `gain`; 305 to 12 000 rpm, well beyond Nyquist.
        let frequency = f64::from(turns) / (32768.0 * PERIOD);
        let sense = if backwards { -60.0 } else { 60.0 };
        let mut filter = spindle(sense * frequency);
        for line in [frequency, 2.0 * frequency].map(folded) {
            // A line that appears at 2 Hz delays slow signals by 12 ms; below, it is left, and so
            // is the loop's phase. At Nyquist, 41.67 Hz, the null lies a five-hundredth of the
            // sampling rate beside the line.
            if line > 2.05 && line < 41.58 {
                let left = gain(&mut filter, line, PERIOD);
                prop_assert!(left < 1e-9, "{left} of the line that appears at {line} Hz is left");
            }
        }
        prop_assert!(filter.delay() <= 2.0 * LONGEST_DELAY);
        prop_assert!((lag(&mut filter) - filter.delay()).abs() < 1e-9, "{} against {}", lag(&mut filter), filter.delay());
    }

    #[test]
    fn a_line_near_rest_is_left_and_the_phase_kept(rpm in 1.0..55.0_f64) {
        // Both orders below 2 Hz, and the same folded back from the sampling rate.
        for rpm in [rpm, 60.0 / PERIOD - rpm] {
            let mut filter = spindle(rpm);
            prop_assert_eq!(filter.delay(), 0.0);
            prop_assert_eq!(filter.update(1e4), 1e4);
        }
    }

    #[test]
    fn at_a_rate_that_is_one_percent_off_an_eighth_is_left(rpm in 300.0..1200.0_f64, off in -0.01..0.01_f64) {
        // |H| = x / √(1 + x²) with x = 2·0.01/0.15 for a narrow notch; the second one adds less than a tenth to it.
        let mut filter = spindle(rpm * (1.0 + off));
        let left = gain(&mut filter, rpm / 60.0, PERIOD);
        prop_assert!(left < 0.15, "{left}");
    }

    #[test]
    fn a_spindle_that_changes_its_rate_does_not_move_a_standing_signal(
        value in -2e4..2e4_f64, rates in prop::collection::vec(-700.0..700.0_f64, 1..50),
    ) {
        let mut filter = SpindleFilter::new(PERIOD);
        filter.initialize(value);
        for rate in rates {
            filter.tune(rate);
            // The state is driven by changes, and there are none.
            prop_assert_eq!(filter.update(value), value);
        }
    }

    #[test]
    fn a_spindle_that_runs_up_and_down_shows_no_more_than_its_ripple(seconds in 2.0..20.0_f64, top in 20.0..130.0_f64) {
        // 10 kN and a ripple of 1 kN while the rate goes up to `top` rad/s and back to 0.
        let mut filter = SpindleFilter::new(PERIOD);
        filter.initialize(1e4);
        let (mut angle, mut most) = (0.0_f64, 0.0_f64);
        let ticks = (seconds / PERIOD) as u32;
        for k in 0..ticks {
            let share = f64::from(k) / f64::from(ticks);
            let rate = 2.0 * top * share.min(1.0 - share);
            angle += rate * PERIOD;
            filter.tune(rate);
            most = most.max((filter.update(1e4 + 1e3 * angle.sin()) - 1e4).abs());
        }
        // What of the line is not filtered below 2 Hz, and what rings while a notch is retuned.
        prop_assert!(most < 1.25e3, "{most} N");
    }
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn no_sequence_of_rates_makes_it_ring_up(
        steps in prop::collection::vec((-700.0..700.0_f64, -1.0..1.0_f64), 200..400),
    ) {
        let mut filter = SpindleFilter::new(PERIOD);
        let mut most = 0.0_f64;
        for (rate, sample) in steps {
            filter.tune(rate);
            most = most.max(filter.update(sample).abs());
        }
        // A change of at most 2 a sample into a state that shrinks by r: 2/(1 − r) at the 2 Hz of
        // the slowest notch, 90 periods, is a bound; a random rate stays far below it.
        prop_assert!(most < 20.0, "{most}");
    }
}

#[test]
fn a_rate_or_a_sample_that_is_none_leaves_no_trace() {
    for rate in [f64::NAN, f64::INFINITY, 1e300, -1e300, 0.0] {
        let mut filter = spindle(600.0);
        filter.tune(rate);
        assert_eq!(filter.update(1e4), 1e4, "{rate}");
    }
    let (mut filter, mut other) = (spindle(600.0), spindle(600.0));
    for filter in [&mut filter, &mut other] {
        filter.initialize(1e4);
    }
    for bad in [f64::NAN, f64::INFINITY] {
        filter.update(bad);
    }
    assert_eq!(filter.update(9e3), other.update(9e3));
}
