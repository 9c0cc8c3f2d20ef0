//! `channel-delay`: an instrument whose clock is late.
//!
//! The channel lags the encoders.

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::{INSTRUMENT_NAMES, Location, LocationKind};
use super::parameter::Parameter;
use crate::robot::{Channel, Term};

pub(super) static CHANNEL_DELAY_EFFECT: EffectKind = EffectKind {
    id: "channel-delay",
    place: LocationKind::Channel,
    equation: "the channel lags the encoders by a time",
    shows: "an error in proportion to the rate of what the channel measures",
    experiment: "motion to and fro at several speeds",
    parameters: &[Parameter::size("delay_s", "s", "lag", 1e-3, [-0.02, 0.1])],
    sentence: "{instrument} {0?lags|leads} the encoders by {|0|}",
    curve: Curve::Quantity(
        &[ShownQuantity::parameter(0, "lag of the instrument")],
        &[CurveAxis::OfInstrument],
    ),
    drawn: Some(|d| {
        (Location::Channel(INSTRUMENT_NAMES[d.whole(0, 3)].1), vec![d.size * d.between(2e-3, 6e-3)])
    }),
    action: Action::Channel(|v, channel| Box::new(ChannelDelay { channel, delay: v[0] })),
    ..EffectKind::DEFAULT
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
