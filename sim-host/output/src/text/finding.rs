//! What is said of a residual that follows a condition.

use super::{Scale, listed, share};
use trueweld_estimate::predict::ComparedQuantity;
use trueweld_estimate::residuals::localize::{
    ARRANGEMENTS, Category, Finding, ResidualMap, RowCondition, Statistic,
};

/// The name of a condition.
pub(crate) fn variable(variable: RowCondition, joints: &[String]) -> String {
    match variable {
        RowCondition::Time => "time".to_owned(),
        RowCondition::Angle(j) => format!("{} angle", joints[j]),
        RowCondition::Wave { joint, order } => {
            format!("{} angle, {order} periods a turn", joints[joint])
        }
        RowCondition::Rate(j) => format!("{} rate", joints[j]),
        RowCondition::Acceleration(j) => format!("{} acceleration", joints[j]),
        RowCondition::Motion(j) => format!("direction of {}'s motion", joints[j]),
        RowCondition::SpringTorque(j) => format!("{} spring torque", joints[j]),
        RowCondition::SpringSign(j) => format!("sign of {}'s spring torque", joints[j]),
        RowCondition::SpringTendency(j) => format!("trend of {}'s spring torque", joints[j]),
        RowCondition::Payload => "payload".to_owned(),
        RowCondition::Load => "load on the tool".to_owned(),
        RowCondition::LoadTendency => "trend of the load".to_owned(),
        RowCondition::Path => "path position".to_owned(),
        RowCondition::Log => "log".to_owned(),
        RowCondition::Joint => "joint".to_owned(),
        RowCondition::Direction => "Cartesian direction".to_owned(),
        RowCondition::SpindleOrder => "spindle order".to_owned(),
        RowCondition::Offset => "constant offset".to_owned(),
        RowCondition::Frequency => "frequency".to_owned(),
    }
}

/// A condition as it stands in a sentence: with its article, or as the joint's own.
pub(crate) fn article(condition: RowCondition, joints: &[String]) -> String {
    let name = variable(condition, joints);
    match condition {
        RowCondition::Offset => format!("a {name}"),
        RowCondition::Log => "which log it is".to_owned(),
        RowCondition::Frequency => name,
        RowCondition::Angle(j)
        | RowCondition::Wave { joint: j, .. }
        | RowCondition::Rate(j)
        | RowCondition::Acceleration(j)
        | RowCondition::SpringTorque(j) => {
            let joint = &joints[j];
            format!("{joint}'s{}", &name[joint.len()..])
        }
        _ => format!("the {name}"),
    }
}

/// The name of a category.
pub(crate) fn category(category: Category, finding: &Finding) -> String {
    match category {
        Category::Negative => "negative".to_owned(),
        Category::AtRest => "at rest".to_owned(),
        Category::Positive => "positive".to_owned(),
        Category::Falling => "falling".to_owned(),
        Category::Steady => "steady".to_owned(),
        Category::Rising => "rising".to_owned(),
        Category::Log(k) => finding.logs[k].clone(),
        Category::Joint(j) => finding.joints[j].clone(),
        Category::Direction(c) => direction(c).to_owned(),
        Category::SpindleOrder(0) => "slow".to_owned(),
        Category::SpindleOrder(order) => format!("order {order}"),
        Category::Series(quantity, column) => series(quantity, column, &finding.joints),
    }
}

/// A Cartesian direction.
pub(crate) fn direction(component: u8) -> &'static str {
    ["x", "y", "z"][usize::from(component).min(2)]
}

/// What people call a compared series of a channel.
pub(crate) fn series(quantity: ComparedQuantity, column: u8, joints: &[String]) -> String {
    match quantity {
        ComparedQuantity::LinkEncoder | ComparedQuantity::MotorTorque => {
            joints[usize::from(column)].clone()
        }
        ComparedQuantity::Ripple { order, sine } => {
            let part = if sine { "sine" } else { "cosine" };
            format!("{}, spindle order {order}, {part}", direction(column))
        }
        _ => direction(column).to_owned(),
    }
}

/// Name of the abscissa of a finding's curve.
pub(crate) fn x_name(finding: &Finding) -> String {
    match finding.variable {
        RowCondition::Offset => "column".to_owned(),
        condition => variable(condition, &finding.joints),
    }
}

/// Name of the ordinate of a finding's curve, with the series that is drawn.
pub(crate) fn y_name(finding: &Finding) -> String {
    let drawn = match (finding.variable, finding.how) {
        (RowCondition::Frequency, _) => "squared residual over that of white noise",
        (_, Statistic::Mean) => "mean residual",
        (_, Statistic::Size) => "root mean square of the residual",
    };
    match finding.curve.series {
        Some((quantity, column)) => {
            format!("{drawn}, {}", series(quantity, column, &finding.joints))
        }
        None => drawn.to_owned(),
    }
}

/// The finding in a sentence.
pub(crate) fn sentence(finding: &Finding) -> String {
    let Finding { kind, channel, how, joints, .. } = finding;
    let p = match finding.p {
        p if p < 1.5 / (ARRANGEMENTS + 1) as f64 => {
            format!("p ≤ {:.3}", 1.0 / (ARRANGEMENTS + 1) as f64)
        }
        p => format!("p = {p:.3}"),
    };
    let explained = share(finding.share);
    let said = match (finding.variable, how) {
        (RowCondition::Offset, _) => {
            let column = finding.category.map(|c| category(c, finding)).unwrap_or_default();
            let y = worst(finding).map_or(String::new(), |y| format!(": {y} in {column}"));
            return format!(
                "{kind}, {channel}: {explained} of the squared residual is a constant offset ({p}){y}."
            );
        }
        (_, Statistic::Mean) => {
            format!(
                "{explained} of the squared residual follows {} ({p})",
                article(finding.variable, joints)
            )
        }
        (RowCondition::Frequency, Statistic::Size) => {
            let [low, high] = [finding.low, finding.high].map(|f| Scale::small("Hz").number(f));
            let [noise, there] = [finding.samples_there, finding.share_there].map(share);
            return format!(
                "{kind}, {channel}: {there} of the squared residual lies between {low} and {high} Hz, where white noise has \
                 {noise} ({p})."
            );
        }
        (_, Statistic::Size) => format!(
            "{} of the squared residual lies in {} of the samples, {} ({p})",
            share(finding.share_there),
            share(finding.samples_there),
            place(finding)
        ),
    };
    let most = match (how, worst(finding)) {
        (Statistic::Mean, Some(y)) => format!("; most {}: {y}", place(finding)),
        _ => String::new(),
    };
    let similar = match finding.similar.as_slice() {
        [] => String::new(),
        all => format!(
            "; nearly as much {}",
            listed(&all.iter().map(|v| article(*v, joints)).collect::<Vec<_>>(), "and")
        ),
    };
    let together = finding.map.as_ref().map_or(String::new(), |map| {
        let [x, y] = [map.x.variable, map.y.variable].map(|v| article(v, joints));
        format!("; {x} and {y} together {}", share(map.share))
    });
    format!("{kind}, {channel}: {said}{most}{similar}{together}.")
}

/// What a map of a residual over two conditions shows.
pub(crate) fn map_title(finding: &Finding, map: &ResidualMap) -> String {
    let (quantity, column) = map.series;
    format!(
        "{}, {}: mean residual in {}, {}, over two conditions",
        finding.kind,
        finding.channel,
        series(quantity, column, &finding.joints),
        Scale::small(quantity.unit()).unit
    )
}

/// Where a finding shows most.
fn place(finding: &Finding) -> String {
    let joint = |j: usize| &finding.joints[j];
    let condition = article(finding.variable, &finding.joints);
    if let Some(found) = finding.category {
        let name = category(found, finding);
        return match (finding.variable, found) {
            (RowCondition::Log | RowCondition::Joint, _) => format!("in {name}"),
            (RowCondition::Direction, _) => format!("along {name}"),
            (_, Category::SpindleOrder(0)) => "below the spindle's frequency".to_owned(),
            (RowCondition::SpindleOrder, _) => format!("at the spindle's {name}"),
            (RowCondition::Motion(j), Category::AtRest) => format!("while {} is at rest", joint(j)),
            (RowCondition::Motion(j), _) => format!("while {} moves in the {name} sense", joint(j)),
            (RowCondition::SpringTendency(j), _) => {
                format!("while {}'s spring torque is {name}", joint(j))
            }
            (RowCondition::LoadTendency, _) => format!("while the load is {name}"),
            _ => format!("where {condition} is {name}"),
        };
    }
    let scale = Scale::large(finding.variable.unit());
    let range =
        scale.with_unit(format!("{} to {}", scale.number(finding.low), scale.number(finding.high)));
    match finding.variable {
        RowCondition::Wave { .. } => format!("at a phase of {range}"),
        _ => format!("where {condition} is {range}"),
    }
}

/// The mean residual where it is largest, with its column.
fn worst(finding: &Finding) -> Option<String> {
    let curve = &finding.curve;
    let point = if finding.variable == RowCondition::Offset {
        curve.points.get(finding.low as usize)?
    } else if let Some(there) = finding.category {
        curve.points.iter().zip(&curve.categories).find(|(_, category)| **category == there)?.0
    } else {
        curve.points.iter().find(|p| p.x >= finding.low && p.x <= finding.high)?
    };
    let column = curve.series.map(|(quantity, column)| series(quantity, column, &finding.joints));
    let column = column.map_or(String::new(), |column| format!(" in {column}"));
    Some(format!("{}{column}", Scale::small(curve.y_unit).signed(point.y)))
}
