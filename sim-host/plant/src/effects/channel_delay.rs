//! `channel-delay`: an instrument whose clock is late.
//!
//! The channel lags the encoders.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Channel, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "channel-delay",
    place: LocationKind::Channel,
    equation: "the channel lags the encoders by a time",
    shows: "an error in proportion to the rate of what the channel measures",
    experiment: "motion to and fro at several speeds",
    parameters: &[Parameter {
        name: "delay_s",
        role: Role::Size { step: 1e-3, neutral: 0.0 },
        unit: "s",
        meaning: "lag",
        low: -0.02,
        high: 0.1,
    }],
    action: Action::Channel(|v, channel| Box::new(ChannelDelay { channel, delay: v[0] })),
};

#[derive(Debug)]
struct ChannelDelay {
    channel: Channel,
    delay: f64,
}

impl Term for ChannelDelay {
    fn delay(&self, channel: Channel) -> f64 {
        if channel == self.channel { self.delay } else { 0.0 }
    }
}
