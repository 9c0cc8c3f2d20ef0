//! What of a log an effect has a say in: what it cannot change is taken from another prediction.

use super::{Compared, ComparedQuantity, PreparedLog};
use trueweld_logs::log::LogKind;
use trueweld_plant::effects::{Action, Effect, Location};
use trueweld_plant::robot::{Channel, Port};

impl PreparedLog {
    /// True where this log compares what an instrument read, or is driven by it. `joint`: the
    /// joint that is asked for, where the instrument is one of each joint.
    pub fn measures(&self, instrument: Channel, joint: Option<usize>) -> bool {
        let of_joint = |c: &Compared| joint.is_none_or(|j| usize::from(c.component) == j);
        self.compared.iter().any(|c| match (instrument, c.quantity) {
            (Channel::Tracker, ComparedQuantity::Position | ComparedQuantity::Rotation) => true,
            (Channel::MotorTorque, ComparedQuantity::MotorTorque)
            | (Channel::LinkEncoder, ComparedQuantity::LinkEncoder) => of_joint(c),
            (Channel::Wrench, _) => self.force,
            _ => false,
        })
    }

    /// True where an effect can change anything that this log compares.
    pub fn concerns(&self, effect: &Effect) -> bool {
        let joint = if let Location::Joint(joint) = effect.at { Some(joint) } else { None };
        match (effect.kind.action, effect.port()) {
            (Action::Process(_), _) | (_, Some(Port::ProcessForce | Port::PlateSurface)) => {
                self.contact.as_ref().is_some_and(|contact| contact.has(effect))
            }
            (_, Some(Port::MotorFriction(_))) => self.measures(Channel::MotorTorque, None),
            (_, Some(Port::SensorChannel(instrument))) => self.measures(instrument, joint),
            (_, Some(Port::TimeBase)) => match effect.at {
                // A row at rest is what it is whenever it is read.
                _ if self.kind == LogKind::StaticLoad => false,
                Location::Channel(instrument) => self.measures(instrument, None),
                _ => true,
            },
            _ => true,
        }
    }

    /// True where nothing is measured of the joints: what gravity makes of a link that is mounted off
    /// shows there as a hundredth of how that moves the tool.
    pub(crate) fn sees_tool_alone(&self) -> bool {
        let of_joints = [Channel::MotorTorque, Channel::LinkEncoder];
        !of_joints.into_iter().any(|channel| self.measures(channel, None))
    }

    /// True where an effect can change how the links move in this log, and not only what is
    /// measured of it.
    pub(super) fn moves(&self, effect: &Effect) -> bool {
        let stands = self.standing.is_some();
        match (effect.kind.action, effect.port()) {
            (Action::Process(_), _) => false,
            (_, Some(Port::ProcessForce | Port::PlateSurface)) => false,
            // What friction remembers is kept with the motion.
            (_, Some(Port::MotorFriction(_))) => effect.remembers(),
            (_, Some(Port::SensorChannel(_) | Port::TimeBase)) => stands,
            _ => true,
        }
    }

    /// True where an effect can change what tracker and second encoders read.
    pub(super) fn shows_in_poses(&self, effect: &Effect) -> bool {
        self.moves(effect)
            || match effect.port() {
                Some(Port::SensorChannel(Channel::MotorTorque)) => false,
                Some(Port::SensorChannel(_)) => true,
                Some(Port::TimeBase) => effect.at != Location::Channel(Channel::MotorTorque),
                _ => false,
            }
    }

    /// True where an effect can change what motors or the force sensor read. A weld's forces follow
    /// from where the tool was seen, whatever the links did, but for how stiff gears are that
    /// remember, where one `remembers`.
    pub(super) fn shows_in_loads(&self, effect: &Effect, remembers: bool) -> bool {
        match (self.kind, effect.kind.action, effect.port()) {
            (LogKind::Weld, Action::Process(_), _) => true,
            (
                LogKind::Weld,
                _,
                Some(
                    Port::ProcessForce
                    | Port::PlateSurface
                    | Port::SensorChannel(_)
                    | Port::TimeBase,
                ),
            ) => true,
            (LogKind::Weld, _, Some(Port::SpringTorque(_))) => remembers,
            (LogKind::Weld, ..) => false,
            (
                _,
                _,
                Some(
                    Port::MotorFriction(_)
                    | Port::TimeBase
                    | Port::SensorChannel(Channel::MotorTorque),
                ),
            ) => true,
            _ => self.moves(effect),
        }
    }
}
