//! Loads at rest, and a weld's pose below the spindle's frequency: the links stand under their load
//! at every instant.

use super::columns::{
    Dropouts, filled_vectors, mean_abs, period, rows_a_vector, spindle_angle, turned_from_first,
    vector, wrench_columns,
};
use super::compared::{list, none_where_missing};
use super::instruments::{tracker_reading, wrench_behind};
use super::play::{BacklashObserver, Observed, SEEN_OVER, lever, turn};
use super::wiener::WienerSmoother;
use super::{BaselineModel, Compared, ComparedQuantity, LinkMotion, PredictError, known};
use nalgebra::{Matrix3, Vector3, Vector6};
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JOINTS, JointVector, Pose, Robot, Wrench};
use trueweld_logs::channel::LogChannel;
use trueweld_logs::fir::{LowPass, Orders, comb};
use trueweld_logs::log::{Log, Payload};
use trueweld_logs::noise::{NoiseLevel, NoiseLevels};
use trueweld_plant::effects::EffectError;
use trueweld_plant::integrate::link_dynamics::{Motors, QuasiStaticLinks};
use trueweld_plant::robot::{Channel, ElasticRobot, Memory};

/// Band of a weld's pose, Hz: an arm whose first mode lies above 10 Hz follows its load there to a
/// few percent of what swings, and what swings there is small. Also at most a share of the
/// spindle's frequency.
const POSE_BAND: f64 = 2.0;
const POSE_SPINDLE_SHARE: f64 = 0.3;

/// Orders of the spindle at which the wrench loads the links.
const HEARD_ORDERS: usize = 3;

/// Bands around these orders in which their amplitudes are heard, as shares of the pose's, widest
/// first: they change as the push does and with the posture.
const HEARD_BANDS: [f64; 3] = [1.0, 0.3, 0.1];

/// Instants at which the links stand.
#[derive(Debug, Clone)]
pub(super) struct StaticPrediction {
    /// Rows that are compared.
    rows: Vec<usize>,
    /// Every instant the links are followed through: time from the start, s; motors; wrench.
    time: Vec<f64>,
    motors: Vec<Motors>,
    wrench: Vec<Wrench<f64>>,
    /// The band of a weld's pose; loads at rest are compared as they are.
    band: Option<LowPass>,
    /// Which of the payloads hangs on the flange.
    payload: Vec<usize>,
    payloads: Vec<Payload>,
    position: Option<Vec<Vector3<f64>>>,
    rotation: Option<Vec<Matrix3<f64>>>,
    /// Where the tool was seen at every instant, and how it was turned.
    seen: Option<Vec<Vector3<f64>>>,
    seen_turned: Option<Vec<Matrix3<f64>>>,
    /// Deviation of the tracker's position over that of its rotation, m.
    lever: f64,
    /// Deviation of the tracker's position at rest, m; 0 of a weld.
    seen_deviation: f64,
    /// Noise of a weld's pose at every compared row, as it is compared: rotation, rad, and position,
    /// m.
    noise: Vec<Vector6<f64>>,
    /// Torque that the wrench's noise makes at each joint, N·m.
    load_uncertainty: JointVector<f64>,
    /// Twist that this torque makes, rad.
    margin: JointVector<f64>,
    /// Of the log's rows, s; infinite where each is at rest.
    period: f64,
}

impl StaticPrediction {
    /// A log under a wrench, axes of the sensor, with nothing hung on the flange, of which nothing is
    /// compared yet. `gain`: what is left of the variance of the wrench.
    fn under_wrench(
        log: &Log,
        noise: &NoiseLevels,
        model: &BaselineModel,
        [force, moment]: [&[Vec<f64>; 3]; 2],
        gain: f64,
    ) -> Self {
        let time = &log.samples.time;
        let wrench = |k: usize| Wrench { moment: vector(moment, k), force: vector(force, k) };
        let load_uncertainty = load_uncertainty(log, noise, model, gain);
        Self {
            rows: Vec::new(),
            time: time.iter().map(|t| t - time[0]).collect(),
            motors: Vec::new(),
            wrench: (0..time.len()).map(wrench).collect(),
            band: None,
            payload: vec![0; time.len()],
            payloads: vec![Payload { mass: 0.0, centre: Vector3::zeros() }],
            position: None,
            rotation: None,
            seen: None,
            seen_turned: None,
            lever: lever(noise),
            seen_deviation: 0.0,
            noise: Vec::new(),
            load_uncertainty,
            margin: load_uncertainty.component_div(model.robot.stiffness()),
            period: f64::INFINITY,
        }
    }

    /// A static-load log.
    pub(super) fn of_loads(
        log: &Log,
        noise: &NoiseLevels,
        model: &BaselineModel,
        compared: &mut Vec<Compared>,
    ) -> Result<Option<Self>, PredictError> {
        let s = &log.samples;
        // A row under a load that was not read is not compared.
        let loaded = |k: usize| {
            let read =
                |v: &Option<Vec<Vector3<f64>>>| v.as_ref().is_none_or(|v| v[k].sum().is_finite());
            read(&s.force) && read(&s.moment)
        };
        let told = |series: &Option<Vec<Vector3<f64>>>| {
            let of = |(k, v): (usize, &Vector3<f64>)| {
                if loaded(k) { *v } else { Vector3::repeat(f64::NAN) }
            };
            series.as_ref().map(|v| v.iter().enumerate().map(of).collect::<Vec<_>>())
        };
        let position = told(&s.position);
        let deviation = |levels: &[Option<NoiseLevel>; 3]| levels[0].map_or(0.0, |l| l.deviation);
        let rotation: Option<Vec<Matrix3<f64>>> =
            told(&s.rotation).map(|r| r.iter().map(rotation_from_vector).collect());
        let mut standing = Self {
            rows: (0..s.time.len()).collect(),
            motors: s.encoder.iter().map(|q| Motors::at_rest(*q)).collect(),
            seen: position.clone(),
            seen_turned: rotation.clone(),
            position,
            seen_deviation: deviation(&noise.position),
            rotation,
            ..Self::under_wrench(log, noise, model, wrench_columns(log).each_ref(), 1.0)
        };
        for (k, p) in s.payload.iter().flatten().enumerate() {
            if p.mass.is_finite() && p.mass != 0.0 {
                let known = standing.payloads.iter().position(|q| q == p);
                standing.payload[k] = known.unwrap_or(standing.payloads.len());
                standing.payloads.extend(known.is_none().then_some(*p));
            }
        }
        let load = [&noise.force, &noise.moment]
            .map(|levels| levels.map(|level| level.map_or(0.0, |level| level.deviation.powi(2))));
        standing.compare(log, noise, model, |_| load, compared)?;
        Ok(Some(standing))
    }

    /// The pose of a weld; `None` without a whole force to load the links.
    pub(super) fn of_weld(
        log: &Log,
        noise: &NoiseLevels,
        model: &BaselineModel,
        compared: &mut Vec<Compared>,
    ) -> Result<Option<Self>, PredictError> {
        let s = &log.samples;
        let n = s.time.len();
        if filled_vectors(&s.force).is_none() || s.unmeasured_force.contains(&true) {
            return Ok(None);
        }
        let [force, moment] = wrench_columns(log);
        let tracker = filled_vectors(&s.position);
        let period = period(log);
        let angle = spindle_angle(log);
        let spindle =
            s.spindle.as_ref().map_or(f64::INFINITY, |v| mean_abs(v)) / std::f64::consts::TAU;
        let band = POSE_BAND.min(POSE_SPINDLE_SHARE * spindle);
        let low = LowPass::new(band.min(0.2 / period), period);
        if n < 2 * low.half() + 2 {
            return Ok(None);
        }
        let bands = HEARD_BANDS.map(|share| share * band);
        let orders =
            angle.as_ref().map(|angle| Orders { angle, count: HEARD_ORDERS, bands: &bands });
        let heard = |v, levels, measured| {
            HeardVector::of(v, (levels, rows_a_vector(measured, &low)), &low, &orders, period)
        };
        let force = heard(&force, &noise.force, &s.force);
        let moment = heard(&moment, &noise.moment, &s.moment);
        let every = ((0.4 / (band * period)).floor() as usize).max(1);
        let rows: Vec<usize> = (low.half()..n - low.half()).step_by(every).collect();
        let none = || Vector3::repeat(f64::NAN);
        let columns: Vec<Vec<f64>> =
            (0..6).map(|i| s.encoder.iter().map(|q| q[i]).collect()).collect();
        let moved: Vec<[Vec<f64>; 2]> =
            columns.iter().map(|c| [low.smooth(1, c), low.smooth(2, c)]).collect();
        let six = |d: usize, k: usize| JointVector::from_fn(|i, _| moved[i][d][k]);
        let motors = (0..n)
            .map(|k| Motors { angle: s.encoder[k], rate: six(0, k), acceleration: six(1, k) })
            .collect();
        let undriven = Dropouts::of_vectors([&s.force, &s.moment], &low);
        let slow = |v: &[Vec<f64>; 3], measured: &Option<Vec<Vector3<f64>>>| {
            let unseen = Dropouts::of_vectors([measured], &low);
            smoothed_at(&rows, v, &low, [&undriven, &unseen])
        };
        // Averaged to both sides: a link that is late in its gap would be off by half of it.
        let averaged = LowPass::new(0.5 / SEEN_OVER, period);
        let seen = |v: &[Vec<f64>; 3], measured: &Option<Vec<Vector3<f64>>>| {
            let unseen = Dropouts::of_vectors([measured], &averaged);
            let v = [0, 1, 2].map(|c| averaged.smooth(0, &v[c]));
            let of = |k| if unseen.within(averaged.half(), k) { none() } else { vector(&v, k) };
            (0..n).map(of).collect::<Vec<_>>()
        };
        let turned = turned_from_first(&s.rotation);
        let back = |turned: Vec<Vector3<f64>>, first: &Matrix3<f64>| {
            turned.iter().map(|r| first * rotation_from_vector(r)).collect()
        };
        let gain = low.gain(0) * (1 + 2 * HEARD_ORDERS) as f64;
        let mut standing = Self {
            motors,
            band: Some(low.clone()),
            seen: tracker.as_ref().map(|t| seen(t, &s.position)),
            seen_turned: turned.as_ref().map(|(first, t)| back(seen(t, &s.rotation), first)),
            position: tracker.map(|t| slow(&t, &s.position)),
            rotation: turned.map(|(first, t)| back(slow(&t, &s.rotation), &first)),
            period,
            rows,
            ..Self::under_wrench(log, noise, model, [&force.series, &moment.series], gain)
        };
        let first = compared.len();
        let load = |row: usize| [force.variance(row), moment.variance(row)];
        standing.compare(log, noise, model, load, compared)?;
        standing.noise = vec![Vector6::repeat(f64::INFINITY); standing.rows.len()];
        for c in &compared[first..] {
            let from = if c.quantity == ComparedQuantity::Position { 3 } else { 0 };
            let place = standing.rows.partition_point(|row| *row < c.row);
            standing.noise[place][from + usize::from(c.component)] = c.deviation;
        }
        Ok(Some(standing))
    }

    /// Lists what is compared, with its noise: the tracker's, the wrench's through the arm's
    /// compliance, and the encoders'. `load`: variance of force, N², and moment, (N·m)², by row.
    fn compare(
        &self,
        log: &Log,
        noise: &NoiseLevels,
        model: &BaselineModel,
        load: impl Fn(usize) -> [[f64; 3]; 2],
        compared: &mut Vec<Compared>,
    ) -> Result<(), PredictError> {
        let s = &log.samples;
        let gain = self.band.as_ref().map_or(1.0, |low| low.gain(0));
        let seldom = |series| self.band.as_ref().map_or(1.0, |low| rows_a_vector(series, low));
        let encoder = known(&noise.encoder, log, LogChannel::Encoder)?;
        let encoder = JointVector::from_fn(|i, _| encoder[i].deviation.powi(2) * gain);
        let mut through: Vec<[f64; 4]> = Vec::with_capacity(self.rows.len());
        for row in &self.rows {
            let q = &self.motors[*row].angle;
            let variance = twist_variance(&model.robot, q, &encoder, load(*row));
            let rotation = variance[..3].iter().sum::<f64>() / 3.0;
            through.push([variance[3], variance[4], variance[5], rotation]);
        }
        let rows = &self.rows;
        let deviation = |level: &NoiseLevel, seldom: f64, own: f64| {
            (level.deviation.powi(2) * seldom * gain + own).sqrt()
        };
        if let Some(position) = &self.position {
            let level = known(&noise.position, log, LogChannel::Position)?;
            let seldom = seldom(&s.position);
            list(compared, ComparedQuantity::Position, rows, 0..3, |k, c| {
                (position[k][c], deviation(&level[c], seldom, through[k][c]), level[c].stated)
            });
        }
        if let Some(rotation) = &self.rotation {
            let level = known(&noise.rotation, log, LogChannel::Rotation)?;
            let seldom = seldom(&s.rotation);
            list(compared, ComparedQuantity::Rotation, rows, 0..3, |k, c| {
                let deviation = deviation(&level[c], seldom, through[k][3]);
                (none_where_missing(&rotation[k]), deviation, level[c].stated)
            });
        }
        Ok(())
    }

    /// True where the first row is under a load that its noise does not make.
    pub(super) fn begins_under_load(&self, model: &BaselineModel) -> bool {
        let frames = model.robot.frames(&self.motors[0].angle);
        let wrench = self.wrench[0].rotated(&frames.tcp.rotation);
        let jacobian = frames.jacobian().0;
        let torque = |i: usize| {
            jacobian.fixed_view::<3, 1>(0, i).dot(&wrench.moment)
                + jacobian.fixed_view::<3, 1>(3, i).dot(&wrench.force)
        };
        self.payload[0] != 0 || (0..JOINTS).any(|i| torque(i).abs() > self.load_uncertainty[i])
    }

    /// Where the motors were at every instant.
    pub(super) fn motors(&self) -> &[Motors] {
        &self.motors
    }

    /// What the links do: see [`PreparedLog::follow`](super::PreparedLog).
    pub(super) fn motion(
        &self,
        robot: &mut ElasticRobot,
        memory: &Memory,
        before: Option<&LinkMotion>,
    ) -> Result<LinkMotion, EffectError> {
        let n = self.time.len();
        let mut links =
            QuasiStaticLinks::remembering(memory).with_load_uncertainty(self.load_uncertainty);
        let mut in_backlash = self
            .seen
            .as_ref()
            .and_then(|s| Some((s, BacklashObserver::new(robot, self.margin, f64::INFINITY)?)));
        let mut motion = LinkMotion::new(n, in_backlash.is_some());
        let loaded = self
            .payloads
            .iter()
            .map(|p| with_payload(&robot.model, p))
            .collect::<Result<Vec<_>, _>>()?;
        let mut on_flange = 0;
        for k in 0..n {
            if self.payload[k] != on_flange {
                on_flange = self.payload[k];
                robot.model = loaded[on_flange].clone();
            }
            let wrench = wrench_behind(&robot.ports, &self.wrench_at(robot, k), self.time[k]);
            let mut stand = links.follow(robot, &self.motors[k], &wrench, self.time[k]);
            if let Some((position, in_backlash)) = &mut in_backlash {
                let tool = tracker_reading(&robot.ports, &stand.frames.tcp, self.time[k]);
                let seen_turned = self.seen_turned.as_ref().map(|turned| &turned[k]);
                let left = Observed {
                    tool: position[k] - tool.position,
                    turn: turn(&tool, seen_turned),
                    lever: self.lever,
                    deviation: self.seen_deviation,
                    link: [f64::NAN; JOINTS],
                };
                let moved = in_backlash.moved(robot, &self.motors[k].angle, &stand.link, &left);
                links.displace(robot, &mut stand, &moved.by, &wrench, self.time[k]);
                motion.in_backlash.push(moved.placed);
            }
            motion.link.push(stand.link);
            motion.spring.push(stand.spring);
            motion.tool.push(stand.frames.tcp);
            if robot.ports.memories() > 0 {
                motion.memory.push(*links.memory());
            }
            if let Some(before) = before.filter(|before| motion.joins(before)) {
                motion.go_on(before);
                break;
            }
        }
        robot.model = loaded[0].clone();
        Ok(motion)
    }

    /// The wrench recorded for an instant: where the sensor is late, what it read that much later.
    fn wrench_at(&self, robot: &ElasticRobot, k: usize) -> Wrench<f64> {
        let late = robot.ports.delay(Channel::Wrench);
        if self.band.is_none() || late == 0.0 {
            return self.wrench[k];
        }
        let at = k as f64 + late / self.period;
        let (first, share) =
            ((at.max(0.0) as usize).min(self.wrench.len() - 1), at.max(0.0).fract());
        let next = (first + 1).min(self.wrench.len() - 1);
        let between = |a: Vector3<f64>, b: Vector3<f64>| a * (1.0 - share) + b * share;
        let (a, b) = (&self.wrench[first], &self.wrench[next]);
        Wrench { moment: between(a.moment, b.moment), force: between(a.force, b.force) }
    }

    /// Measured less predicted, in engineering units.
    pub(super) fn residual(
        &self,
        robot: &ElasticRobot,
        motion: &LinkMotion,
        residual: &mut Vec<f64>,
    ) {
        let tool: Vec<Pose<f64>> = match &self.band {
            None => self.rows.iter().map(|row| motion.tool[*row]).collect(),
            Some(band) => self.smoothed(band, robot, motion),
        };
        let sensed: Vec<Pose<f64>> = self
            .rows
            .iter()
            .zip(&tool)
            .map(|(row, pose)| tracker_reading(&robot.ports, pose, self.time[*row]))
            .collect();
        if let Some(position) = &self.position {
            position
                .iter()
                .zip(&sensed)
                .for_each(|(m, p)| residual.extend((m - p.position).iter()));
        }
        if let Some(rotation) = &self.rotation {
            for (m, p) in rotation.iter().zip(&sensed) {
                residual.extend(rotation_vector(&p.rotation.tr_mul(m)).iter());
            }
        }
    }

    /// What it takes from the evidence for a model that its links may lie anywhere in their gaps and
    /// are put where they were seen in a weld, as a sum of squares: at every compared row the noise
    /// that such a link takes with it, or twice the logarithm of the gap over what is seen of it.
    pub(super) fn free_play_term(&self, robot: &ElasticRobot, motion: &LinkMotion) -> f64 {
        let rows = self.rows.iter().zip(&self.noise);
        rows.map(|(row, noise)| row_free_play_term(robot, motion, *row, noise)).sum()
    }

    /// The tool's poses in the band of a weld, as late as the tracker is, at every compared row.
    fn smoothed(
        &self,
        band: &LowPass,
        robot: &ElasticRobot,
        motion: &LinkMotion,
    ) -> Vec<Pose<f64>> {
        let late = robot.ports.delay(Channel::Tracker);
        let n = motion.tool.len();
        // Turned from the middle one: along a straight seam the tool turns by little.
        let middle = motion.tool[n / 2].rotation;
        let mut columns: [Vec<f64>; 6] = std::array::from_fn(|_| Vec::with_capacity(n));
        for tool in &motion.tool {
            let turned = rotation_vector(&middle.tr_mul(&tool.rotation));
            for c in 0..3 {
                columns[c].push(tool.position[c]);
                columns[3 + c].push(turned[c]);
            }
        }
        let mut twists: [Vec<f64>; JOINTS] = std::array::from_fn(|_| Vec::with_capacity(n));
        for (motors, link) in self.motors.iter().zip(&motion.link) {
            let twist = motors.angle - link;
            twists.iter_mut().zip(&twist).for_each(|(column, twist)| column.push(*twist));
        }
        let mut poses = Vec::with_capacity(self.rows.len());
        for &row in &self.rows {
            let value = |c: usize| {
                let now = band.at(0, |k| columns[c][k], n, row);
                if late == 0.0 { now } else { now - late * band.at(1, |k| columns[c][k], n, row) }
            };
            let turned = Vector3::new(value(3), value(4), value(5));
            // What dampers carry and what the links' own acceleration takes while the load changes,
            // the springs need not: a micrometre in the ramps of a weld.
            let twist = |derivative: usize| {
                JointVector::from_fn(|i, _| band.at(derivative, |k| twists[i][k], n, row))
            };
            let frames = robot.model.frames(&motion.link[row]);
            let spared = robot.model.damping().component_mul(&twist(1))
                + robot.model.crba(&frames) * twist(2);
            let by = frames.jacobian().0 * spared.component_div(robot.model.stiffness());
            let by = |first: usize| by.fixed_rows::<3>(first).into_owned();
            let rotation = middle * rotation_from_vector(&turned);
            poses.push(Pose {
                position: Vector3::new(value(0), value(1), value(2)) + by(3),
                rotation: rotation * rotation_from_vector(&rotation.tr_mul(&by(0))),
            });
        }
        poses
    }
}

/// A measured force or moment as far as it has something to say: its noise would make a gear's memory fade,
/// and a joint that does not twist under it fit better than one that does.
struct HeardVector {
    series: [Vec<f64>; 3],
    smoother: WienerSmoother,
    /// Variance of its noise in the band of a weld's pose.
    noise: Vector3<f64>,
}

impl HeardVector {
    /// With what the smoother keeps in the band of `low`, and in bands around the spindle's orders; as it
    /// is above that band where its angle is not known. `seldom`: rows for each reading.
    fn of(
        measured: &[Vec<f64>; 3],
        (levels, seldom): (&[Option<NoiseLevel>; 3], f64),
        low: &LowPass,
        orders: &Option<Orders<'_>>,
        period: f64,
    ) -> Self {
        let deviation = levels.map(|level| level.map_or(0.0, |level| level.deviation));
        let unit = Vector3::from(deviation.map(|d| (d * seldom.sqrt()).max(f64::EPSILON)));
        let slow = measured.each_ref().map(|series| low.smooth(0, series));
        let in_noise = |k: usize| vector(&slow, k).component_div(&unit);
        let mut kept: Vec<Vector3<f64>> = (0..slow[0].len()).map(in_noise).collect();
        let smoother = WienerSmoother::of_noise_in(low, &kept);
        smoother.keep(&mut kept);
        let series = [0, 1, 2].map(|c| {
            let apart = measured[c].iter().zip(&slow[c]);
            let mut quick: Vec<f64> = apart.map(|(all, slow)| all - slow).collect();
            if let Some(orders) = orders {
                quick = comb(orders, period, deviation[c], &quick);
            }
            kept.iter().zip(quick).map(|(kept, quick)| kept[c] * unit[c] + quick).collect()
        });
        Self { series, smoother, noise: unit.map(|unit| unit.powi(2) * low.gain(0)) }
    }

    /// Variance that noise leaves in the band of a weld's pose, at a row.
    fn variance(&self, row: usize) -> [f64; 3] {
        [0, 1, 2].map(|c| self.noise[c] * self.smoother.variance((0, c), row, [1.0, 0.0]))
    }
}

/// Vectors in the band of `low` at some rows; NaN near dropouts.
fn smoothed_at(
    rows: &[usize],
    columns: &[Vec<f64>; 3],
    low: &LowPass,
    dropouts: [&Dropouts; 2],
) -> Vec<Vector3<f64>> {
    let mut smoothed = Vec::with_capacity(rows.len());
    for &row in rows {
        let unknown = dropouts.iter().any(|d| d.within(low.half(), row));
        let value = |column: &Vec<f64>| low.at(0, |k| column[k], column.len(), row);
        smoothed.push(if unknown {
            Vector3::repeat(f64::NAN)
        } else {
            Vector3::from_fn(|c, _| value(&columns[c]))
        });
    }
    smoothed
}

/// Variance of the tool's rotation, rad², and position, m², along each axis of B, at encoder angles
/// `q`, rad: by variances of the encoders, rad², and of force, N², and moment, (N·m)², in T, through the
/// arm's compliance.
fn twist_variance(
    robot: &Robot<f64>,
    q: &JointVector<f64>,
    encoder: &JointVector<f64>,
    [force, moment]: [[f64; 3]; 2],
) -> [f64; 6] {
    let frames = robot.frames(q);
    let jacobian = frames.jacobian();
    let compliance = robot.cartesian_compliance(&jacobian);
    let turn = frames.tcp.rotation;
    let (c_moment, c_force) =
        (compliance.fixed_columns::<3>(0) * turn, compliance.fixed_columns::<3>(3) * turn);
    std::array::from_fn(|row| {
        let e: f64 = (0..6).map(|i| jacobian.0[(row, i)].powi(2) * encoder[i]).sum();
        let of_wrench = |i: usize| {
            c_moment[(row, i)].powi(2) * moment[i] + c_force[(row, i)].powi(2) * force[i]
        };
        e + (0..3).map(of_wrench).sum::<f64>()
    })
}

/// What one row makes of [`StaticPrediction::free_play_term`]. `noise`: of the tool's rotation,
/// rad, and position, m.
fn row_free_play_term(
    robot: &ElasticRobot,
    motion: &LinkMotion,
    row: usize,
    noise: &Vector6<f64>,
) -> f64 {
    let in_backlash = motion.in_backlash.get(row).filter(|in_backlash| in_backlash.contains(&true));
    let Some(in_backlash) = in_backlash else { return 0.0 };
    let jacobian = robot.model.frames(&motion.link[row]).jacobian().0;
    let of = |i: usize| {
        let seen = jacobian.column(i).component_div(noise).norm();
        let gap = 2.0 * robot.play(i) * seen;
        (2.0 * (gap / std::f64::consts::TAU.sqrt()).ln()).max(1.0)
    };
    (0..JOINTS).filter(|i| in_backlash[*i]).map(of).sum()
}

/// Torque at each joint that is within the noise of the wrench, N·m: three deviations, in the
/// middle of the log. `gain`: what of its variance is left.
fn load_uncertainty(
    log: &Log,
    noise: &NoiseLevels,
    model: &BaselineModel,
    gain: f64,
) -> JointVector<f64> {
    let jacobian =
        model.robot.frames(&log.samples.encoder[log.samples.encoder.len() / 2]).jacobian().0;
    let of = |levels: &[Option<NoiseLevel>; 3]| {
        levels.iter().flatten().map(|l| l.deviation).fold(0.0, f64::max)
    };
    let (moment, force) = (of(&noise.moment), of(&noise.force));
    JointVector::from_fn(|i, _| {
        let variance = jacobian.fixed_view::<3, 1>(0, i).norm_squared() * moment.powi(2)
            + jacobian.fixed_view::<3, 1>(3, i).norm_squared() * force.powi(2);
        3.0 * (variance * gain).sqrt()
    })
}

/// The robot with an extra mass on its flange, whose centre is given from the flange in axes of the
/// last link.
pub(crate) fn with_payload(
    robot: &Robot<f64>,
    payload: &Payload,
) -> Result<Robot<f64>, EffectError> {
    if payload.mass == 0.0 {
        return Ok(robot.clone());
    }
    let mut parameters = robot.parameters().clone();
    let tool = &mut parameters.tool;
    let mass = tool.mass + payload.mass;
    tool.com_from_flange =
        (tool.com_from_flange * tool.mass + payload.centre * payload.mass) / mass;
    tool.mass = mass;
    Robot::new(parameters).map_err(|reason| EffectError::Model { id: "the payload", reason })
}
