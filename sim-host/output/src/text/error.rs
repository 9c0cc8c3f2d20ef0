//! What is said of errors in the units of what is measured.

use super::{Scale, share};
use trueweld_estimate::residuals::compare::LogComparison;
use trueweld_estimate::residuals::error::ChannelError;

/// What people call a channel.
pub(crate) fn channel(error: &ChannelError) -> &'static str {
    match (error.channel, error.ripple) {
        ("tcp_position", _) => "tool position",
        ("tcp_rotation", _) => "tool rotation",
        ("link_encoder", _) => "second encoders",
        ("motor_torque", _) => "motor torque",
        ("force", true) => "force at the spindle's orders",
        (other, _) => other,
    }
}

/// What a score is, where predictions of some channels are asked to be no more than so exact, or not.
pub(crate) fn score_is(logs: &[LogComparison]) -> &'static str {
    let asked = logs.iter().flat_map(|log| &log.channels).any(|channel| channel.accuracy > 0.0);
    match asked {
        true => {
            "Score: root mean square of (measured − predicted) over noise and accuracy together; 1.0 is \
             as good as asked for."
        }
        false => "Score: root mean square of (measured − predicted)/noise; 1.0 is the noise floor.",
    }
}

/// Every channel before and after a change.
pub(crate) fn pairs<'e>(
    before: &'e [ChannelError],
    after: &'e [ChannelError],
) -> Vec<(&'e ChannelError, &'e ChannelError)> {
    let same = |a: &ChannelError, b: &ChannelError| (a.channel, a.ripple) == (b.channel, b.ripple);
    before.iter().filter_map(|b| Some((b, after.iter().find(|a| same(a, b))?))).collect()
}

/// By how much a channel's squared error falls, over its noise and accuracy, summed over its values.
pub(crate) fn fall((before, after): &(&ChannelError, &ChannelError)) -> f64 {
    let floor = before.noise.powi(2) + before.accuracy.powi(2);
    (before.rmse.powi(2) - after.rmse.powi(2)) * before.samples as f64 / floor
}

/// How the channel changes that changes most: `the error of the tool position falls from 0.155 to
/// 0.0302 mm RMS (96 % of its square)`. `None` where no channel's error falls.
pub(crate) fn change(before: &[ChannelError], after: &[ChannelError]) -> Option<String> {
    let all = pairs(before, after);
    let (before, after) = all.into_iter().max_by(|a, b| fall(a).total_cmp(&fall(b)))?;
    let scale = Scale::small(before.unit);
    (after.rmse < before.rmse).then(|| {
        format!(
            "the error of the {} falls from {} to {} RMS ({} of its square)",
            channel(before),
            scale.number(before.rmse),
            scale.quantity(after.rmse),
            share(after.explained(before))
        )
    })
}
