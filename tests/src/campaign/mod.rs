//! Synthetic measurement campaigns: what a laboratory would record of a cell whose truth we choose.
//!
//! The corpus against which a diagnosis is measured: a campaign folder as `MEASUREMENTS` fixes it,
//! made by the plant's own equations under a [`Recipe`]. The logs carry the truth's effects; the
//! model beside them is the bare baseline. Nothing here predicts or fits anything, and nothing that
//! does is used. `truth.toml` states what was built in, for whoever counts the answers. Left out: a
//! spindle whose speed wanders, instruments with a filter.

mod draw;
mod links;
mod motion;
mod plan;
pub(crate) mod random;
mod stranger;
mod table;

pub use draw::{draw, effect};
pub use stranger::{OutOfLibrary, Strange};

use crate::fixture;
use links::Unsettled;
use plan::Plan;
use random::Random;
use std::fmt::Write as _;
use std::path::Path;
use table::CampaignNoise;
use trueweld_core::{JOINTS, ModelError, Pose, Robot};
use trueweld_plant::cell::Cell;
use trueweld_plant::effects::{Effect, EffectError, Location, LocationKind};
use trueweld_plant::input::{Control, InputError, Process, RobotFile, Sensors, write_atomically};
use trueweld_plant::robot::{Channel, TooManyStates};
use trueweld_plant::simulate::RunError;

/// Which logs a campaign holds, and how long they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Logs {
    /// Postures of the static log, eight rows each, nearly; 0 leaves the log out. The held-out one
    /// has half of them.
    pub postures: usize,
    /// Ring-down logs; the six joints are divided among them. At most 6.
    pub rings: usize,
    /// Length of a ring-down, s.
    pub ring: f64,
    /// Length of the free motion, s; 0 leaves the log out. The held-out one is shorter.
    pub free: f64,
    /// Welds, and one held out; 0 leaves all of them out.
    pub welds: usize,
    /// Length of a seam, m.
    pub seam: f64,
}

impl Logs {
    /// A campaign of a laboratory's day.
    pub fn usual() -> Self {
        Self { postures: 6, rings: 2, ring: 1.0, free: 12.0, welds: 2, seam: 0.2 }
    }

    /// One of each kind, as short as it can be: for tests.
    pub fn short() -> Self {
        Self { postures: 4, rings: 1, ring: 0.6, free: 2.0, welds: 1, seam: 0.02 }
    }
}

/// What a campaign is made of: the truth, what the laboratory gets wrong, and what it measures
/// with.
#[derive(Debug, Clone)]
pub struct Recipe {
    /// Effects of the library that the truth has.
    pub effects: Vec<Effect>,
    /// What the truth has outside the library.
    pub stranger: Option<OutOfLibrary>,
    /// Error of each joint's stiffness, relative: what a robot's uncertainty leaves.
    pub stiffness_error: [f64; JOINTS],
    /// Error of each encoder's zero, rad.
    pub encoder_offset: [f64; JOINTS],
    /// Standard deviation of a tracker set up anew for each log: translation, m, and half of it per
    /// metre as rotation, rad.
    pub registration_per_log: f64,
    /// Factor on the nominal noise of every instrument.
    pub noise: f64,
    /// True where `log.toml` states the noise.
    pub noise_stated: bool,
    /// Which logs.
    pub logs: Logs,
    /// True where A1 to A3 have a second encoder on the link side.
    pub link_encoders: bool,
    /// True where motor torque is recorded.
    pub motor_torque: bool,
    /// Seed of everything random: postures, motions, seams, noise.
    pub seed: u64,
}

impl Recipe {
    /// The baseline itself, measured with nominal noise, stated, and every instrument there is.
    pub fn plain(seed: u64) -> Self {
        Self {
            effects: Vec::new(),
            stranger: None,
            stiffness_error: [0.0; JOINTS],
            encoder_offset: [0.0; JOINTS],
            registration_per_log: 0.0,
            noise: 1.0,
            noise_stated: true,
            logs: Logs::usual(),
            link_encoders: true,
            motor_torque: true,
            seed,
        }
    }

    /// The same with one effect more, and with the instrument that the effect is of.
    #[must_use]
    pub fn with_effect(mut self, effect: Effect) -> Self {
        self.link_encoders |= effect.kind.id.starts_with("link-encoder")
            || effect.at == Location::Channel(Channel::LinkEncoder);
        self.motor_torque |= effect.at == Location::Channel(Channel::MotorTorque);
        self.effects.push(effect);
        self
    }

    /// The same with something outside the library.
    #[must_use]
    pub fn with_stranger(mut self, stranger: OutOfLibrary) -> Self {
        self.stranger = Some(stranger);
        self
    }

    /// The same with a laboratory's usual errors, normal with these standard deviations: stiffness
    /// (relative), encoder zero (rad), registration per log (m).
    #[must_use]
    pub fn with_nuisance(mut self, stiffness: f64, offset: f64, registration: f64) -> Self {
        let mut random = Random::new(self.seed, random::NUISANCE);
        self.stiffness_error = std::array::from_fn(|_| stiffness * random.normal() + 0.0);
        self.encoder_offset = std::array::from_fn(|_| offset * random.normal() + 0.0);
        self.registration_per_log = registration;
        self
    }
}

/// Why a campaign could not be written.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A fixture cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// An effect cannot be installed.
    #[error(transparent)]
    Effect(#[from] EffectError),
    /// The stranger needs a state of its own and there is no room.
    #[error(transparent)]
    States(#[from] TooManyStates),
    /// The stranger leaves no possible robot.
    #[error("the stranger leaves no possible robot ({0:?})")]
    Model(ModelError),
    /// A posture has no equilibrium, or a motion diverged.
    #[error(transparent)]
    Links(#[from] Unsettled),
    /// A weld did not come to its end.
    #[error(transparent)]
    Weld(#[from] RunError),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] std::io::Error),
}

/// The truth of one campaign and what it is recorded with.
pub(crate) struct Laboratory<'a> {
    recipe: &'a Recipe,
    robot: RobotFile,
    process: Process,
    control: Control,
    sensors: Sensors,
    /// The robot with what a stranger changes of its numbers.
    truth: Robot<f64>,
}

impl<'a> Laboratory<'a> {
    fn new(recipe: &'a Recipe) -> Result<Self, CampaignError> {
        let robot = RobotFile::read(fixture("robots/kr500-mt.toml"))?;
        let mut parameters = robot.parameters.clone();
        if let Some(stranger) = &recipe.stranger {
            stranger.change(&mut parameters);
        }
        Ok(Self {
            recipe,
            process: Process::read(fixture("processes/lap-weld-2024-t3.toml"))?,
            control: Control::read(fixture("control/kr500-mt.toml"))?,
            sensors: Sensors::read(fixture("sensors/kr500-mt.toml"))?,
            truth: Robot::new(parameters).map_err(CampaignError::Model)?,
            robot,
        })
    }

    /// The true cell of one log, welding in the frame `b_from_w` with the spindle at `spindle`,
    /// rad/s. `log` numbers the log: the tracker is set up anew for each.
    fn cell(&self, log: u64, b_from_w: Pose<f64>, spindle: f64) -> Result<Cell, CampaignError> {
        let recipe = self.recipe;
        let mut effects = recipe.effects.clone();
        for i in 0..JOINTS {
            let at = Location::Joint(i);
            if recipe.stiffness_error[i] != 0.0 {
                effects.push(effect("stiffness-error", at, &[recipe.stiffness_error[i]]));
            }
            if recipe.encoder_offset[i] != 0.0 {
                effects.push(effect("encoder-offset", at, &[recipe.encoder_offset[i]]));
            }
        }
        if recipe.registration_per_log != 0.0 {
            let mut random = Random::new(recipe.seed, random::REGISTRATION + log);
            let sd = |k: usize| recipe.registration_per_log * if k < 3 { 1.0 } else { 0.5 };
            let motion: Vec<f64> = (0..6).map(|k| sd(k) * random.normal()).collect();
            effects.push(effect("tracker-registration", Location::Cell, &motion));
        }
        let process = Process { spindle, ..self.process.clone() };
        let mut cell = Cell::new(&self.truth, &effects, &process, b_from_w)?;
        if let Some(stranger) = &recipe.stranger {
            stranger.install(&mut cell)?;
        }
        Ok(cell)
    }

    fn instruments(&self, log: u64) -> CampaignNoise {
        CampaignNoise::new(self.recipe, Random::new(self.recipe.seed, random::NOISE + log))
    }
}

/// Writes a campaign into a folder, with its held-out campaign in `holdout/`. The same recipe gives
/// the same bytes.
///
/// # Errors
/// [`CampaignError`].
pub fn write(recipe: &Recipe, folder: &Path) -> Result<(), CampaignError> {
    let laboratory = Laboratory::new(recipe)?;
    let logs = &recipe.logs;
    let main = Plan { logs: logs.clone(), held_out: false };
    // A shorter campaign somewhere else: other postures, other motions, another seam.
    let fewer = Logs {
        postures: logs.postures.div_ceil(2),
        rings: 0,
        free: 0.6 * logs.free,
        welds: logs.welds.min(1),
        ..logs.clone()
    };
    let held_out = Plan { logs: fewer, held_out: true };
    for (plan, folder) in [(&main, folder.to_owned()), (&held_out, folder.join("holdout"))] {
        std::fs::create_dir_all(&folder)?;
        write_atomically(
            folder.join("robot.toml"),
            &std::fs::read(fixture("robots/kr500-mt.toml"))?,
        )?;
        write_atomically(
            folder.join("process.toml"),
            &std::fs::read(fixture("processes/lap-weld-2024-t3.toml"))?,
        )?;
        let model = "schema = \"model/1\"\nrobot = \"robot.toml\"\nprocess = \"process.toml\"\n";
        write_atomically(folder.join("model.toml"), model.as_bytes())?;
        let names = plan.write(&laboratory, &folder)?;
        let list = names.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
        let what = if plan.held_out { ", held out" } else { "" };
        let text = format!(
            "# Simulated measurements{what}, seed {}.\nschema = \"campaign/1\"\nmodel = \"model.toml\"\nlogs = [{list}]\n",
            recipe.seed
        );
        write_atomically(folder.join("campaign.toml"), text.as_bytes())?;
    }
    write_atomically(folder.join("truth.toml"), truth(recipe, &laboratory.robot).as_bytes())?;
    Ok(())
}

/// What was built in, in words of a file.
fn truth(recipe: &Recipe, robot: &RobotFile) -> String {
    let verdict = match (&recipe.stranger, recipe.effects.is_empty()) {
        (Some(_), _) => "unknown-effect",
        (None, false) => "effect-found",
        (None, true) => "adequate",
    };
    let mut text = format!(
        "# What was built into this campaign.\nschema = \"truth/1\"\nverdict = \"{verdict}\"\nseed = {}\nnoise = {:?}\n\
         noise_stated = {}\n\n[nuisance]\nstiffness_relative = {:?}\nencoder_offset_rad = {:?}\n\
         registration_per_log_m = {:?}\n",
        recipe.seed,
        recipe.noise,
        recipe.noise_stated,
        recipe.stiffness_error,
        recipe.encoder_offset,
        recipe.registration_per_log
    );
    let mut line =
        |what: std::fmt::Arguments<'_>| writeln!(text, "{what}").expect("a string takes all");
    for effect in &recipe.effects {
        line(format_args!("\n[[effect]]\nid = \"{}\"", effect.kind.id));
        match (effect.at, effect.kind.place) {
            (Location::Joint(i), _) => line(format_args!("at = \"{}\"", robot.joint_names[i])),
            (Location::Channel(channel), LocationKind::Channel) => {
                line(format_args!("at = \"{}\"", channel_name(channel)))
            }
            _ => {}
        }
        for (parameter, value) in effect.kind.parameters.iter().zip(&effect.values) {
            line(format_args!("{} = {value:?}", parameter.name));
        }
    }
    if let Some(stranger) = &recipe.stranger {
        line(format_args!(
            "\n[stranger]\nname = \"{}\"\nequation = \"{}\"",
            stranger.what.name(),
            stranger.what.equation()
        ));
        line(format_args!(
            "at = \"{}\"\nsize = {:?}",
            robot.joint_names[stranger.joint], stranger.size
        ));
    }
    text
}

/// What an effect is at, as files and people write it; nothing for the whole cell.
pub(crate) fn at_name(effect: &Effect) -> String {
    match effect.at {
        Location::Joint(i) => format!("A{}", i + 1),
        Location::Channel(channel) => channel_name(channel).to_owned(),
        Location::Cell => String::new(),
    }
}

fn channel_name(channel: Channel) -> &'static str {
    match channel {
        Channel::Tracker => "tracker",
        Channel::Wrench => "wrench",
        Channel::MotorTorque => "torque",
        Channel::LinkEncoder => "link-encoder",
    }
}
