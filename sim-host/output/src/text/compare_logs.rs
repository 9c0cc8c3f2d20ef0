//! What is said of two logs of one experiment.

use super::{Scale, counted, fixed, listed, share};
use crate::CompareLogsReport;
use trueweld_core::spatial::rotation_vector;
use trueweld_estimate::residuals::compare::NOISE_FLOOR_SCORE;
use trueweld_logs::channel::LogChannel;
use trueweld_logs::pair::{
    ChannelDifference, ColumnDifference, DifferenceVariable, FollowedDifference, LogPair,
};
use trueweld_plant::input::RobotFile;

/// Joint or axis of a column.
pub(crate) fn column_name(
    channel: &ChannelDifference,
    column: &ColumnDifference,
    robot: &RobotFile,
) -> String {
    match channel.channel {
        LogChannel::LinkEncoder | LogChannel::MotorTorque => {
            robot.joint_names[column.component].clone()
        }
        _ => ["x", "y", "z"][column.component].to_owned(),
    }
}

/// True where noise is known and makes no such difference.
pub(crate) fn exceeds_noise(score: Option<f64>) -> bool {
    score.is_some_and(|score| score > NOISE_FLOOR_SCORE)
}

/// The finding in a sentence or two.
pub(crate) fn headline(report: &CompareLogsReport<'_>) -> String {
    let channels = &report.pair.channels;
    let names = |of: &dyn Fn(&&ChannelDifference) -> bool| -> Vec<&str> {
        channels.iter().filter(|c| of(c)).map(|c| c.channel.name()).collect()
    };
    let same = names(&|c| c.score().is_some() && !exceeds_noise(c.score()));
    let untold = names(&|c| c.score().is_none());
    let mut differing: Vec<&ChannelDifference> =
        channels.iter().filter(|c| exceeds_noise(c.score())).collect();
    differing.sort_by(|a, b| b.score().unwrap_or(0.0).total_cmp(&a.score().unwrap_or(0.0)));
    let mut parts = Vec::new();
    match differing.first() {
        None if untold.is_empty() => {
            parts.push("The two logs are the same within their noise.".to_owned());
        }
        None => {}
        Some(worst) => {
            let all: Vec<&str> = differing.iter().map(|c| c.channel.name()).collect();
            let scale = Scale::small(worst.channel.unit());
            let at = worst.worst().map_or(String::new(), |column| {
                let name = column_name(worst, column, &report.logs[0].robot);
                format!(", most in {name}{}", follows(column, worst, report))
            });
            parts.push(format!(
                "The two logs differ in {}: {} by {} RMS, {} times what noise makes of it{at}.",
                listed(&all, "and"),
                worst.channel.name(),
                scale.quantity(worst.rms()),
                fixed(worst.score().unwrap_or(0.0), 1)
            ));
            if !same.is_empty() {
                parts.push(format!("The same within noise: {}.", listed(&same, "and")));
            }
        }
    }
    if !untold.is_empty() {
        parts.push(format!(
            "Noise is not known, so that nothing says whether they differ: {}.",
            listed(&untold, "and")
        ));
    }
    parts.join(" ")
}

/// What a column's difference follows, as the rest of a clause; empty where nothing.
fn follows(
    column: &ColumnDifference,
    channel: &ChannelDifference,
    report: &CompareLogsReport<'_>,
) -> String {
    let scale = Scale::small(channel.channel.unit());
    let constant = column.mean[0].powi(2) / column.rms.powi(2);
    match &column.follows {
        Some(followed) if followed.share > constant => {
            format!(": {} of its square {}", share(followed.share), of(followed, scale, report))
        }
        _ if constant > 0.5 => {
            format!(
                ": {} of its square a constant {}",
                share(constant),
                scale.signed(column.mean[0])
            )
        }
        _ => String::new(),
    }
}

/// `follows the direction of A2 (+34 N·m)`.
pub(crate) fn of(
    followed: &FollowedDifference,
    scale: Scale,
    report: &CompareLogsReport<'_>,
) -> String {
    let size = scale.signed(followed.size);
    match followed.of {
        DifferenceVariable::Time => format!("follows time ({size} from begin to end)"),
        DifferenceVariable::Value => {
            let percent = super::signed_share(followed.size);
            format!("is in proportion to the value itself ({percent})")
        }
        DifferenceVariable::Direction(joint) => {
            let joint = &report.logs[0].robot.joint_names[joint];
            format!("follows the direction of {joint}'s motion ({size})")
        }
        DifferenceVariable::Payload => {
            format!("follows the payload ({size} from none to the largest)")
        }
    }
}

/// How the logs were brought together.
pub(crate) fn setting(report: &CompareLogsReport<'_>) -> String {
    let [first, second] = report.logs;
    let pair: &LogPair = report.pair;
    let mut sentences = vec![format!(
        "{} less {}, {}, {}.",
        second.path.display(),
        first.path.display(),
        first.kind.name(),
        counted(pair.rows, "row")
    )];
    if let Some(clock) = &pair.clock {
        sentences.push(format!(
            "Clocks aligned on the encoders: the second reads {:.4} s where the first reads 0 and gains {:.1} ppm; {} are left \
             between the paths.",
            clock.map.offset,
            1e6 * clock.map.drift,
            Scale::small("m").quantity(clock.left)
        ));
    }
    match pair.unmatched {
        [0, 0] => {}
        [first, second] => sentences.push(format!(
            "Not in the other: {} of the first, {} of the second.",
            counted(first, "row"),
            second
        )),
    }
    if let Some(moved) = &pair.tracker {
        let turn = rotation_vector(&moved.motion.rotation).norm();
        let turned = if moved.turned {
            format!(" and turned by {}", Scale::small("rad").quantity(turn))
        } else {
            ", a turn cannot be told from points on a line".to_owned()
        };
        sentences.push(format!(
            "The second tracker stands {} away{turned}; this is taken out.",
            Scale::small("m").quantity(moved.motion.position.norm())
        ));
    }
    sentences.push("Poses and second encoders are compared less what the encoders say.".to_owned());
    sentences.join(" ")
}
