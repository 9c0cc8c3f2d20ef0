//! What the curve of an effect shows.

use super::finding::{direction, series};
use trueweld_diagnose::evidence::{Abscissa, EffectCurve, Ordinate};

/// What is shown.
pub(crate) fn title(curve: &EffectCurve, joints: &[String]) -> String {
    let over = match curve.x {
        Abscissa::SpindleOrder => "the spindle's orders".to_owned(),
        _ => x_name(curve, joints),
    };
    format!("{} over {over}", y_name(curve, joints))
}

/// Name of the variable.
pub(crate) fn x_name(curve: &EffectCurve, joints: &[String]) -> String {
    match curve.x {
        Abscissa::Time | Abscissa::TimeTo(_) => "time from the start of the log".to_owned(),
        Abscissa::SpringTorque(j) => format!("spring torque of {}", joints[j]),
        Abscissa::Angle(j) => format!("angle of {}", joints[j]),
        Abscissa::Phase(j, order) => {
            format!("angle of {} within one of {order:.1} periods a turn", joints[j])
        }
        Abscissa::Rate(j) => format!("rate of {}", joints[j]),
        Abscissa::Path => "path position".to_owned(),
        Abscissa::Feed => "feed".to_owned(),
        Abscissa::AxialForce => "axial force F_z on the tool".to_owned(),
        Abscissa::PushBySpindle => "push on the tool, signed as the spindle turns".to_owned(),
        Abscissa::Load => "force on the tool".to_owned(),
        Abscissa::ToolSpeed => "speed of the tool".to_owned(),
        Abscissa::Tool(i) => format!("{} of the tool in the base frame", direction(i as u8)),
        Abscissa::SpindleOrder => "order of the spindle".to_owned(),
    }
}

/// Name of the quantity.
pub(crate) fn y_name(curve: &EffectCurve, joints: &[String]) -> String {
    match curve.y {
        Ordinate::Named(name, joint) => name.replace("{joint}", &joints[joint]),
        Ordinate::Column { quantity, component, without } => format!(
            "{}[{}] beyond what is predicted without {without}",
            quantity.channel(),
            series(quantity, component, joints)
        ),
        Ordinate::ForceAmplitude(component) => {
            let axis = direction(component);
            format!("amplitude of the force along {axis} of the tool beyond the model's")
        }
    }
}
