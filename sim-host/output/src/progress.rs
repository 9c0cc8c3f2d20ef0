//! A progress bar for people at a terminal; nothing at all for everybody else.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// How far a simulation is, in simulated seconds. Drawn on standard error where that is a terminal,
/// else silent.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

/// Positions of the bar a simulated second.
const STEPS_PER_SECOND: f64 = 100.0;

impl Progress {
    /// A bar named `label` for `total_seconds` of simulated time.
    pub fn new(label: &str, total_seconds: f64) -> Self {
        Self::drawn_on(ProgressDrawTarget::stderr(), label, total_seconds)
    }

    /// No bar: for quiet commands.
    pub fn silent() -> Self {
        Self { bar: ProgressBar::hidden() }
    }

    fn drawn_on(target: ProgressDrawTarget, label: &str, total_seconds: f64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps(total_seconds)), target);
        let style = ProgressStyle::with_template("{msg:>14} {bar:32} {percent:>3} %  {eta} left")
            .expect("the template is well-formed");
        bar.set_style(style.progress_chars("━╸─"));
        bar.set_message(label.to_owned());
        Self { bar }
    }

    /// The simulation has come to `seconds`.
    pub fn advance_to(&self, seconds: f64) {
        self.bar.set_position(steps(seconds));
    }

    /// Work that is no simulation has come to a `share` of the whole, and is at `what` now.
    pub fn stage(&self, what: &str, share: f64) {
        self.bar.set_message(what.to_owned());
        self.bar
            .set_position((share.clamp(0.0, 1.0) * self.bar.length().unwrap_or(0) as f64) as u64);
    }

    /// The simulation is over: takes the bar away.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

fn steps(seconds: f64) -> u64 {
    (seconds.max(0.0) * STEPS_PER_SECOND) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_counts_simulated_time_and_stays_within_it() {
        let progress = Progress::drawn_on(ProgressDrawTarget::hidden(), "elastostatic", 200.0);
        progress.advance_to(100.0);
        assert_eq!(2 * progress.bar.position(), progress.bar.length().unwrap());
        progress.advance_to(-1.0);
        assert_eq!(progress.bar.position(), 0);
        progress.finish();
    }

    #[test]
    fn silent_draws_nothing() {
        let progress = Progress::silent();
        progress.advance_to(1.0);
        assert!(progress.bar.is_hidden());
        progress.finish();
    }
}
