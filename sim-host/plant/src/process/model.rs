//! What a process is to the rest of the plant: the trait that each implements in a file of its own,
//! and the value that a process file becomes.
//!
//! Nothing here knows a particular process. General to all are a spindle, ripple locked to its
//! angle, and a tool that stands at a point of the weld frame W.

use crate::input::{InputError, Quantity, TomlTable, Weld};
use crate::robot::{Ports, ProcessPoint};
use nalgebra::{Complex, Matrix3, Vector3};

/// One order of the ripple.
#[derive(Debug, Clone, PartialEq)]
pub struct Ripple {
    /// Periods per spindle turn.
    pub order: f64,
    /// Relative amplitude of the depth force.
    pub axial: f64,
    /// Relative amplitude of the forces in the plane of the plate.
    pub in_plane: f64,
    /// Phase at spindle angle 0, rad.
    pub phase: f64,
}

/// What the process does to the tool at one instant, in axes of W.
#[derive(Debug, Clone, Copy)]
pub struct Reaction {
    /// Force on the tool, N.
    pub force: Vector3<f64>,
    /// −∂F/∂p of the baseline and of its drag's factors, N/m: what an implicit integrator needs of
    /// the contact.
    pub stiffness: Matrix3<f64>,
    /// −∂F/∂ṗ of the same, N·s/m.
    pub damping: Matrix3<f64>,
    /// ẏ_m, m/s.
    pub channel_rate: f64,
    /// ẋ_m, m/s; 0 of a process that keeps no trail.
    pub trail_rate: f64,
}

/// The tool at one instant, and what acts besides the process' own equations.
#[derive(Debug, Clone, Copy)]
pub struct ToolInstant<'a> {
    /// The effects of the cell.
    pub ports: &'a Ports,
    /// Ripple locked to the spindle's angle.
    pub ripple: &'a [Ripple],
    /// Tool in W; its depth force is yet to be stated by the process.
    pub point: ProcessPoint,
    /// Lateral position y_m of what the tool left behind, m.
    pub channel: f64,
    /// Its path position x_m, m, where the process keeps one and it is known.
    pub trail: Option<f64>,
}

impl ToolInstant<'_> {
    /// Factors by which the ripple multiplies the axial force, and the forces in the plane.
    #[inline]
    pub(super) fn ripple_factors(&self) -> [f64; 2] {
        let (mut axial, mut in_plane) = (1.0, 1.0);
        for r in self.ripple {
            let wave = (r.order * self.point.spindle_angle + r.phase).sin();
            axial += r.axial * wave;
            in_plane += r.in_plane * wave;
        }
        [axial, in_plane]
    }
}

/// Why a weld is not one of a process.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ProcessMisfit {
    /// A push is asked for that nothing bears.
    #[error(
        "{process} bears no push that a force loop could hold; expected `held = \"position\"` in the weld file in \
         place of `force_n` and `force_ramp_s`"
    )]
    PushAsked {
        /// The process.
        process: &'static str,
    },
    /// No push is asked for.
    #[error(
        "{process} is held by its push; expected a process that bears none (`--process`), or `force_n` and \
         `force_ramp_s` in the weld file in place of `held`"
    )]
    NoPush {
        /// The process.
        process: &'static str,
    },
    /// A depth that the process states itself.
    #[error("{process} states its depth itself; expected `initial_depth_m = 0` in the weld file")]
    Depth {
        /// The process.
        process: &'static str,
    },
    /// A step of a force that is not held.
    #[error("{process} bears no push, and without one there is no force to step")]
    NoStep {
        /// The process.
        process: &'static str,
    },
}

/// What an effect may act on that not every process has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProcessPart {
    /// A drag along the seam in proportion to feed and push.
    Drag,
    /// A push out of the plate, which a force loop holds.
    Push,
    /// A number of its file, by its key.
    Number(&'static str),
}

impl ProcessPart {
    /// In words, after "acts on".
    pub fn describe(self) -> String {
        match self {
            Self::Drag => "the drag in proportion to feed and push".to_owned(),
            Self::Push => "the push".to_owned(),
            Self::Number(key) => format!("`{key}`"),
        }
    }
}

/// One process of the library: a line of the table.
#[derive(Debug)]
pub struct ProcessKind {
    /// Identifier, as the `kind` of a process file.
    pub id: &'static str,
    /// In sentences.
    pub name: &'static str,
    /// Its equations.
    pub equation: &'static str,
    /// What it is, and what it leaves out: two sentences.
    pub about: &'static str,
    /// Keys of every number that a file states; those of the ripple as `ripple.axial`.
    pub keys: &'static [&'static str],
    /// Keys of its file that are no numbers.
    pub words: &'static [&'static str],
    /// Ranges of the numbers that it has beside the general ones.
    pub quantities: &'static [Quantity],
    /// Keys of the numbers that a certification draws by one short key, each with which of five
    /// factors moves it.
    pub drawn: &'static [(&'static str, usize)],
    /// What effects may act on.
    pub parts: &'static [ProcessPart],
    /// Reads what is its own in a file.
    pub read: fn(root: &TomlTable<'_>) -> Result<Box<dyn ProcessModel>, InputError>,
}

impl ProcessKind {
    /// True where an effect finds in it what it acts on; where nothing is done, whatever acts on it
    /// does no harm.
    pub fn has(&self, part: ProcessPart) -> bool {
        self.keys.is_empty()
            || match part {
                ProcessPart::Number(key) => self.keys.contains(&key),
                part => self.parts.contains(&part),
            }
    }

    /// True for a number that a certification draws by its short key.
    pub fn draws(&self, key: &str) -> bool {
        self.drawn.iter().any(|(drawn, _)| *drawn == key)
    }

    /// The range of a number of its own.
    pub fn quantity(&self, key: &str) -> Option<&'static Quantity> {
        self.quantities.iter().find(|q| q.key == key)
    }
}

/// The equations of a process with their numbers.
pub trait ProcessModel: std::fmt::Debug + Send + Sync {
    /// Which process.
    fn kind(&self) -> &'static ProcessKind;

    /// The same.
    fn boxed(&self) -> Box<dyn ProcessModel>;

    /// A number of its own by its key.
    fn number(&mut self, key: &str) -> Option<&mut f64>;

    /// Force on the tool.
    fn reaction(&self, at: ToolInstant<'_>) -> Reaction;

    /// The same equations as a mean over a turn of the spindle, but for the ripple.
    fn even(&self) -> Box<dyn ProcessModel> {
        self.boxed()
    }

    /// Diameter of the tool where it meets the material, m.
    fn tool_diameter(&self) -> f64;

    /// How far beside its line the tool may be before the seam, or the edge, is missed, m.
    fn lateral_tolerance(&self) -> f64;

    /// What that is, in words.
    fn tolerance_name(&self) -> &'static str {
        "the tolerance"
    }

    /// Stiffness against depth, N/m; 0 of a process that bears no push.
    fn depth_stiffness(&self) -> f64 {
        0.0
    }

    /// True where forces in the plane are in proportion to the push.
    fn plane_follows_push(&self) -> bool {
        false
    }

    /// Drag along the seam and force across it under a push, N, and a feed, m/s: their sizes as a
    /// mean over a turn, N.
    fn planned_drag(&self, spindle: f64, push: f64, feed: f64) -> [f64; 2];

    /// Force of the process, N, of which small shares are no contact to speak of.
    fn reference_force(&self) -> f64;

    /// Travel over which what the tool left behind follows it, m.
    fn memory_length(&self) -> f64 {
        f64::MIN_POSITIVE
    }

    /// Stiffness across the seam against what the tool left behind, under a push, N: N/m.
    fn channel_stiffness(&self, _push: f64) -> f64 {
        0.0
    }

    /// Time by which the place that the tool was at before lags behind it, s, where the force depends
    /// on the way between; 0 where it depends on the tool's speed.
    fn trail_time(&self, _spindle: f64) -> f64 {
        0.0
    }

    /// Orders of the spindle at which the force repeats by itself, beside the ripple.
    fn own_orders(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Warns of numbers that do not fit each other. `place`: where a key stands.
    fn check(&self, spindle: f64, place: &dyn Fn(&str) -> String);

    /// Warns of numbers of a weld that do not fit.
    fn check_weld(&self, spindle: f64, weld: &Weld, place: &dyn Fn(&str) -> String);
}

/// A process as a file states it.
#[derive(Debug)]
pub struct Process {
    /// Spindle speed, rad/s, positive about the tool's z axis.
    pub spindle: f64,
    /// Ripple locked to the spindle angle φ: each force is multiplied by 1 + Σ
    /// amplitude·sin(order·φ + phase).
    pub ripple: Vec<Ripple>,
    /// What is its own.
    pub model: Box<dyn ProcessModel>,
}

impl Clone for Process {
    fn clone(&self) -> Self {
        Self { spindle: self.spindle, ripple: self.ripple.clone(), model: self.model.boxed() }
    }
}

impl PartialEq for Process {
    fn eq(&self, other: &Self) -> bool {
        // Every number of a model stands in its debug form, to the last digit.
        self.spindle == other.spindle
            && self.ripple == other.ripple
            && format!("{:?}", self.model) == format!("{:?}", other.model)
    }
}

impl Process {
    /// Which process.
    pub fn kind(&self) -> &'static ProcessKind {
        self.model.kind()
    }

    /// Every number of a key: one, or one for every order of the ripple; none where the process has
    /// no such number.
    pub fn numbers(&mut self, key: &str) -> Vec<&mut f64> {
        let line: fn(&mut Ripple) -> &mut f64 = match key {
            "spindle_rad_s" => return vec![&mut self.spindle],
            "ripple.order" => |line| &mut line.order,
            "ripple.axial" => |line| &mut line.axial,
            "ripple.in_plane" => |line| &mut line.in_plane,
            "ripple.phase_rad" => |line| &mut line.phase,
            key => return self.model.number(key).into_iter().collect(),
        };
        self.ripple.iter_mut().map(line).collect()
    }

    /// The number of a key; NaN where the process has none, or several.
    pub fn number(&self, key: &str) -> f64 {
        match self.clone().numbers(key).as_slice() {
            [number] => **number,
            _ => f64::NAN,
        }
    }

    /// Multiplies every number of a key.
    pub fn scale(&mut self, key: &str, factor: f64) {
        self.numbers(key).into_iter().for_each(|number| *number *= factor);
    }

    /// The process with a number of its own, by its key, times a factor.
    #[must_use]
    pub fn scaled(mut self, key: &str, factor: f64) -> Self {
        self.scale(key, factor);
        self
    }

    /// The process as a mean over a turn of the spindle.
    #[must_use]
    pub fn even(&self) -> Self {
        Self { spindle: self.spindle, ripple: Vec::new(), model: self.model.even() }
    }

    /// True where the process bears a push, which a force loop can hold.
    pub fn bears_push(&self) -> bool {
        self.model.depth_stiffness() > 0.0
    }

    /// True where the force depends on where the tool was a while before.
    pub fn keeps_trail(&self) -> bool {
        self.model.trail_time(self.spindle) > 0.0
    }

    /// The speed, m/s, that stands for a vibration of the tool, of displacement m and speed m/s, which
    /// is fast against what the process keeps of its way.
    pub fn vibration_speed(&self, by: &Vector3<f64>, speed: &Vector3<f64>) -> Vector3<f64> {
        let time = self.model.trail_time(self.spindle);
        if time > 0.0 { by / time } else { *speed }
    }

    /// −∂F/∂p of a reaction's slopes at an angular frequency, rad/s: k + iωb, and where the process
    /// keeps a trail, whose slope is of its lag, k + iωb/(1 + iωT). N/m.
    pub fn slope_at(&self, of: &Reaction, turning: f64) -> Matrix3<Complex<f64>> {
        let time = self.model.trail_time(self.spindle);
        of.stiffness.zip_map(&of.damping, |k, b| match time {
            0.0 => Complex::new(k, turning * b),
            time => k + Complex::new(0.0, turning * b) / Complex::new(1.0, turning * time),
        })
    }

    /// That a weld is one of the process.
    ///
    /// # Errors
    /// [`ProcessMisfit`].
    pub fn fits(&self, weld: &Weld) -> Result<(), ProcessMisfit> {
        let process = self.kind().name;
        match (self.bears_push(), weld.force > 0.0) {
            (true, false) => Err(ProcessMisfit::NoPush { process }),
            (false, true) => Err(ProcessMisfit::PushAsked { process }),
            (false, false) if weld.initial_depth > 0.0 => Err(ProcessMisfit::Depth { process }),
            _ => Ok(()),
        }
    }

    /// Depth at which it bears a push, N: m; 0 of a process that bears none.
    pub fn depth_under(&self, push: f64) -> f64 {
        if self.bears_push() { push / self.model.depth_stiffness() } else { 0.0 }
    }

    /// Orders of the spindle at which the force repeats.
    pub fn orders(&self) -> Vec<f64> {
        let ripple = self.ripple.iter().map(|line| line.order);
        ripple.chain(self.model.own_orders()).collect()
    }
}
