//! The links alone, driven by a recording of the encoders: (2.1) without its motors.
//!
//! Two ways. [`QuasiStaticLinks`]: the springs carry what the links ask for at every instant,
//! nothing swings; loads at rest and slow motion in contact. [`DynamicLinks`]: the links' equation
//! of motion integrated in time; free motion and ringing down. Both start from, and keep, what the
//! joints remember.

use super::Diverged;
use crate::robot::{Drives, ElasticRobot, INTERNAL_STATES, JointMotion, Memory, TiltMotion, Tilts};
use nalgebra::SVector;
use trueweld_core::ldlt::Ldlt;
use trueweld_core::{Frames, JOINTS, JointVector, Wrench};

/// Fixed-point iterations over the posture; each divides the error by some hundreds, and a load
/// that changes little from call to call starts near its end.
const POSTURE_ITERATIONS: usize = 4;
const NEXT_ITERATIONS: usize = 2;

/// Change of the posture from which on the start is made anew, rad.
const JUMP: f64 = 1e-3;

/// Twist to which a spring's equation is solved, rad: a tenth of a nanometre at the tool.
const TWIST_TOLERANCE: f64 = 1e-11;

/// Steps in which a spring's equation is bracketed and solved at most.
const SPRING_STEPS: usize = 60;

/// The encoders at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motors {
    /// Encoder angles θ_E, rad.
    pub angle: JointVector<f64>,
    /// Encoder rates, rad/s.
    pub rate: JointVector<f64>,
    /// Encoder accelerations, rad/s².
    pub acceleration: JointVector<f64>,
}

impl Motors {
    /// At rest.
    pub fn at_rest(angle: JointVector<f64>) -> Self {
        Self { angle, rate: JointVector::zeros(), acceleration: JointVector::zeros() }
    }
}

/// The links where they stand.
#[derive(Debug, Clone, Copy)]
pub struct StaticState {
    /// Link angles θ, rad.
    pub link: JointVector<f64>,
    /// Spring torque τ_s, N·m.
    pub spring: JointVector<f64>,
    /// Frames of the real arm.
    pub frames: Frames<f64>,
}

/// Links that follow the motors and their load without swinging; keeps what the gears remember from
/// call to call.
#[derive(Debug, Clone, Copy)]
pub struct QuasiStaticLinks {
    internal: Memory,
    torsion: Option<JointVector<f64>>,
    motor: JointVector<f64>,
    load_uncertainty: JointVector<f64>,
}

impl Default for QuasiStaticLinks {
    fn default() -> Self {
        Self::new()
    }
}

impl QuasiStaticLinks {
    /// Gears without memory.
    pub fn new() -> Self {
        Self {
            internal: [0.0; INTERNAL_STATES],
            torsion: None,
            motor: JointVector::zeros(),
            load_uncertainty: JointVector::zeros(),
        }
    }

    /// Gears with this memory at the first load.
    pub fn remembering(memory: &Memory) -> Self {
        Self { internal: *memory, ..Self::new() }
    }

    /// The same for loads known to within `load_uncertainty`, N·m at each joint: a load that small
    /// does not take a link from where it was left in its gap.
    #[must_use]
    pub fn with_load_uncertainty(self, load_uncertainty: JointVector<f64>) -> Self {
        Self { load_uncertainty, ..self }
    }

    /// What the gears remember now.
    pub fn memory(&self) -> &Memory {
        &self.internal
    }

    /// Where the links stand with the motors at `motors` and a wrench on the tool: τ_s = M(θ) θ̈ +
    /// h + g − τ_cb − Jᵀ w, with the links' motion taken from the motors'. `wrench_in_t`: at the
    /// TCP, in axes of the real tool frame. `time` from the start of the log, s.
    ///
    /// The load is taken to have come from the one before along a straight line in every joint's
    /// angle and torsion. Angles are NaN where the arm cannot carry the load.
    pub fn follow(
        &mut self,
        robot: &ElasticRobot,
        motors: &Motors,
        wrench_in_t: &Wrench<f64>,
        time: f64,
    ) -> StaticState {
        let mut torsion = self.torsion.unwrap_or_else(JointVector::zeros);
        let mut drives = Drives {
            link: motors.angle - torsion,
            link_rate: motors.rate,
            motor: motors.angle,
            motor_rate: motors.rate,
        };
        let mut spring = JointVector::zeros();
        let near = self.torsion.is_some() && !self.jumped(motors);
        // Bearings and base that give: their tilt follows the wrench, whose axes follow the tool's.
        let mut frames = robot.model.frames(&drives.link);
        for round in 0..if near { NEXT_ITERATIONS } else { POSTURE_ITERATIONS } {
            let mut wrench = wrench_in_t.rotated(&frames.tcp.rotation);
            if round > 0 || robot.ports.frames_give() {
                frames = robot.frames(&drives.link, &wrench, time);
                wrench = wrench_in_t.rotated(&frames.tcp.rotation);
            }
            spring = robot.model.rnea(&frames, &motors.rate, &motors.acceleration, &wrench)
                - robot.link_torque(&drives, &self.led_to(robot, &drives));
            for i in 0..JOINTS {
                torsion[i] = self.torsion_under(robot, &drives, i, spring[i]);
            }
            drives.link = motors.angle - torsion;
        }
        let wrench = wrench_in_t.rotated(&frames.tcp.rotation);
        frames = robot.frames(&drives.link, &wrench, time);
        self.internal = self.led_to(robot, &drives);
        self.torsion = Some(torsion);
        self.motor = motors.angle;
        StaticState { link: drives.link, spring, frames }
    }

    /// Takes links that nothing holds elsewhere by `by`, rad, under the same load.
    pub fn displace(
        &mut self,
        robot: &ElasticRobot,
        stand: &mut StaticState,
        by: &JointVector<f64>,
        wrench_in_t: &Wrench<f64>,
        time: f64,
    ) {
        if *by == JointVector::zeros() {
            return;
        }
        if let Some(torsion) = &mut self.torsion {
            *torsion -= by;
        }
        stand.link += by;
        stand.frames =
            robot.frames(&stand.link, &wrench_in_t.rotated(&stand.frames.tcp.rotation), time);
    }

    /// True where the posture is another one than at the call before.
    fn jumped(&self, motors: &Motors) -> bool {
        (motors.angle - self.motor).amax() > JUMP
    }

    /// The way from where the links stand to `drives`, and there with the way's lengths as rates;
    /// `None` before the first load.
    fn way_to(&self, drives: &Drives) -> Option<Drives> {
        let stood = self.motor - self.torsion?;
        let (link_rate, motor_rate) = (drives.link - stood, drives.motor - self.motor);
        Some(Drives { link_rate, motor_rate, ..*drives })
    }

    /// What the joints remember once they have come to `drives`.
    fn led_to(&self, robot: &ElasticRobot, drives: &Drives) -> Memory {
        let mut memory = self.internal;
        if robot.ports.memories() > 0
            && let Some(way) = self.way_to(drives)
        {
            (0..JOINTS).for_each(|i| robot.remembered(&way, i, &self.internal, &mut memory));
        }
        memory
    }

    /// Torque that a spring carries at a torsion, with what it remembers of the way there, N·m.
    fn spring_torque_at(
        &self,
        robot: &ElasticRobot,
        drives: &Drives,
        i: usize,
        torsion: f64,
    ) -> f64 {
        let (mut drives, mut memory) = (*drives, self.internal);
        drives.link[i] = drives.motor[i] - torsion;
        if let Some(way) = self.way_to(&drives) {
            robot.remembered(&way, i, &self.internal, &mut memory);
        }
        robot.joint_spring_torque(&drives, i, &memory)
    }

    /// Twist θ_E − θ of one joint at which its spring carries `torque`.
    fn torsion_under(&self, robot: &ElasticRobot, drives: &Drives, i: usize, torque: f64) -> f64 {
        let plain = torque / robot.model.stiffness()[i] - robot.ports.link_angle[i];
        if robot.spring_is_plain(i) {
            return plain;
        }
        let mut at = |torsion: f64| self.spring_torque_at(robot, drives, i, torsion) - torque;
        let stiffness = robot.model.stiffness()[i];
        let mut torsion = root(&mut at, plain, stiffness);
        // In a gap the spring carries nothing over a range of torsions, and the link stays where it
        // was left: at the first load, by a motion from the zero pose.
        let load_uncertainty = self.load_uncertainty[i].max(LOAD_UNCERTAINTY_MIN * stiffness);
        if torque.abs() <= load_uncertainty && robot.play(i) > 0.0 {
            let low = root(&mut |t| at(t) + load_uncertainty, plain, stiffness);
            let high = root(&mut |t| at(t) - load_uncertainty, plain, stiffness);
            if high - low > GAP_WIDTH_RATIO * load_uncertainty / stiffness {
                let moved = drives.motor[i] - self.motor[i];
                torsion = match self.torsion {
                    Some(before) if moved.abs() < JUMP => before[i].clamp(low, high),
                    // A link that nothing holds runs on in its gap when its joint stops.
                    _ if moved > 0.0 => low,
                    _ => high,
                };
            }
        }
        torsion
    }
}

/// Least slack, as a share of the stiffness, rad.
const LOAD_UNCERTAINTY_MIN: f64 = 1e-8;

/// Width of what a slack load can move a spring by, in what it moves a plain one by, from which on
/// it is a gap.
const GAP_WIDTH_RATIO: f64 = 6.0;

/// Where a rising function is zero. A few secants first, beginning with `slope`, which suffice for
/// a spring that is straight there; else Illinois' false position, in a bracket around `guess` that
/// grows until it holds the root. NaN where there is none.
fn root(at: &mut impl FnMut(f64) -> f64, guess: f64, slope: f64) -> f64 {
    let (mut before, mut at_before) = (guess, at(guess));
    let mut slope = slope;
    for _ in 0..4 {
        let next = before - at_before / slope;
        let at_next = at(next);
        if at_next.abs() < TWIST_TOLERANCE * slope {
            return next;
        }
        slope = (at_next - at_before) / (next - before);
        (before, at_before) = (next, at_next);
        if slope.is_nan() || slope <= 0.0 {
            break;
        }
    }
    let (mut low, mut high) = (guess - 1e-4, guess + 1e-4);
    let (mut at_low, mut at_high) = (at(low), at(high));
    let mut reach = 2e-4;
    let mut steps = 0;
    while at_low > 0.0 && steps < SPRING_STEPS {
        (low, reach, steps) = (low - reach, reach * 2.0, steps + 1);
        at_low = at(low);
    }
    while at_high < 0.0 && steps < SPRING_STEPS {
        (high, reach, steps) = (high + reach, reach * 2.0, steps + 1);
        at_high = at(high);
    }
    if !(at_low <= 0.0 && at_high >= 0.0) {
        return f64::NAN;
    }
    let mut side = 0;
    for _ in 0..SPRING_STEPS {
        if high - low < TWIST_TOLERANCE {
            break;
        }
        let share = at_low / (at_low - at_high);
        let share = if share.is_finite() { share.clamp(0.01, 0.99) } else { 0.5 };
        let middle = low + (high - low) * share;
        let there = at(middle);
        if there == 0.0 {
            (low, high) = (middle, middle);
        } else if there < 0.0 {
            (low, at_low) = (middle, there);
            at_high *= if side == -1 { 0.5 } else { 1.0 };
            side = -1;
        } else {
            (high, at_high) = (middle, there);
            at_low *= if side == 1 { 0.5 } else { 1.0 };
            side = 1;
        }
    }
    0.5 * (low + high)
}

/// Time over which the rate of a torsion is taken, s.
const TORSION_RATE_TIME: f64 = 1e-3;

/// Links that swing on their springs, no wrench on the tool.
#[derive(Debug, Clone, Copy)]
pub struct DynamicLinks {
    /// Where bearings or base give, the links' angles are β of [`Tilts`].
    drives: Drives,
    /// u of [`Tilts`], and its rate.
    tilted: [JointVector<f64>; 2],
    /// What bearings and base give to now.
    tilts: TiltMotion,
    internal: SVector<f64, INTERNAL_STATES>,
    before: Motors,
    time: f64,
}

impl DynamicLinks {
    /// Links that at the start neither swing nor fall behind: they follow the motors' motion. Their
    /// gears remember nothing.
    pub fn start(robot: &ElasticRobot, motors: &Motors, time: f64) -> Self {
        Self::start_remembering(robot, motors, &[0.0; INTERNAL_STATES], time)
    }

    /// The same with what the gears remember at the start.
    pub fn start_remembering(
        robot: &ElasticRobot,
        motors: &Motors,
        memory: &Memory,
        time: f64,
    ) -> Self {
        let mut standing = QuasiStaticLinks::remembering(memory);
        let stand = standing.follow(robot, motors, &Wrench::zero(), time);
        let drives = Drives {
            link: stand.link,
            link_rate: motors.rate,
            motor: motors.angle,
            motor_rate: motors.rate,
        };
        let mut links = Self {
            drives,
            tilted: [JointVector::zeros(); 2],
            tilts: TiltMotion { rate: motors.rate, ..TiltMotion::default() },
            internal: SVector::from(standing.internal),
            before: *motors,
            time,
        };
        if let Some(link) = JointMotion::standing(robot, &stand.link) {
            links.drives.link = link;
            links.tilted[0] = link - stand.link;
        }
        links
    }

    /// The same in the midst of a motion whose jerk is known, rad/s³: the springs' torsion follows
    /// the inertia of the accelerated links, and its rate the change of it.
    pub fn start_in_motion(
        robot: &ElasticRobot,
        motors: &Motors,
        jerk: &JointVector<f64>,
        memory: &Memory,
        time: f64,
    ) -> Self {
        let mut start = Self::start_remembering(robot, motors, memory, time);
        let moved = |after: f64| Motors {
            angle: motors.angle + motors.rate * after + motors.acceleration * (0.5 * after * after),
            rate: motors.rate + motors.acceleration * after + jerk * (0.5 * after * after),
            acceleration: motors.acceleration + jerk * after,
        };
        let torsion = |links: &mut QuasiStaticLinks, after: f64| {
            let motors = moved(after);
            motors.angle - links.follow(robot, &motors, &Wrench::zero(), time).link
        };
        let mut rate = if robot.ports.memories() > 0 {
            // A gear that remembers is stiffer or softer by which way it goes: only forward.
            let mut links = QuasiStaticLinks::remembering(memory);
            let before = torsion(&mut links, 0.0);
            (torsion(&mut links, TORSION_RATE_TIME) - before) / TORSION_RATE_TIME
        } else {
            let [before, behind] = [-TORSION_RATE_TIME, TORSION_RATE_TIME]
                .map(|after| torsion(&mut QuasiStaticLinks::new(), after));
            (behind - before) / (2.0 * TORSION_RATE_TIME)
        };
        // A link in its gap is where it was left.
        (0..JOINTS).filter(|i| robot.play(*i) > 0.0).for_each(|i| rate[i] = 0.0);
        if rate.sum().is_finite() {
            start.drives.link_rate -= rate;
            // What the dampers carry, the springs need not.
            let damped = robot.model.damping().component_mul(&rate);
            start.drives.link += damped.component_div(robot.model.stiffness());
        }
        start
    }

    /// Angles and rates now.
    pub fn drives(&self) -> Drives {
        let [u, u_rate] = self.tilted;
        let Drives { link, link_rate, .. } = self.drives;
        Drives { link: link - u, link_rate: link_rate - u_rate, ..self.drives }
    }

    /// Spring torque now, N·m.
    pub fn spring(&self, robot: &ElasticRobot) -> JointVector<f64> {
        robot.spring_torque(&self.drives(), self.internal.as_slice())
    }

    /// What the gears remember now.
    pub fn memory(&self) -> Memory {
        self.internal.into()
    }

    /// The gears remember this now.
    pub fn remember(&mut self, memory: &Memory) {
        self.internal = SVector::from(*memory);
    }

    /// Frames of the real arm at `time`, s.
    pub fn frames(&self, robot: &ElasticRobot, time: f64) -> Frames<f64> {
        robot.frames_in_motion(&self.drives().link, &self.tilts, &Wrench::zero(), time)
    }

    /// Takes the links elsewhere by `by`, rad, and changes their rates by `rate`, rad/s.
    pub fn displace(&mut self, by: &JointVector<f64>, rate: &JointVector<f64>) {
        self.drives.link += by;
        self.drives.link_rate += rate;
    }

    /// Advances to `time` at which the encoders are at `motors`; in between these run along the
    /// cubic through both ends.
    ///
    /// Runge–Kutta of fourth order in `substeps` for springs, dampers and what gears remember.
    /// Inertia and velocity terms, which change with the posture, are taken in its middle.
    /// [`substeps`](super::substeps) tells how many it takes.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn advance(
        &mut self,
        robot: &ElasticRobot,
        motors: &Motors,
        time: f64,
        substeps: usize,
    ) -> Result<(), Diverged> {
        let whole = time - self.time;
        let h = whole / substeps as f64;
        let from = self.before;
        let middle = self.drives.link + self.drives.link_rate * (0.5 * whole);
        let frames = robot.model.frames(&middle);
        let middle_rate = self.drives.link_rate + (motors.rate - from.rate) * 0.5;
        let (inertia, bias) =
            robot.model.equation_of_motion(&frames, &middle_rate, &Wrench::zero());
        let factor = Ldlt::new(inertia).ok_or(Diverged { time })?;
        let motor_acceleration = (motors.rate - from.rate) / whole;
        let tilts = robot.ports.frames_give().then(|| {
            let rest = bias - robot.link_torque(&self.drives, self.internal.as_slice());
            let rates = (&middle_rate, &motor_acceleration);
            Tilts::new(robot, &frames, rates, &Wrench::zero(), (&factor, &rest))
        });
        let tilts = tilts.flatten();
        let mut u = self.tilted[0];
        let path = |share: f64| hermite(&from, motors, whole, share);
        let step = (h, substeps);
        match &tilts {
            None => self.integrate(robot, path, step, (&factor, &bias), |_, _| ()),
            Some(tilts) => {
                self.integrate(robot, path, step, (&factor, &bias), |drives, internal| {
                    *drives = tilts.joints(robot, drives, internal, &mut u);
                })
            }
        }
        self.drives.motor = motors.angle;
        self.drives.motor_rate = motors.rate;
        if let Some(tilts) = &tilts {
            let now = tilts.joints(robot, &self.drives, self.internal.as_slice(), &mut u);
            let torque = robot.spring_torque(&now, self.internal.as_slice());
            let rest = robot.link_torque(&now, self.internal.as_slice()) - bias;
            let acceleration = factor.solve(&(torque + rest));
            self.tilted = [self.drives.link - now.link, self.drives.link_rate - now.link_rate];
            self.tilts = tilts.motion(&self.drives.link_rate, &acceleration, &motor_acceleration);
        }
        self.before = *motors;
        self.time = time;
        if self.drives.link.sum().is_finite() && self.drives.link.amax() < 1e3 {
            Ok(())
        } else {
            Err(Diverged { time })
        }
    }

    /// The steps of [`advance`](Self::advance). `path`: the motors' angles and rates by the share of
    /// the way; `joints` takes drives whose link angles are β to those of the springs.
    #[inline]
    fn integrate(
        &mut self,
        robot: &ElasticRobot,
        path: impl Fn(f64) -> (JointVector<f64>, JointVector<f64>),
        (h, substeps): (f64, usize),
        (factor, bias): (&Ldlt<f64>, &JointVector<f64>),
        mut joints: impl FnMut(&mut Drives, &[f64]),
    ) {
        let mut rates = |(motor, motor_rate): &(JointVector<f64>, JointVector<f64>),
                         link: JointVector<f64>,
                         link_rate: JointVector<f64>,
                         internal: &SVector<f64, INTERNAL_STATES>| {
            let mut drives = Drives { link, link_rate, motor: *motor, motor_rate: *motor_rate };
            joints(&mut drives, internal.as_slice());
            link_rates(robot, factor, bias, &drives, internal.as_slice())
        };
        let (half, sixth) = (0.5 * h, h / 6.0);
        let mut end = path(0.0);
        for k in 0..substeps {
            let part = |c: f64| path((k as f64 + c) / substeps as f64);
            let (start, middle) = (end, part(0.5));
            end = part(1.0);
            let Self { drives: Drives { link, link_rate: v1, .. }, internal, .. } = *self;
            let (a1, z1) = rates(&start, link, v1, &internal);
            let v2 = v1 + a1 * half;
            let (a2, z2) = rates(&middle, link + v1 * half, v2, &(internal + z1 * half));
            let v3 = v1 + a2 * half;
            let (a3, z3) = rates(&middle, link + v2 * half, v3, &(internal + z2 * half));
            let v4 = v1 + a3 * h;
            let (a4, z4) = rates(&end, link + v3 * h, v4, &(internal + z3 * h));
            self.drives.link = link + (v1 + (v2 + v3) * 2.0 + v4) * sixth;
            self.drives.link_rate = v1 + (a1 + (a2 + a3) * 2.0 + a4) * sixth;
            self.internal = internal + (z1 + (z2 + z3) * 2.0 + z4) * sixth;
        }
    }
}

/// Acceleration of the links, rad/s², where `bias` and the factored inertia are known, and how fast
/// what terms remember changes.
#[inline]
fn link_rates(
    robot: &ElasticRobot,
    factor: &Ldlt<f64>,
    bias: &JointVector<f64>,
    drives: &Drives,
    internal: &[f64],
) -> (JointVector<f64>, SVector<f64, INTERNAL_STATES>) {
    let torque = robot.spring_torque(drives, internal) + robot.link_torque(drives, internal) - bias;
    let mut remembered = SVector::<f64, INTERNAL_STATES>::zeros();
    robot.internal_rates(drives, internal, remembered.as_mut_slice());
    (factor.solve(&torque), remembered)
}

/// Angle and rate a share of the way between two samples, on the cubic through angles and rates at
/// both ends.
fn hermite(from: &Motors, to: &Motors, h: f64, share: f64) -> (JointVector<f64>, JointVector<f64>) {
    let s = share;
    let (s2, s3) = (s * s, s * s * s);
    let angle = from.angle * (2.0 * s3 - 3.0 * s2 + 1.0)
        + from.rate * ((s3 - 2.0 * s2 + s) * h)
        + to.angle * (3.0 * s2 - 2.0 * s3)
        + to.rate * ((s3 - s2) * h);
    let rate = (to.angle - from.angle) * ((6.0 * s - 6.0 * s2) / h)
        + from.rate * (3.0 * s2 - 4.0 * s + 1.0)
        + to.rate * (3.0 * s2 - 2.0 * s);
    (angle, rate)
}
