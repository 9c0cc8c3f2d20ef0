//! A weld as the text of its file.

use nalgebra::Vector3;
use std::fmt::Write as _;
use trueweld_plant::input::{RealSeam, Weld};
use trueweld_plant::simulate::Seam;

/// Longest way between two points of a curved seam, m, and most pieces of it: a spline through points
/// so close is the seam to a micrometre.
const SPACING: f64 = 0.01;
const MOST_PIECES: usize = 500;

/// Text of a weld's file: `weld/1` where that holds all of it.
pub fn weld_file(weld: &Weld) -> String {
    let held = match weld.force {
        0.0 => "held = \"position\"\n".to_owned(),
        force => format!("force_n = {force:?}\nforce_ramp_s = {:?}\n", weld.force_ramp),
    };
    let rest = format!(
        "feed_m_s = {:?}\nfeed_ramp_s = {:?}\n{held}initial_depth_m = {:?}\nsettle_s = {:?}\n",
        weld.feed, weld.feed_ramp, weld.initial_depth, weld.settle
    );
    let of_first_format = weld.path.is_none()
        && weld.lean == [0.0; 2]
        && [weld.dwell, weld.run_out] == [0.0; 2]
        && weld.feeds.is_empty()
        && weld.real == RealSeam::as_taught();
    if of_first_format {
        let [start, end, axis] = [&weld.start, &weld.end, &weld.tool_axis].map(list);
        return format!(
            "schema = \"weld/1\"\nstart_m = {start}\nend_m = {end}\ntool_axis = {axis}\n{rest}"
        );
    }
    let [lead, tilt] = weld.lean.map(f64::to_degrees);
    let mut text = format!(
        "schema = \"weld/2\"\njoined = \"spline\"\n{rest}lead_deg = {lead:?}\ntilt_deg = {tilt:?}\ndwell_s = {:?}\nrun_out_m = {:?}\n",
        weld.dwell, weld.run_out
    );
    for (from, feed) in &weld.feeds {
        let _ = write!(text, "\n[[feed]]\nfrom_m = {from:?}\nfeed_m_s = {feed:?}\n");
    }
    if weld.real != RealSeam::as_taught() {
        let (shift, turn) = (&weld.real.by.linear, &weld.real.by.angular);
        text += "\n[real_seam]\n";
        for (axis, (m, rad)) in ["x", "y", "z"].iter().zip(shift.iter().zip(turn)) {
            let _ = write!(text, "shift_{axis}_m = {m:?}\nturn_{axis}_rad = {rad:?}\n");
        }
        if let Some(wave) = weld.real.wave {
            let _ = write!(
                text,
                "wave_m = {:?}\nwave_length_m = {:?}\nwave_phase_rad = {:?}\n",
                wave.amplitude, wave.length, wave.phase
            );
        }
    }
    let seam = Seam::of(weld);
    let pieces = match seam.is_straight() {
        true => 1,
        false => ((seam.length / SPACING).ceil() as usize).clamp(2, MOST_PIECES),
    };
    for k in 0..=pieces {
        let frame = seam.frame(seam.length * k as f64 / pieces as f64);
        let normal: Vector3<f64> = -frame.rotation.column(2);
        let [at, normal] = [&frame.position, &normal].map(list);
        let _ = write!(text, "\n[[point]]\nat_m = {at}\nnormal = {normal}\n");
    }
    text
}

fn list(v: &Vector3<f64>) -> String {
    format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trueweld_plant::input::InputFile;

    #[test]
    fn a_weld_is_read_again_as_it_was_written() {
        let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/welds");
        let mut curved = 0;
        for file in std::fs::read_dir(fixtures).unwrap() {
            let path = file.unwrap().path();
            let weld = Weld::parse(&std::fs::read_to_string(&path).unwrap(), "a weld").unwrap();
            let again = Weld::parse(&weld_file(&weld), "again").expect("its text is a weld");
            for (was, is) in [Seam::of, Seam::real].map(|seam| (seam(&weld), seam(&again))) {
                assert!((was.length - is.length).abs() < 1e-6, "{}", path.display());
                for k in 0..=50 {
                    let at = was.length * f64::from(k) / 50.0;
                    let off = was.frame(at).error_to(&is.frame(at));
                    let far = off.linear.norm().max(0.1 * off.angular.norm());
                    assert!(far < 2e-6, "{} at {at}: {off:?}", path.display());
                }
                curved += usize::from(!was.is_straight());
            }
            assert_eq!(without_seam(&weld), without_seam(&again), "{}", path.display());
        }
        assert!(curved > 2);
    }

    /// All of a weld but where its seam lies.
    fn without_seam(weld: &Weld) -> Weld {
        Weld {
            start: Vector3::zeros(),
            end: Vector3::zeros(),
            tool_axis: Vector3::zeros(),
            path: None,
            lean: weld.lean.map(|v| (v * 1e12).round()),
            ..weld.clone()
        }
    }
}
