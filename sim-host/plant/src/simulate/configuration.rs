//! A scenario's controller as the constants that a controller is built from.

use super::{Scenario, Seam};
use trueweld_compensators::{
    CONFIGURATION_VERSION, Configuration, ConfigurationError, ControlNumbers, GainNumbers, Law,
    LawNumbers, LimitNumbers, RobotNumbers, RunningCore, Visitor, for_each,
};
use trueweld_core::Real;

/// Bytes that lie before a core in the memory of the C interface.
const BEFORE_A_CORE: usize = 48;

/// Memory is asked for in pieces of so many bytes: a field more in the core need not change it.
const PIECE: usize = 256;

/// Why a controller cannot be written as constants.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ConfigurationRefused {
    /// A law that is not of the table: a combination, or a law of one's own.
    #[error("the law {0} is none of the library's own, which alone are on the controller")]
    Law(String),
    /// A gain that is no number, or a law with more of them than fit.
    #[error("the gain {key} of the law {law} does not fit into the constants of a controller")]
    Gain {
        /// The law.
        law: String,
        /// The gain.
        key: String,
    },
    /// A controller that no core has.
    #[error("the controller {0} is none of a core's")]
    Controller(&'static str),
    /// A process that is not held by its push: a core's law acts while a push is asked for.
    #[error("a core's law acts while a push is asked for, and {0} bears none")]
    Process(&'static str),
    /// What a core says of it when it is built.
    #[error("no core can be built from it: {0:?}")]
    Core(ConfigurationError),
}

/// A controller's constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControllerConstants {
    /// What the core is built from.
    pub configuration: Configuration,
    /// Bytes of memory that the core takes through the C interface, at most: in `f32` and in `f64`.
    pub bytes: [usize; 2],
}

impl Scenario<'_> {
    /// The constants from which a controller builds what this scenario is run with: the robot as
    /// the controller believes it is, gains, limits and law. A core was built from them in both
    /// scalars.
    ///
    /// # Errors
    /// [`ConfigurationRefused`].
    pub fn constants(&self) -> Result<ControllerConstants, ConfigurationRefused> {
        if !self.planned.bears_push() {
            return Err(ConfigurationRefused::Process(self.planned.kind().name));
        }
        let configuration = Configuration {
            version: CONFIGURATION_VERSION,
            bytes: Configuration::BYTES,
            robot: RobotNumbers::of(self.controller_model.parameters()),
            control: self.control_numbers()?,
            law: self.law_numbers()?,
        };
        let bytes = [built::<f32>(&configuration), built::<f64>(&configuration)];
        let [single, double] =
            bytes.map(|b| b.unwrap_or(Err(ConfigurationRefused::Law(self.law.name().to_owned()))));
        Ok(ControllerConstants { configuration, bytes: [single?, double?] })
    }

    fn control_numbers(&self) -> Result<ControlNumbers, ConfigurationRefused> {
        let control = self.control;
        let controller = self.controller.entry();
        let (Some(core), Some(joint)) = (controller.core, (controller.joint)(control)) else {
            return Err(ConfigurationRefused::Controller(controller.name));
        };
        let (scheme, force) = core(control);
        Ok(ControlNumbers {
            scheme: scheme as u32,
            reserved: 0,
            period: control.period,
            position_kp: joint.kp.into(),
            position_ki: joint.ki.into(),
            position_kd: joint.kd.into(),
            force_kp: force.kp,
            force_ki: force.ki,
            force_kd: force.kd,
            force_max_correction: force.max_correction,
            force_max_rate: force.max_rate,
            material_stiffness: force.material_stiffness,
            tuned_stiffness: force.tuned_stiffness,
            lateral: LimitNumbers::of(&control.compensation.lateral),
            orientation: LimitNumbers::of(&control.compensation.orientation),
            force_sensor_moment: self.sensors.force.limits.moment,
            force_sensor_force: self.sensors.force.limits.force,
            force_sensor_disagreement: self.sensors.force.limits.disagreement,
        })
    }

    fn law_numbers(&self) -> Result<LawNumbers, ConfigurationRefused> {
        let law = self.law.name();
        let refused =
            |key: &str| ConfigurationRefused::Gain { law: law.to_owned(), key: key.to_owned() };
        let mut gains = Vec::new();
        for (key, value) in self.law.gains(&self.control.laws) {
            let numbers = match value.as_array() {
                Some(list) => list.iter().map(number).collect(),
                None => number(&value).map(|one| vec![one]),
            };
            let gain = numbers.and_then(|numbers| GainNumbers::new(&key, &numbers));
            gains.push(gain.ok_or_else(|| refused(&key))?);
        }
        let length = Seam::of(self.weld).length;
        LawNumbers::new(law, &gains, length, &self.control.compensation.following)
            .ok_or_else(|| refused("list"))
    }
}

fn number(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// Bytes that a core takes once it was built; `None` where the law is not of the table.
fn built<T: Real>(configuration: &Configuration) -> Option<Result<usize, ConfigurationRefused>> {
    struct Build<'a>(&'a Configuration, Option<Result<usize, ConfigurationRefused>>);
    impl<T: Real> Visitor<T> for Build<'_> {
        fn visit<L: Law<T>>(&mut self) {
            if self.0.law.name.as_str() == L::NAME {
                let core = RunningCore::<T, L::Built>::new::<L>(self.0);
                let bytes = (size_of_val(&core) + BEFORE_A_CORE).next_multiple_of(PIECE);
                self.1 = Some(core.map(|_| bytes).map_err(ConfigurationRefused::Core));
            }
        }
    }
    let mut build = Build(configuration, None);
    for_each::<T>(&mut build);
    build.1
}
