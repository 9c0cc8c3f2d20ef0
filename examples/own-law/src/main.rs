//! The program `trueweld` with a law and an effect of one's own beside those that it has.

use trueweld::prelude::*;

gains! {
    /// Gains, `[law.own-law]` of a control file.
    Gains {
        /// Bandwidth of the correction, rad/s.
        rate_rad_s: f64 = 2.0,
    }
}

/// Feed-forward, and the integral of what a seam sensor sees across the seam.
struct OwnLaw {
    share: f64,
    correction: f64,
}

impl Law<f64> for OwnLaw {
    const NAME: &'static str = "own-law";
    const SUMMARY: &'static str = "Feed-forward, and the integral of a seam sensor";
    const NEEDS: Needs = Needs { seam_sensor: true, ..Needs::NOTHING };
    type Gains = Gains;
    type Built = OuterIntegral<f64, Self>;

    fn build(gains: &Gains, setup: &Setup<f64>) -> Result<Self::Built, GainError> {
        require(gains.rate_rad_s > 0.0, "rate_rad_s", "a number above 0")?;
        let law = Self { share: gains.rate_rad_s * setup.period, correction: 0.0 };
        OuterIntegral::new(law, &setup.following, setup.period)
    }
}

impl Compensator<f64> for OwnLaw {
    fn reset(&mut self) {
        self.correction = 0.0;
    }

    fn demand(&mut self, robot: &Robot<f64>, seen: &Observation<'_, f64>) -> Demand {
        let across = seen.measurements.iter().filter(|m| m.is_usable() && m.along.linear.y > 0.0);
        self.correction -= across.map(|m| self.share * m.deviation).sum::<f64>();
        let mut demand = FeedForward.demand(robot, seen)?;
        demand.linear.y += self.correction;
        Ok(demand)
    }
}

/// A cable package that pulls a joint back.
static CABLE_DRAG: EffectKind = EffectKind {
    id: "cable-drag",
    place: LocationKind::Joint,
    equation: "torque on the link −(c tanh(θ̇/smoothing) + s θ)",
    shows: "the tool is drawn back towards the middle of the joint, by more the further it turns",
    experiment: "the joint turned to and fro over its range, tracker",
    parameters: &[
        Parameter::size("friction_nm", "N·m", "friction c", 20.0, [0.0, 500.0]),
        Parameter::size("stiffness_nm_rad", "N·m/rad", "stiffness s", 500.0, [0.0, 2e4]),
    ],
    sentence: "a cable drags on {joint}, with a friction of {0} and a stiffness of {1}",
    action: Action::LinkTorque(|v, at| {
        -(v[0] * (at.link_rate / at.smoothing).tanh() + v[1] * at.link)
    }),
    ..EffectKind::DEFAULT
};

fn main() -> trueweld::Result<()> {
    trueweld_cli::run(trueweld::Program::new().law::<OwnLaw>().effect(&CABLE_DRAG))
}
