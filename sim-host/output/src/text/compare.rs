//! What is said of a model against measurements.

use super::diagnose::spoken;
use super::{Scale, counted, digits, listed, score};
use std::path::Path;
use trueweld_estimate::residuals::compare::{
    ChannelComparison, Comparison, LogComparison, NOISE_FLOOR_SCORE, Notice,
};
use trueweld_logs::noise::Scatter;
use trueweld_plant::effects::{Effect, Parameter};

/// Findings that are told in words.
pub(crate) const TOLD_FINDINGS: usize = 3;

/// The result in a sentence or two.
pub(crate) fn headline(comparison: &Comparison) -> String {
    let worst = worst_channel(comparison).filter(|(_, channel)| channel.score > NOISE_FLOOR_SCORE);
    let which = worst.map_or(String::new(), |(log, channel)| {
        format!(
            " Worst: {} of {}, {} RMS, {} times its noise.",
            channel.name,
            log.name,
            Scale::small(channel.unit).quantity(channel.rmse),
            score(channel.score)
        )
    });
    let verdict = match (comparison.score <= NOISE_FLOOR_SCORE, worst) {
        (true, None) => "is as good as these measurements can tell",
        (true, Some(_)) => "is near the noise floor on the whole, but not everywhere",
        (false, _) => "is off by more than the noise: something in it is missing or wrong",
    };
    format!("Score {}: the model {verdict}.{which}", score(comparison.score))
}

/// What was compared, and what the score means.
pub(crate) fn setting(model: &Path, comparison: &Comparison) -> String {
    let stated = comparison
        .logs
        .iter()
        .flat_map(|log| &log.channels)
        .filter(|channel| channel.stated)
        .count();
    let all = comparison.logs.iter().map(|log| log.channels.len()).sum::<usize>();
    let noise = match stated {
        n if n == all => "as the logs state it",
        0 => "estimated from the recordings",
        _ => "partly stated by the logs, partly estimated from the recordings",
    };
    format!(
        "Model {}, {}, {} samples. {} Noise: {noise}, and what it does on its way through the model.",
        model.display(),
        counted(comparison.logs.len(), "log"),
        comparison.samples,
        super::error::score_is(&comparison.logs)
    )
}

/// The channel with the highest score, with its log.
pub(crate) fn worst_channel(
    comparison: &Comparison,
) -> Option<(&LogComparison, &ChannelComparison)> {
    let all = comparison
        .logs
        .iter()
        .flat_map(|log| log.channels.iter().map(move |channel| (log, channel)));
    all.max_by(|a, b| a.1.score.total_cmp(&b.1.score))
}

/// What a reader should know besides.
pub(crate) fn notes(notices: &[Notice]) -> Vec<String> {
    notices.iter().map(|notice| format!("Note: {}.", self::notice(notice))).collect()
}

/// A notice in a sentence without its full stop.
pub(crate) fn notice(notice: &Notice) -> String {
    match notice {
        Notice::Log { log, notice } => format!("{log}: {}", super::log::notice(notice)),
        Notice::Registered(found) => super::log_faults::registered(found),
        Notice::NoiseEstimated(logs) => format!(
            "the noise is not stated and was estimated from the recordings: {}; such readings are taken to be true to what is \
             usual of their instruments, where [accuracy] says nothing else",
            logs.join(", ")
        ),
        Notice::NoiseLarger(of) => format!(
            "{}: the scatter is taken for the noise; correct the line if the instrument is in order",
            scatter(of)
        ),
        Notice::NoiseSmaller(of) => format!(
            "{}, and what is left is small as well: with the line corrected smaller effects show",
            scatter(of)
        ),
        Notice::SingleLoad { log, row, time, share } => format!(
            "{log}: row {row} (t = {} s) alone makes {} of the squared residual that is left of this log; check its load and its \
             readings first",
            digits(*time, 4),
            super::share(*share)
        ),
        Notice::GearsAtStart { log, gears } => {
            let of = |(joint, state): &(String, f64)| format!("{joint} at {:.0} %", 100.0 * state);
            let gears: Vec<String> = gears.iter().map(of).collect();
            format!(
                "{log} begins with gears in the midst of their torque–twist loop, as what was seen tells: {}",
                listed(&gears, "and")
            )
        }
        Notice::ClockSettled { log, late } => format!(
            "{log}: the tracker's clock is not given; under this model the tracker is {:.3} ms {} than its clock, which was fitted to \
             both instruments' motion, says, and this is taken out",
            1e3 * late.abs(),
            if *late > 0.0 { "later" } else { "earlier" }
        ),
        Notice::PerLog { name, found } => {
            let of_log = |(log, effect): &(String, Effect)| {
                let values = effect.kind.parameters.iter().zip(&effect.values);
                let value = |(p, v): (&Parameter, &f64)| {
                    format!("{} {}", spoken(p), Scale::of_parameter(p).quantity(*v))
                };
                format!("{} in {log}", listed(&values.map(value).collect::<Vec<_>>(), "and"))
            };
            let found: Vec<String> = found.iter().map(of_log).collect();
            format!(
                "{name} is each log's own (scope = \"log\"), fitted to it, so that this part of the score is no test of the model: {}",
                found.join("; ")
            )
        }
        Notice::NotBounded(names) => format!(
            "not bounded by these logs, which say no more of it than its plausible range does: {}; the model has a value, [posterior] none",
            listed(names, "and")
        ),
        Notice::NoPosterior(why) => {
            format!("the model is written without [posterior], which `certify` draws from: {why}")
        }
    }
}

/// By how much a channel scatters, and what is stated.
fn scatter(of: &Scatter) -> String {
    let entry = [of.channel.noise_key(), of.channel.unit()];
    let scale = Scale::small(entry[1]);
    format!(
        "{}: {} scatters by {} from row to row; `{}` of [noise] states {}",
        of.logs.join(", "),
        of.channel.name(),
        scale.quantity(of.shown),
        entry[0],
        scale.quantity(of.stated)
    )
}

#[cfg(test)]
mod tests {
    use super::notice;
    use trueweld_estimate::residuals::compare::Notice;
    use trueweld_logs::channel::LogChannel;
    use trueweld_logs::noise::Scatter;

    #[test]
    fn noise_that_is_not_as_stated_is_told_with_its_line() {
        let logs = vec!["free".to_owned(), "weld".to_owned()];
        let (channel, shown) = (LogChannel::Position, 1.5e-4);
        let larger = Scatter { logs, channel, stated: 5e-5, shown };
        assert_eq!(
            notice(&Notice::NoiseLarger(larger)),
            "free, weld: tcp_position scatters by 0.150 mm from row to row; `tcp_position_m` of \
             [noise] states 0.0500 mm: the scatter is taken for the noise; correct the line if the \
             instrument is in order"
        );
    }
}
