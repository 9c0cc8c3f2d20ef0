//! A progress bar for people at a terminal, which says at the start how long it will take, and again
//! where it takes longer; nothing at all for everybody else. A program around this one may listen
//! instead.

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// What is told of some work: what is done now, and the share of the whole that is done.
pub type ProgressListener = Arc<dyn Fn(&str, f64) + Send + Sync>;

/// How far some work is. Drawn on standard error where that is a terminal, else silent.
pub struct Progress {
    bar: ProgressBar,
    start: Instant,
    /// Units of the total that were counted one by one.
    counted: AtomicUsize,
    /// Longest time that was said, s.
    told: Mutex<Option<f64>>,
    listener: Option<ProgressListener>,
}

impl fmt::Debug for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { bar, start, told, .. } = self;
        f.debug_struct("Progress")
            .field("bar", bar)
            .field("start", start)
            .field("told", told)
            .finish_non_exhaustive()
    }
}

/// Positions of the bar a unit of the total.
const STEPS_PER_UNIT: f64 = 100.0;

/// Share of the work from which on its duration is known well enough to be said.
const KNOWN_FROM: f64 = 0.03;

/// Shortest time that is worth saying, s.
const WORTH_SAYING: f64 = 2.0;

/// Shares of what the work so far makes expect, between which the whole will take.
const EXPECTED_SHARE_MIN: f64 = 0.7;
const EXPECTED_SHARE_MAX: f64 = 1.5;

impl Progress {
    /// A bar named `label` for a `total` in seconds of simulated time, or in pieces of equal work.
    pub fn new(label: &str, total: f64) -> Self {
        Self::drawn_on(ProgressDrawTarget::stderr(), label, total)
    }

    /// No bar: for quiet commands.
    pub fn silent() -> Self {
        Self::drawn_on(ProgressDrawTarget::hidden(), "", 1.0)
    }

    /// No bar: a program around this one is told instead, from whatever thread works.
    pub fn heard(label: &str, total: f64, listener: ProgressListener) -> Self {
        let silent = Self::drawn_on(ProgressDrawTarget::hidden(), label, total);
        Self { listener: Some(listener), ..silent }
    }

    fn drawn_on(target: ProgressDrawTarget, label: &str, total: f64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps(total)), target);
        let style = ProgressStyle::with_template("{msg:>14} {bar:32} {percent:>3} %  {left}")
            .expect("the template is well-formed")
            .with_key("left", |state: &ProgressState, line: &mut dyn fmt::Write| {
                if f64::from(state.fraction()) >= KNOWN_FROM {
                    // A line that cannot be written is not shown.
                    let _ = write!(line, "{} left", HumanDuration(state.eta()));
                }
            });
        bar.set_style(style.progress_chars("━╸─"));
        bar.set_message(label.to_owned());
        let (start, counted, told) = (Instant::now(), AtomicUsize::new(0), Mutex::new(None));
        Self { bar, start, counted, told, listener: None }
    }

    /// The same, to count from what was done before.
    pub fn counting_from(self, done: usize) -> Self {
        Self { counted: done.into(), ..self }
    }

    /// So many units more of the total are done, on whatever thread.
    pub fn advance_by(&self, more: usize) {
        self.advance_to((self.counted.fetch_add(more, Ordering::Relaxed) + more) as f64);
    }

    /// The work has come to `done` of the total.
    pub fn advance_to(&self, done: f64) {
        if let Some(listener) = &self.listener {
            let total = self.bar.length().unwrap_or(0).max(1) as f64;
            return listener(&self.bar.message(), (done * STEPS_PER_UNIT / total).min(1.0));
        }
        self.bar.set_position(steps(done));
        let total = self.bar.length().unwrap_or(0).max(1) as f64;
        self.tell(self.bar.position() as f64 / total);
    }

    /// The work has come to a `share` of the whole, and is at `what` now.
    pub fn stage(&self, what: &str, share: f64) {
        if let Some(listener) = &self.listener {
            return listener(what, share);
        }
        self.bar.set_message(what.to_owned());
        self.bar
            .set_position((share.clamp(0.0, 1.0) * self.bar.length().unwrap_or(0) as f64) as u64);
        self.tell(share);
    }

    /// Says, as soon as it can be known, how long the whole will take, and again where it takes
    /// longer than was said.
    fn tell(&self, share: f64) {
        let so_far = self.start.elapsed().as_secs_f64();
        let all = so_far / share;
        let again = match *self.told.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(said) => so_far > said || (share > 0.5 && all > said),
            None => share >= KNOWN_FROM,
        };
        if again {
            self.expect((EXPECTED_SHARE_MIN * all).max(so_far), EXPECTED_SHARE_MAX * all);
        }
    }

    /// Says that the whole will take from `least` to `most` seconds.
    pub fn expect(&self, least: f64, most: f64) {
        *self.told.lock().unwrap_or_else(PoisonError::into_inner) = Some(most);
        if let Some(said) = duration(least, most) {
            // Goes nowhere but to a terminal.
            self.bar.println(said);
        }
    }

    /// The work is over: takes the bar away.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

/// What is said of a duration between two, in seconds; nothing of a short one.
fn duration(least: f64, most: f64) -> Option<String> {
    let (second, unit) = match most {
        s if s.is_nan() || s < WORTH_SAYING => return None,
        s if s < 120.0 => (1.0, "s"),
        s if s < 7200.0 => (60.0, "min"),
        _ => (3600.0, "h"),
    };
    let [least, most] = [least, most].map(|s| format!("{:.0}", (s / second).max(1.0)));
    if least == most {
        return Some(format!("This takes about {most} {unit}."));
    }
    Some(format!("This takes {least} to {most} {unit}."))
}

fn steps(units: f64) -> u64 {
    (units.max(0.0) * STEPS_PER_UNIT) as u64
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

    #[test]
    fn a_duration_is_said_in_the_unit_that_people_use() {
        let said = |least: f64, most: f64| duration(least, most).unwrap_or_default();
        assert_eq!(said(1.0, 1.9), "");
        assert_eq!(said(f64::NAN, f64::NAN), "");
        assert_eq!(said(0.2, 3.0), "This takes 1 to 3 s.");
        assert_eq!(said(30.2, 42.3), "This takes 30 to 42 s.");
        assert_eq!(said(220.0, 250.0), "This takes about 4 min.");
        assert_eq!(said(5000.0, 9000.0), "This takes 1 to 2 h.");
    }

    #[test]
    fn what_takes_longer_than_was_said_is_said_again() {
        let progress = Progress::drawn_on(ProgressDrawTarget::hidden(), "fitting", 1.0);
        let told = || progress.told.lock().unwrap().unwrap_or_default();
        progress.expect(0.0, 1e-9);
        progress.stage("fitting", 0.1);
        assert!(told() > 1e-9, "{}", told());
        progress.expect(10.0, 20.0);
        progress.stage("fitting", 0.5);
        assert_eq!(told(), 20.0);
        progress.finish();
    }
}
