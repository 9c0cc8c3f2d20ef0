//! The force at the spindle's orders, with the loop closed through the arm's dynamic compliance.
//!
//! At these orders the tool gives way to its own ripple by micrometres, which no tracker sees and
//! which take away most of the force. With θₙ the encoders' amplitude at order n, and Z = k + iωb of
//! the contact, in W:
//!
//! ```text
//! δx = G θₙ + C δF,   δF = Fₙ + Nₙ − Z δx   →   (1 + Z C) δF = Fₙ + Nₙ − Z G θₙ
//! H = (K + iωD − ω²M)⁻¹,   G = J H (K + iωD),   C = J H Jᵀ
//! ```
//!
//! Fₙ is the ripple of the force on a tool that does not shake. Nₙ is of second order, ripple times
//! shake and shake times shake: at 10 Hz drag follows the tool's speed and the ripple turns, and both
//! together make a line at 20 Hz. Where arm and motors take away most of a line that is what is left.
//!
//! The two parts of δF, what the ripple makes and what the motors' motion makes, are often far larger
//! than their sum. An arm whose C is off by a share ε leaves ε (1 − (1 + Z C)⁻¹) δF in it, one whose
//! G is leaves ε (1 + Z C)⁻¹ Z G θₙ, and one whose inertia is off, which changes both, the difference:
//! the larger one counts as noise.
//!
//! A gear with friction under load moves by far less than its loop there, and is the stiffer for it,
//! often several times: (1 + Z C)⁻¹ and G are taken anew with what its memory adds to K.
//!
//! Of what the encoders show at an order part is their noise, and the contact makes hundreds of newtons
//! of it. It is in the residual whatever the model; were it predicted with the rest, any effect that
//! makes the predicted force smaller would make it smaller too, and seem to improve the model. So only
//! the likeliest amplitude given the reading (Wiener: the share of its mean square that noise does not
//! make) goes through the effects, and the rest as the nominal contact has it.

use super::super::instruments::{sensed, unread};
use super::super::{BaselineModel, Compared, ComparedQuantity};
use super::tool::{LoadedTool, RecordedWeld};
use crate::predict::wiener::signal_share;
use nalgebra::{Complex, Matrix3, Matrix3x6, Matrix6, SVector, Vector3};
use std::borrow::Cow;
use std::f64::consts::TAU;
use trueweld_core::{JointVector, Robot};
use trueweld_logs::fir::dot;
use trueweld_logs::noise::NoiseLevel;
use trueweld_plant::input::Process;
use trueweld_plant::process::reaction;
use trueweld_plant::robot::{Channel, ElasticRobot, Ports, Readings};

/// Orders of the spindle at which the force is compared, as far as the sampling tells them apart.
const COMPARED_ORDERS: usize = 6;

/// Share of a line that may be lost where readings are filled.
const FILLED_LINE_LOSS_MAX: f64 = 0.03;

/// How far apart two lines must lie for the filter to tell them apart, in widths of its band.
const LINE_SEPARATION_MIN: f64 = 2.0;

/// Share to which the arm's compliance at the spindle's orders is known: its effects change it, and
/// its motors.
const COMPLIANCE_KNOWN: f64 = 0.5;

/// Phases of a turn at which the force on a shaken tool is taken: products of three orders do not
/// fold onto a lower one.
const TURN_PHASES: usize = 32;

/// Fall of the sum of squares from which on the lines tell another angle of the spindle than the
/// format's 0 at the first row: that of a calibration of one value that is kept.
const SPINDLE_ANGLE_FALL_MIN: f64 = 31.0;

/// The spindle's lines in the force of a weld.
#[derive(Debug, Clone)]
pub(super) struct SpindleHarmonics {
    encoder: Vec<JointVector<f64>>,
    /// Twice the cosine and the sine of the spindle's angle, times each order.
    waves: Vec<[Vec<f64>; 2]>,
    /// exp(iφ) at even parts of a turn.
    phases: [Complex<f64>; TURN_PHASES],
    /// How the tool shakes at the spindle's orders, beside what the tracker sees: position and
    /// velocity at every row, in W.
    shake: Vec<[Vector3<f64>; 2]>,
    /// What the arm makes of the ripple, for every compared row and order.
    loops: Vec<[Closed; COMPARED_ORDERS]>,
    /// Orders whose lines, folded by the sampling where they lie beyond half its rate, fall on no
    /// lower one.
    orders: Vec<usize>,
    /// Those of them that the force is read often enough for.
    read: Vec<usize>,
    /// How far beside a line, in orders, the filter lets nothing of it through.
    aside: f64,
    /// What was measured at these orders, as it is compared.
    measured: Vec<f64>,
    /// The nominal arm and process.
    arm: Robot<f64>,
    process: Process,
    /// Every compared row.
    places: Vec<ShakenRow>,
}

/// What shakes the tool at a compared row, by order.
#[derive(Debug, Clone)]
struct ShakenRow {
    row: usize,
    q: JointVector<f64>,
    /// The tool, carrying the push.
    held: LoadedTool,
    /// Amplitudes of the motors as they were read, and the share of each that noise does not make.
    motors: [SVector<Complex<f64>, 6>; COMPARED_ORDERS],
    shares: [JointVector<f64>; COMPARED_ORDERS],
    /// The ripple of the force on a tool that does not shake and carries the push.
    still: [Vector3<Complex<f64>>; COMPARED_ORDERS],
    /// What the nominal arm makes of it all.
    arm: [ArmAtOrder; COMPARED_ORDERS],
}

/// How an arm moves the tool at an order of the spindle, in W.
#[derive(Debug, Clone, Copy, Default)]
struct ArmAtOrder {
    /// The tool's motion by the motors', and what of that is their noise.
    free: Vector3<Complex<f64>>,
    noise: Vector3<Complex<f64>>,
    /// The tool's motion per force, at the order's frequency and as its samples fold.
    compliance: [Matrix3<Complex<f64>>; 2],
}

/// How a tool shakes under a model.
pub(super) struct SpindleShake<'s> {
    /// Position and velocity at every row, beside what the tracker sees, in W.
    pub shake: Cow<'s, [[Vector3<f64>; 2]]>,
    /// What the arm makes of the ripple, for every compared row and order.
    loops: Cow<'s, [[Closed; COMPARED_ORDERS]]>,
}

/// Amplitudes of the tool in W, by order: what the ripple makes, and what the motors move.
type Shake = [[Vector3<Complex<f64>>; 2]; COMPARED_ORDERS];

/// (1 + Z C)⁻¹ at one row and order, and what of the force comes with the motors' own motion.
#[derive(Debug, Clone, Copy, Default)]
struct Closed {
    pass: Matrix3<Complex<f64>>,
    driven: Vector3<Complex<f64>>,
    /// What comes with the encoders' noise.
    noise: Vector3<Complex<f64>>,
    /// What comes with ripple and shake together.
    product: Vector3<Complex<f64>>,
    /// Deviation that the arm's compliance leaves in the line, N.
    arm: Vector3<f64>,
}

/// How an arm moves its tool at one angular frequency, in W.
struct MovedTool {
    /// The tool's motion per motor's motion.
    carried: Matrix3x6<Complex<f64>>,
    /// The same per force.
    compliance: Matrix3<Complex<f64>>,
}

/// Orders of a spindle that turns so many times from one sample to the next whose lines lie at
/// least `apart`, as a share of the sampling rate, from every lower one's, from what is slow and
/// from their own mirror image.
fn separate_orders(turning: f64, apart: f64) -> Vec<usize> {
    let folded = |orders: usize| {
        let turns = orders as f64 * turning;
        (turns - turns.round()).abs()
    };
    // From -n to n - 1.
    (1..=COMPARED_ORDERS).filter(|n| (1..=2 * n).all(|away| folded(away) >= apart)).collect()
}

impl SpindleHarmonics {
    /// Closes the loop of contact and arm at every compared row, and shakes the tool with what
    /// comes of it. `encoder`: readings and their noise; `turning`: turns of the spindle a second;
    /// `band`, Hz, of the slow force.
    pub(crate) fn new(
        weld: &RecordedWeld,
        (encoder, level): (&[JointVector<f64>], &[NoiseLevel]),
        model: &BaselineModel,
        turning: f64,
        band: f64,
    ) -> Self {
        let wave = |n: usize, f: fn(f64) -> f64| {
            weld.angle.iter().map(|a| 2.0 * f(n as f64 * a)).collect::<Vec<f64>>()
        };
        let orders =
            separate_orders(turning * weld.period, LINE_SEPARATION_MIN * band * weld.period);
        // Straight lines between every nth of rows that are T apart lose (π f T)² (n² − 1)/3 of a slow
        // wave of frequency f.
        let lost = |order: usize| {
            let phase = std::f64::consts::PI * order as f64 * turning * weld.period;
            phase.powi(2) * (weld.rows_a_force.powi(2) - 1.0) / 3.0
        };
        let mut lines = Self {
            encoder: encoder.to_vec(),
            phases: std::array::from_fn(|k| {
                Complex::from_polar(1.0, k as f64 * TAU / TURN_PHASES as f64)
            }),
            waves: (1..=COMPARED_ORDERS).map(|n| [wave(n, f64::cos), wave(n, f64::sin)]).collect(),
            shake: vec![[Vector3::zeros(); 2]; encoder.len()],
            loops: Vec::new(),
            read: orders
                .iter()
                .copied()
                .filter(|order| lost(*order) <= FILLED_LINE_LOSS_MAX)
                .collect(),
            orders,
            aside: LINE_SEPARATION_MIN * band / turning,
            measured: Vec::new(),
            arm: model.robot.clone(),
            process: weld.process(model),
            places: Vec::new(),
        };
        lines.close(weld, level);
        lines
    }

    fn close(&mut self, weld: &RecordedWeld, level: &[NoiseLevel]) {
        self.places = self.placed(weld, level);
        let nominal = (&self.process, &Ports::default());
        let closed = |place: &ShakenRow| {
            self.closed(weld, nominal, (place.row, &place.arm), &place.held, &place.still)
        };
        let (loops, amplitude): (Vec<_>, Vec<_>) = self.places.iter().map(closed).unzip();
        self.loops = loops;
        self.shake = self.shaking(weld, &amplitude);
    }

    /// Position and velocity, in W, at every row, of a tool that shakes with these amplitudes at the
    /// compared ones.
    fn shaking(&self, weld: &RecordedWeld, amplitude: &[Shake]) -> Vec<[Vector3<f64>; 2]> {
        // Before the first row and after the last one it shakes as it does there: what is slow
        // there reaches that far.
        let at = |row: usize| {
            let after = weld.rows.partition_point(|r| *r <= row).min(weld.rows.len() - 1);
            let before = after.saturating_sub(1);
            let span = (weld.rows[after] - weld.rows[before]).max(1) as f64;
            let share = ((row as f64 - weld.rows[before] as f64) / span).clamp(0.0, 1.0);
            let between: Shake = std::array::from_fn(|n| {
                std::array::from_fn(|part| {
                    amplitude[before][n][part]
                        .zip_map(&amplitude[after][n][part], |a, b| a * (1.0 - share) + b * share)
                })
            });
            self.moved(weld, &between, |order| self.wave(order, row))
        };
        (0..weld.angle.len()).map(at).collect()
    }

    /// How the tool shakes under a model, and its loops, where `still` is the force on a tool that does not,
    /// in W.
    pub(crate) fn under<'s>(
        &'s self,
        weld: &RecordedWeld,
        robot: &ElasticRobot,
        process: &Process,
        still: &[Vector3<f64>],
    ) -> SpindleShake<'s> {
        let still = weld.quick_vectors(&carried(weld, process, still));
        let of_place = |place: &ShakenRow| self.amplitudes(weld, &self.orders, place.row, &still);
        let still: Vec<_> = self.places.iter().map(of_place).collect();
        let stiffer = stiffer(&self.arm, robot);
        if stiffer.is_none() && self.places.iter().zip(&still).all(|(p, still)| p.still == *still) {
            return SpindleShake { shake: Cow::from(&self.shake), loops: Cow::from(&self.loops) };
        }
        let closed = |(place, still): (&ShakenRow, &[Vector3<Complex<f64>>; COMPARED_ORDERS])| {
            let arm = stiffer.as_ref().map_or(place.arm, |arm| {
                self.arm_at(weld, arm, (place.row, &place.q), (&place.motors, &place.shares))
            });
            let held = weld.held(process, place.row);
            self.closed(weld, (process, &robot.ports), (place.row, &arm), &held, still)
        };
        let (loops, amplitude): (Vec<_>, Vec<_>) =
            self.places.iter().zip(&still).map(closed).unzip();
        SpindleShake { shake: Cow::from(self.shaking(weld, &amplitude)), loops: Cow::from(loops) }
    }

    /// What shakes the tool at every compared row.
    fn placed(&self, weld: &RecordedWeld, level: &[NoiseLevel]) -> Vec<ShakenRow> {
        let encoder: Vec<Vec<f64>> =
            (0..6).map(|i| self.encoder.iter().map(|q| q[i]).collect()).collect();
        let smooth: Vec<Vec<f64>> = encoder.iter().map(|e| weld.low.smooth(0, e)).collect();
        let shaking: Vec<Vec<f64>> = encoder
            .iter()
            .zip(&smooth)
            .map(|(e, s)| e.iter().zip(s).map(|(a, b)| a - b).collect())
            .collect();
        // By order and row.
        let mut motors =
            vec![vec![SVector::<Complex<f64>, 6>::zeros(); weld.rows.len()]; COMPARED_ORDERS];
        let mut shares = [JointVector::zeros(); COMPARED_ORDERS];
        for order in self.orders.clone() {
            let motors = &mut motors[order - 1];
            for (motor, &row) in motors.iter_mut().zip(&weld.rows) {
                *motor =
                    SVector::from_fn(|i, _| self.amplitude_of(weld, order, row, |k| shaking[i][k]));
            }
            shares[order - 1] = trusted(motors, level, 2.0 * weld.low.gain(0));
        }
        let force = weld.forces(&self.process, &Ports::default(), &weld.motion, None);
        let force = weld.quick_vectors(&carried(weld, &self.process, &force));
        let mut places = Vec::with_capacity(weld.rows.len());
        for (k, &row) in weld.rows.iter().enumerate() {
            let still = self.amplitudes(weld, &self.orders, row, &force);
            let q = JointVector::from_fn(|i, _| smooth[i][row]);
            let motors = std::array::from_fn(|n| motors[n][k]);
            let arm = self.arm_at(weld, &self.arm, (row, &q), (&motors, &shares));
            let held = weld.held(&self.process, row);
            places.push(ShakenRow { row, q, held, motors, shares, still, arm });
        }
        places
    }

    /// What an arm with its links at `q` makes of the motors' amplitudes at a row, of which noise does
    /// not make these shares.
    fn arm_at(
        &self,
        weld: &RecordedWeld,
        arm: &Robot<f64>,
        (row, q): (usize, &JointVector<f64>),
        (motors, shares): (
            &[SVector<Complex<f64>, 6>; COMPARED_ORDERS],
            &[JointVector<f64>; COMPARED_ORDERS],
        ),
    ) -> [ArmAtOrder; COMPARED_ORDERS] {
        let mut at = [ArmAtOrder::default(); COMPARED_ORDERS];
        for n in self.orders.iter().map(|order| order - 1) {
            let [fast, slow] = [turning(weld, n + 1), folded(weld, n + 1)]
                .map(|omega| arm_moves(&weld.axes[row], arm, q, omega));
            let noise = motors[n].zip_map(&shares[n], |z, share| z * (1.0 - share));
            at[n] = ArmAtOrder {
                free: slow.carried * motors[n],
                noise: slow.carried * noise,
                compliance: [fast.compliance, slow.compliance],
            };
        }
        at
    }

    /// The loop at a row, closed through an arm and a process, and how the tool shakes there. `held`: the
    /// tool, carrying the push; `still`: the ripple of the force where it does not shake.
    fn closed(
        &self,
        weld: &RecordedWeld,
        (process, ports): (&Process, &Ports),
        (row, arm): (usize, &[ArmAtOrder; COMPARED_ORDERS]),
        held: &LoadedTool,
        still: &[Vector3<Complex<f64>>; COMPARED_ORDERS],
    ) -> ([Closed; COMPARED_ORDERS], Shake) {
        let mut closed = [Closed::default(); COMPARED_ORDERS];
        let mut shake: Shake = [[Vector3::zeros(); 2]; COMPARED_ORDERS];
        let mut contact = [[Matrix3::zeros(); 2]; COMPARED_ORDERS];
        for n in self.orders.iter().map(|order| order - 1) {
            let ArmAtOrder { free, noise, compliance } = arm[n];
            contact[n] = [turning(weld, n + 1), folded(weld, n + 1)]
                .map(|omega| process.slope_at(&held.reaction, omega));
            let [pass, slow_pass] = [0, 1].map(|k| passed(&contact[n][k], &compliance[k]));
            let driven = -(slow_pass * contact[n][1] * free);
            let noise = -(slow_pass * contact[n][1] * noise);
            let ripple = pass * still[n];
            // The ripple shakes the tool, and the motors move it, the contact against them.
            shake[n] = [compliance[0] * ripple, free + compliance[1] * driven];
            // δ(1 + Z C)⁻¹ = −(1 + Z C)⁻¹ Z δC (1 + Z C)⁻¹; what is driven changes as G does.
            let loop_off = ripple - pass * ripple + driven - slow_pass * driven;
            let arm = loop_off.zip_map(&driven, |a, b| COMPLIANCE_KNOWN * a.norm().max(b.norm()));
            let product = Vector3::zeros();
            closed[n] = Closed { pass, driven: driven - noise, noise, product, arm };
        }
        let of_phase = |phase: usize| {
            self.moved(weld, &shake, |order| self.phases[(order * phase) % TURN_PHASES])
        };
        let time = row as f64 * weld.period;
        let beside = self.beside_linear((process, ports), time, held, of_phase);
        for n in self.orders.iter().map(|order| order - 1) {
            let linear = contact[n][0] * shake[n][0] + contact[n][1] * shake[n][1];
            closed[n].product = closed[n].pass * (beside(n + 1) + linear);
        }
        (closed, shake)
    }

    /// exp(i n φ) of an order at a row.
    fn wave(&self, order: usize, row: usize) -> Complex<f64> {
        let [cosine, sine] = &self.waves[order - 1];
        Complex::new(0.5 * cosine[row], 0.5 * sine[row])
    }

    /// Position and velocity, in W, of a tool that shakes with these amplitudes, the orders' waves being
    /// at `wave`: what the ripple makes turns with the spindle, what the motors move as their samples do.
    fn moved(
        &self,
        weld: &RecordedWeld,
        amplitude: &Shake,
        wave: impl Fn(usize) -> Complex<f64>,
    ) -> [Vector3<f64>; 2] {
        let mut shake = [Vector3::zeros(); 2];
        for &order in &self.orders {
            let wave = wave(order);
            let rates = [turning(weld, order), folded(weld, order)];
            for (part, rate) in amplitude[order - 1].iter().zip(rates) {
                shake[0] += part.map(|z| (z * wave).re);
                shake[1] += part.map(|z| (z * wave * Complex::new(0.0, rate)).re);
            }
        }
        shake
    }

    /// Amplitude by order of what the force on a tool that shakes differs by from that on a tool that
    /// does not, in W. `shake`: position and velocity by the part of the spindle's turn.
    fn beside_linear(
        &self,
        (process, ports): (&Process, &Ports),
        time: f64,
        held: &LoadedTool,
        shake: impl Fn(usize) -> [Vector3<f64>; 2],
    ) -> impl Fn(usize) -> Vector3<Complex<f64>> {
        let differences: [Vector3<f64>; TURN_PHASES] = std::array::from_fn(|k| {
            let angle = k as f64 * TAU / TURN_PHASES as f64;
            let [by, at] = shake(k);
            let at = process.vibration_speed(&by, &at);
            let force = |position, velocity| {
                reaction(process, ports, time, &position, &velocity, held.channel, angle).force
            };
            force(held.position + by, held.velocity + at) - force(held.position, held.velocity)
        });
        move |order| {
            let turned = |(k, difference): (usize, &Vector3<f64>)| {
                let wave = self.phases[(order * k) % TURN_PHASES].conj();
                difference.map(|d| wave * d)
            };
            let sum: Vector3<Complex<f64>> = differences.iter().enumerate().map(turned).sum();
            sum * Complex::from(2.0 / TURN_PHASES as f64)
        }
    }

    /// By how much the spindle was ahead of the angles taken for it, rad: where the lines as they are
    /// `compared` fit the model's best, should they tell that it was not at 0. What comes with the
    /// motors' motion is as it was recorded, whatever the angle.
    pub(crate) fn start_angle(
        &self,
        weld: &RecordedWeld,
        model: &BaselineModel,
        compared: &[Compared],
    ) -> Option<f64> {
        /// Angles that are tried.
        const SPINDLE_ANGLES_TRIED: usize = 720;
        let forces = weld.forces(&weld.process(model), &Ports::default(), &weld.motion, None);
        let still = weld.quick_vectors(&forces);
        let still = self.read_amplitudes(weld, &still);
        let mut match_of = [Complex::new(0.0, 0.0); COMPARED_ORDERS];
        let mut values = compared.chunks_exact(6);
        for &order in &self.read {
            for ((k, &row), values) in weld.rows.iter().enumerate().zip(values.by_ref()) {
                let closed = &self.loops[k][order - 1];
                let to_tool = weld.rotation[row].transpose() * weld.axes[row];
                let to_tool = to_tool.map(|x| Complex::new(x, 0.0));
                let ripple = to_tool * (closed.pass * still[k][order - 1]);
                let driven = to_tool * (closed.driven + closed.noise);
                let pairs = values.chunks_exact(2).enumerate();
                for (c, pair) in pairs.filter(|(c, _)| !weld.unmeasured[*c]) {
                    let seen = Complex::new(pair[0].measured, -pair[1].measured) - driven[c];
                    match_of[order - 1] += seen.conj() * ripple[c] / pair[0].deviation.powi(2);
                }
            }
        }
        let alike = |angle: f64| {
            let turned = |(n, z): (usize, &Complex<f64>)| {
                (z * Complex::from_polar(1.0, (n + 1) as f64 * angle)).re
            };
            match_of.iter().enumerate().map(turned).sum::<f64>()
        };
        let angles =
            (0..SPINDLE_ANGLES_TRIED).map(|k| k as f64 * TAU / SPINDLE_ANGLES_TRIED as f64);
        let best = angles.max_by(|a, b| alike(*a).total_cmp(&alike(*b)))?;
        if 2.0 * (alike(best) - alike(0.0)) < SPINDLE_ANGLE_FALL_MIN {
            return None;
        }
        // The top of the parabola through it and its neighbours.
        let step = TAU / SPINDLE_ANGLES_TRIED as f64;
        let [low, top, high] = [best - step, best, best + step].map(alike);
        let bend = low - 2.0 * top + high;
        Some(if bend < 0.0 { best + 0.5 * step * (low - high) / bend } else { best })
    }

    /// Lists what is compared at these orders, with its noise. `level`: of the measured force;
    /// `encoder`: of the encoders.
    pub(crate) fn compare(
        &mut self,
        weld: &RecordedWeld,
        model: &BaselineModel,
        (level, encoder): (&[NoiseLevel], &[NoiseLevel]),
        compared: &mut Vec<Compared>,
    ) {
        let white = 2.0 * weld.low.gain(0);
        let measured = weld.quick_vectors(&weld.force);
        let amplitudes = self.read_amplitudes(weld, &measured);
        for &order in &self.read {
            let beside =
                measured.each_ref().map(|series| self.mean_square_beside(weld, order, series));
            for (k, &row) in weld.rows.iter().enumerate() {
                let driven = self.driven_noise(weld, model, encoder, order, k);
                let arm = self.loops[k][order - 1].arm;
                let amplitude = amplitudes[k][order - 1];
                for c in 0..3 {
                    let arm = weld.turned(&arm, row, c);
                    let noise = level[c].deviation.powi(2) + weld.turned(&driven, row, c);
                    let variance = (white * noise + arm).max(beside[c]);
                    for (sine, value) in [(false, amplitude[c].re), (true, -amplitude[c].im)] {
                        let value = if weld.unmeasured[c] { f64::NAN } else { value };
                        self.measured.push(value);
                        compared.push(Compared {
                            quantity: ComparedQuantity::Ripple { order: order as u8, sine },
                            component: c as u8,
                            row,
                            measured: value,
                            deviation: variance.sqrt(),
                            stated: level[c].stated,
                            alike: arm / variance,
                            accuracy: 0.0,
                        });
                    }
                }
            }
        }
    }

    /// Mean square of what a series holds to either side of an order's line: the arm shakes a
    /// little of itself, and most where it likes to.
    fn mean_square_beside(&self, weld: &RecordedWeld, order: usize, series: &[f64]) -> f64 {
        let mut squares = Vec::new();
        for order in [order as f64 - self.aside, order as f64 + self.aside] {
            let wave = |f: fn(f64) -> f64| {
                weld.angle.iter().map(|a| 2.0 * f(order * a)).collect::<Vec<f64>>()
            };
            for wave in [wave(f64::cos), wave(f64::sin)] {
                let at = |row: &usize| {
                    weld.low.at(0, |k| series[k] * wave[k], series.len(), *row).powi(2)
                };
                squares.extend(weld.rows.iter().map(at));
            }
        }
        squares.iter().sum::<f64>() / squares.len() as f64
    }

    /// What the encoders' noise becomes in the force at an order of the spindle, in W: deviation
    /// per deviation of a demodulated reading.
    fn driven_noise(
        &self,
        weld: &RecordedWeld,
        model: &BaselineModel,
        encoder: &[NoiseLevel],
        order: usize,
        k: usize,
    ) -> Vector3<f64> {
        let row = weld.rows[k];
        let q = JointVector::from_fn(|i, _| self.encoder[row][i]);
        let process = weld.process(model);
        let held = weld.held(&process, row).reaction;
        let turning = folded(weld, order);
        let MovedTool { carried, compliance } =
            arm_moves(&weld.axes[row], &model.robot, &q, turning);
        let contact = process.slope_at(&held, turning);
        let pass = passed(&contact, &compliance);
        let noise = SVector::<_, 6>::from_fn(|i, _| Complex::new(encoder[i].deviation, 0.0));
        let all = pass * contact * carried * Matrix6::from_diagonal(&noise);
        Vector3::from_fn(|c, _| all.row(c).iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt())
    }

    /// Complex amplitudes of a vector series at some orders around a row: x = Re(z exp(i n φ)).
    fn amplitudes(
        &self,
        weld: &RecordedWeld,
        orders: &[usize],
        row: usize,
        series: &[Vec<f64>; 3],
    ) -> [Vector3<Complex<f64>>; COMPARED_ORDERS] {
        let mut amplitudes = [Vector3::zeros(); COMPARED_ORDERS];
        for (c, series) in series.iter().enumerate() {
            let (first, weighted) = weld.low.weighted(series, row);
            for &order in orders {
                let [cosine, sine] = self.waves[order - 1]
                    .each_ref()
                    .map(|wave| dot(&weighted, &wave[first..][..weighted.len()]));
                amplitudes[order - 1][c] = Complex::new(cosine, -sine);
            }
        }
        amplitudes
    }

    /// The same at the orders that are read, around every compared row.
    fn read_amplitudes(
        &self,
        weld: &RecordedWeld,
        series: &[Vec<f64>; 3],
    ) -> Vec<[Vector3<Complex<f64>>; COMPARED_ORDERS]> {
        weld.rows.iter().map(|row| self.amplitudes(weld, &self.read, *row, series)).collect()
    }

    /// Complex amplitude of one series at an order around a row.
    fn amplitude_of(
        &self,
        weld: &RecordedWeld,
        order: usize,
        row: usize,
        series: impl Fn(usize) -> f64,
    ) -> Complex<f64> {
        let [cosine, sine] = [0, 1].map(|part| {
            let wave = &self.waves[order - 1][part];
            weld.low.at(0, |k| series(k) * wave[k], wave.len(), row)
        });
        Complex::new(cosine, -sine)
    }

    /// Measured less predicted, N, where `still` is the force on a tool that does not shake, and `under`
    /// how it does.
    pub(crate) fn residual(
        &self,
        weld: &RecordedWeld,
        robot: &ElasticRobot,
        (still, under): (&[Vector3<f64>], &SpindleShake<'_>),
        residual: &mut Vec<f64>,
    ) {
        let ports = &robot.ports;
        let zero = sensed(ports, Channel::Wrench, unread(0.0)).force;
        let late_by = ports.delay(Channel::Wrench);
        let still = weld.quick_vectors(still);
        let ripples = self.read_amplitudes(weld, &still);
        let mut measured = self.measured.iter();
        for &order in &self.read {
            let back = Complex::from_polar(1.0, -turning(weld, order) * late_by);
            let driven_back = Complex::from_polar(1.0, -folded(weld, order) * late_by);
            for (k, &row) in weld.rows.iter().enumerate() {
                let closed = &under.loops[k][order - 1];
                let ripple = closed.pass * ripples[k][order - 1] + closed.product;
                let force = ripple.map(|z| z * back) + closed.driven.map(|z| z * driven_back);
                // As the nominal arm has it, whatever the model.
                let nominal = self.loops[k][order - 1].noise;
                let read = |part: Vector3<f64>| {
                    let force = weld.in_tool(row, &part);
                    let truth = Readings { force, ..unread(row as f64 * weld.period) };
                    sensed(ports, Channel::Wrench, truth).force - zero
                };
                let noise = |part: Vector3<f64>| weld.in_tool(row, &part);
                let cosine = read(force.map(|z| z.re)) + noise(nominal.map(|z| z.re));
                let sine = read(force.map(|z| -z.im)) + noise(nominal.map(|z| -z.im));
                let predicted = (0..3).flat_map(|c| [cosine[c], sine[c]]);
                residual.extend(measured.by_ref().zip(predicted).map(|(m, p)| m - p));
            }
        }
    }
}

/// Predicted forces as they are under the push that was measured: a ripple goes with that.
fn carried(weld: &RecordedWeld, process: &Process, forces: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let share = weld.carried(process, &weld.force, forces);
    forces.iter().zip(share).map(|(force, share)| force * share).collect()
}

/// A nominal arm with what gears that remember add to its springs; `None` where none does.
fn stiffer(arm: &Robot<f64>, robot: &ElasticRobot) -> Option<Robot<f64>> {
    if robot.ports.memories() == 0 {
        return None;
    }
    let added = robot.remembered_stiffness();
    let mut parameters = arm.parameters().clone();
    parameters.joints.iter_mut().zip(added.iter()).for_each(|(j, k)| j.stiffness += k);
    Robot::new(parameters).ok()
}

/// Share of the mean square of each encoder's amplitudes, by row, that its noise does not make.
/// `white`: variance of a part of an amplitude per variance of a reading.
fn trusted(
    amplitudes: &[SVector<Complex<f64>, 6>],
    level: &[NoiseLevel],
    white: f64,
) -> JointVector<f64> {
    JointVector::from_fn(|i, _| {
        let square = amplitudes.iter().map(|z| z[i].norm_sqr()).sum::<f64>();
        let noise = 2.0 * white * level[i].deviation.powi(2) * amplitudes.len() as f64;
        signal_share(square, noise)
    })
}

/// Angular frequency of an order, rad/s; signed, as a spindle turns.
fn turning(weld: &RecordedWeld, order: usize) -> f64 {
    order as f64 * weld.process.spindle
}

/// The slowest angular frequency whose samples are those of an order, rad/s; negative where
/// they run backwards. Motors move this slowly rather than as fast as an order beyond half the
/// sampling rate.
fn folded(weld: &RecordedWeld, order: usize) -> f64 {
    let rate = TAU / weld.period;
    turning(weld, order) - rate * (turning(weld, order) / rate).round()
}

/// An arm at an angular frequency, with the links at `q`. `axes`: of W in B.
fn arm_moves(
    axes: &Matrix3<f64>,
    arm: &Robot<f64>,
    q: &JointVector<f64>,
    turning: f64,
) -> MovedTool {
    let frames = arm.frames(q);
    let jacobian = axes.transpose() * frames.jacobian().0.fixed_rows::<3>(3);
    let jacobian = jacobian.map(|x| Complex::new(x, 0.0));
    let spring = Matrix6::from_diagonal(&arm.dynamic_stiffness(turning));
    let h = arm.dynamic_compliance(&frames, turning).unwrap_or_else(Matrix6::zeros);
    MovedTool { carried: jacobian * h * spring, compliance: jacobian * h * jacobian.transpose() }
}

/// (1 + Z C)⁻¹.
fn passed(
    contact: &Matrix3<Complex<f64>>,
    compliance: &Matrix3<Complex<f64>>,
) -> Matrix3<Complex<f64>> {
    (Matrix3::identity() + contact * compliance).try_inverse().unwrap_or_else(Matrix3::zeros)
}
