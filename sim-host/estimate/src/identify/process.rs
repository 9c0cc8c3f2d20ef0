//! The three-axis visco-elastic process with its ripple, from the forces of welds.
//!
//! Depth stiffness and damping, drag, lateral damping, stiffness and memory, and the transversal ratio
//! are free without a prior. So are, for every order of the spindle that the sampling tells apart, the
//! parts of the ripple in step with sine and cosine, axial and in the plane: the orders that a process
//! has are those whose amplitude stands out of its own interval. The robot's stiffness, through which a
//! weld's pose follows from its force, is free beside them.
//!
//! What tells what: the steady part drag, ratio and ripple; the rise of the push depth stiffness and
//! damping; a feed that changes and a tool that leaves its line the lateral terms.

use crate::identify::coordinates::{FreeCoordinate, PROCESS_COORDINATES, RIPPLE};
use crate::identify::fit::IdentificationFit;
use crate::identify::number::{Number, TWO_SIDED};
use crate::predict::{ComparedQuantity, PreparedLog, filled_vectors};
use nalgebra::{Complex, Matrix2, Vector2, Vector3};
use trueweld_logs::log::Log;
use trueweld_plant::input::{Process, Ripple};

/// Amplitude over its standard deviation from which on an order counts: one of twelve amplitudes
/// passes it by chance once in a hundred times (Rayleigh: exp(−x²/2)).
const RIPPLE_SIGNIFICANCE: f64 = 3.8;

/// Difference of two phases, in standard deviations, up to which they are one.
const ONE_PHASE: f64 = 3.0;

/// Residuals of one part of a weld.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Name of the log.
    pub log: String,
    /// Which part.
    pub part: WeldPart,
    /// Time that it lasts, s.
    pub lasts: f64,
    /// √mean((residual/noise)²) of the forces in it.
    pub score: f64,
    /// Values compared in it.
    pub samples: usize,
}

/// Part of a weld by what the tool does in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WeldPart {
    /// The tool hardly moves along the seam: the push rises or falls.
    Standing,
    /// The feed changes.
    FeedChange,
    /// The feed is even.
    Steady,
}

/// One order of the ripple, in one direction.
#[derive(Debug, Clone, Copy)]
struct RippleOrder {
    amplitude: f64,
    amplitude_deviation: f64,
    phase: f64,
    phase_deviation: f64,
}

impl RippleOrder {
    /// From what is in step with sine and cosine, with its covariance.
    fn of(part: Complex<f64>, covariance: &Matrix2<f64>) -> Self {
        let (amplitude, phase) = part.to_polar();
        let (sine, cosine) = phase.sin_cos();
        let deviation = |u: Vector2<f64>| u.dot(&(covariance * u)).max(0.0).sqrt();
        Self {
            amplitude,
            amplitude_deviation: deviation(Vector2::new(cosine, sine)),
            phase,
            phase_deviation: deviation(Vector2::new(-sine, cosine)) / amplitude,
        }
    }

    fn is_significant(&self) -> bool {
        self.amplitude > RIPPLE_SIGNIFICANCE * self.amplitude_deviation
    }
}

/// Numbers to ask for: those of the process, and the ripple at these orders.
pub(crate) fn asked(orders: &[f64]) -> Vec<FreeCoordinate> {
    let parts = |order: &f64| RIPPLE.each_ref().map(|part| FreeCoordinate::of_order(part, *order));
    PROCESS_COORDINATES
        .iter()
        .map(FreeCoordinate::of_cell)
        .chain(orders.iter().flat_map(parts))
        .collect()
}

/// Orders of the spindle at which forces are compared.
pub(crate) fn orders(experiments: &[PreparedLog]) -> Vec<f64> {
    let mut orders: Vec<u8> = Vec::new();
    for compared in experiments.iter().flat_map(|e| &e.compared) {
        match compared.quantity {
            ComparedQuantity::Ripple { order, .. } if !orders.contains(&order) => {
                orders.push(order)
            }
            _ => {}
        }
    }
    orders.sort_unstable();
    orders.into_iter().map(f64::from).collect()
}

/// The ripple that was found: numbers to tell, and entries of the file. `first`: where its parts begin
/// among the numbers asked for.
pub(crate) fn ripple(
    fit: &IdentificationFit,
    orders: &[f64],
    first: usize,
) -> (Vec<Number>, Vec<Ripple>) {
    let (mut numbers, mut file) = (Vec::new(), Vec::new());
    let Some(process) = &fit.model.process else { return (numbers, file) };
    // Of an order that the logs do not show the file says what it said.
    file.extend(process.ripple.iter().filter(|line| !orders.contains(&line.order)).cloned());
    for (k, order) in orders.iter().enumerate() {
        let own = || process.ripple.iter().filter(|line| line.order == *order);
        let whole = |amplitude: fn(&Ripple) -> f64| -> Complex<f64> {
            own().map(|line| Complex::from_polar(amplitude(line), line.phase)).sum()
        };
        let at = first + 4 * k;
        let covariance =
            |from: usize| fit.covariance.fixed_view::<2, 2>(at + from, at + from).into_owned();
        let axial = RippleOrder::of(whole(|line| line.axial), &covariance(0));
        let in_plane = RippleOrder::of(whole(|line| line.in_plane), &covariance(2));
        if !axial.is_significant() && !in_plane.is_significant() {
            continue;
        }
        for (name, line) in [("axial", &axial), ("in_plane", &in_plane)] {
            let name = format!("ripple.{name}");
            let phase_name = format!("{name}.phase_rad");
            let amplitude = [line.amplitude, line.amplitude_deviation];
            numbers.push(ripple_number(name, *order, amplitude, "1"));
            if line.is_significant() {
                let phase = [line.phase, line.phase_deviation];
                numbers.push(ripple_number(phase_name, *order, phase, "rad"));
            }
        }
        let apart = {
            let (sine, cosine) = (axial.phase - in_plane.phase).sin_cos();
            sine.atan2(cosine)
        };
        let entry = |axial: f64, in_plane: f64, phase: f64| Ripple {
            order: *order,
            axial,
            in_plane,
            phase,
        };
        let deviation = axial.phase_deviation.hypot(in_plane.phase_deviation);
        if axial.is_significant()
            && in_plane.is_significant()
            && apart.abs() > ONE_PHASE * deviation
        {
            file.push(entry(axial.amplitude, 0.0, axial.phase));
            file.push(entry(0.0, in_plane.amplitude, in_plane.phase));
        } else {
            // One phase, each weighed by what it is known to; what does not stand out has its
            // component there.
            let [a, b] = [&axial, &in_plane].map(|line| line.phase_deviation.powi(-2));
            let phase = in_plane.phase + apart * a / (a + b);
            let along = |line: &RippleOrder| line.amplitude * (line.phase - phase).cos();
            file.push(entry(along(&axial), along(&in_plane), phase));
        }
    }
    (numbers, file)
}

/// A number of one order of the ripple, from a value and its deviation.
fn ripple_number(
    name: String,
    order: f64,
    [value, deviation]: [f64; 2],
    unit: &'static str,
) -> Number {
    let half = TWO_SIDED * deviation;
    Number {
        name,
        at: format!("order {order}"),
        value,
        interval: half.is_finite().then_some([value - half, value + half]),
        given: f64::NAN,
        unit,
    }
}

/// What a process had of a number that stands for an order of its ripple; NaN where it had none.
pub(crate) fn given(process: &Process, number: &Number) -> f64 {
    let order = number.at.strip_prefix("order ").and_then(|order| order.parse::<f64>().ok());
    let own = process.ripple.iter().filter(|line| Some(line.order) == order);
    let parts: Complex<f64> = own
        .map(|line| {
            let of_axial = number.name.starts_with("ripple.axial");
            let amplitude = if of_axial { line.axial } else { line.in_plane };
            Complex::from_polar(amplitude, line.phase)
        })
        .sum();
    match (parts.norm(), number.unit) {
        (0.0, "rad") => f64::NAN,
        (_, "rad") => parts.arg(),
        (amplitude, _) => amplitude,
    }
}

/// Half of the time over which the speed along the seam is taken, s.
const FEED_HALF_WINDOW: f64 = 0.4;

/// Shares of the feed: below the first a tool stands, and where it changes by less than the second from
/// one half to the other the feed is even.
const STANDING_FEED_SHARE: f64 = 0.15;
const EVEN_FEED_CHANGE: f64 = 0.07;

/// Scores of the parts of every weld.
pub(crate) fn sections(fit: &IdentificationFit) -> Vec<Section> {
    let mut sections = Vec::new();
    for (k, (log, experiment)) in fit.logs.iter().zip(&fit.problem.logs).enumerate() {
        let Some(parts) = parts(log) else { continue };
        for part in [WeldPart::Standing, WeldPart::FeedChange, WeldPart::Steady] {
            let rows: Vec<usize> = (0..parts.len()).filter(|r| parts[*r] == part).collect();
            let (mut squares, mut samples) = (0.0, 0);
            for (compared, residual) in
                experiment.compared.iter().zip(&fit.fitted.residuals[k].residual)
            {
                let force = matches!(
                    compared.quantity,
                    ComparedQuantity::Force | ComparedQuantity::Ripple { .. }
                );
                if force && parts[compared.row] == part {
                    squares += residual * residual;
                    samples += 1;
                }
            }
            if samples > 0 {
                sections.push(Section {
                    log: log.name.clone(),
                    part,
                    lasts: rows.len() as f64 * experiment.period,
                    score: (squares / f64::from(samples)).sqrt(),
                    samples: samples as usize,
                });
            }
        }
    }
    sections
}

/// The part of the weld that every row is in, by the tracker; `None` without one.
fn parts(log: &Log) -> Option<Vec<WeldPart>> {
    let weld = log.weld.as_ref()?;
    let position = filled_vectors(&log.samples.position)?;
    let time = &log.samples.time;
    let n = time.len();
    let step = (time[n - 1] - time[0]) / (n - 1).max(1) as f64;
    let half = ((FEED_HALF_WINDOW / step) as usize).max(1);
    let speed = |from: usize, to: usize| {
        let moved = Vector3::from_fn(|c, _| position[c][to] - position[c][from]);
        moved.norm() / (time[to] - time[from]).max(step)
    };
    let mut parts = Vec::with_capacity(n);
    for k in 0..n {
        let (from, to) = (k.saturating_sub(half), (k + half).min(n - 1));
        let change = speed(k.min(to - 1), to) - speed(from, k.max(from + 1));
        parts.push(if speed(from, to) < STANDING_FEED_SHARE * weld.feed {
            WeldPart::Standing
        } else if change.abs() < EVEN_FEED_CHANGE * weld.feed {
            WeldPart::Steady
        } else {
            WeldPart::FeedChange
        });
    }
    Some(parts)
}
