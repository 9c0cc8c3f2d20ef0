//! Studies of a cell: where to put a part, how far force, feed and offset can be driven, what a
//! weld's figures depend on, and what the published study shows.
//!
//! Everything is run on the plant itself or follows from the statics of the same model; seeds make
//! the same numbers on any number of threads.

mod envelope;
mod figures;
mod layout;
mod limits;
mod place;
mod sensitivity;
mod sobol;

pub use envelope::{EnvelopePoint, EnvelopeRun, envelopes, reachable};
pub use figures::{MARGINS_ASKED, study_figure};
pub use layout::{
    Allowance, Confirmation, ConfirmedWeld, LayoutTask, Limiting, OutOfReach, PlacedPart,
    PlacementRange, Range, RatedPlacement, SEAM_PLACES, WAY_FIGURES, as_filed, confirm,
    more_is_better, numbers, pareto, way_figure,
};
pub use limits::{Driven, FoundLimit, LimitProbe, LimitStudy};
pub use place::{ArmAlongSeam, Placement, RealArm, Workpiece, centred, shortened};
pub use sensitivity::{
    Derivative, FigureDerivatives, FigureIndices, GlobalSensitivity, Input, LocalSensitivity,
    SensitivityStudy, StudyRun,
};
pub use sobol::{DesignPoint, SobolIndex, WithInterval, indices};
