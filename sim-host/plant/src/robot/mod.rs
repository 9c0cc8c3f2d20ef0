//! The elastic robot and the ports where effects enter it.

mod elastic;
mod mounting;
mod ports;
mod tilt;

pub use elastic::{Drives, ElasticRobot, JointMemory, TiltMotion};
pub use mounting::mount;
pub(crate) use ports::remembers;
pub use ports::{
    Channel, INTERNAL_STATES, JointState, Memory, Port, Ports, ProcessPoint, Readings, Term,
    TooManyStates, ValueDerivative,
};
pub use tilt::{JointMotion, Tilts};
