//! What the runs of a certification come to: the certificate as data.

use super::judge::{AcceptedFault, Evidence, EvidenceKind, Requirement, Verdict, WeakPoint};
use super::sensitivity::Sensitivity;
use super::{ShownRun, Trial};
use crate::figure::Limit;
use crate::uncertain::UncertainCell;
use trueweld_plant::input::{Process, Weld};
use trueweld_plant::provenance::{FileDigest, Provenance};

/// A finished certification.
#[derive(Debug, Clone)]
pub struct Certificate {
    /// Name of the law.
    pub law: String,
    /// Name of the controller.
    pub controller: &'static str,
    /// Welds of one seam in a trial, the law kept.
    pub passes: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Share of welds that may fail, and the confidence with which that must be shown.
    pub asked: [f64; 2],
    /// Every weld.
    pub welds: Vec<CertifiedWeld>,
    /// What is not known of the cell.
    pub uncertain: UncertainCell,
    /// The files in which every run is kept, by their names in the evidence folder.
    pub files: Vec<FileDigest>,
    /// How many runs were kept before.
    pub kept: usize,
    /// How many of them were made again, and came out as they were kept.
    pub repeated: usize,
    /// What the certificate is of.
    pub provenance: Provenance,
}

impl Certificate {
    /// Of every requirement of every weld together.
    pub fn verdict(&self) -> Verdict {
        Verdict::of(self.welds.iter().flat_map(|weld| &weld.requirements))
    }
}

/// What one weld's runs came to.
#[derive(Debug, Clone)]
pub struct CertifiedWeld {
    /// Name of the weld.
    pub name: String,
    /// How it is planned.
    pub planned: WeldPlan,
    /// Every run.
    pub evidence: Evidence,
    /// The requirements, judged.
    pub requirements: Vec<Requirement>,
    /// Limits that corrections are held to anyway: they show nothing, and are not judged.
    pub held: Vec<Limit>,
    /// What is not required of faults.
    pub accepted_faults: Vec<AcceptedFault>,
    /// What the failures follow from.
    pub sensitivities: Vec<Sensitivity>,
    /// What is weak and not forbidden.
    pub weak_points: Vec<WeakPoint>,
    /// Runs that pages show.
    pub shown: Vec<ShownRun>,
    /// The same trials with what is assumed of measured numbers, where both are compared.
    pub assumed: Option<AssumedDraws>,
}

impl CertifiedWeld {
    /// The limit of a requirement, by its figure's key, in the figure's unit.
    pub fn limit(&self, case: EvidenceKind, name: &str) -> Option<f64> {
        let of = self.requirements.iter().find(|r| r.case == case && r.name == name);
        of.map(|requirement| requirement.limit)
    }
}

/// How a weld is planned, in the numbers that somebody who welds knows it by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeldPlan {
    /// Length, with the way beyond the seam's end, m.
    pub length: f64,
    /// Least and largest speed along the seam, m/s.
    pub feed: [f64; 2],
    /// Push, N.
    pub push: f64,
    /// Depth of the tool at the start, m.
    pub depth: f64,
    /// Lead and tilt of the tool, rad.
    pub lean: [f64; 2],
    /// Speed of the spindle about the tool's axis, rad/s.
    pub spindle: f64,
    /// Diameter of the pin, m.
    pub pin: f64,
    /// Drag along the seam and force across it that the process has at this push and the largest
    /// feed, N.
    pub drag: [f64; 2],
}

impl WeldPlan {
    /// The plan of a weld with a process.
    pub fn of(weld: &Weld, process: &Process) -> Self {
        let feeds = || weld.feeds.iter().map(|(_, feed)| *feed).chain([weld.feed]);
        let feed = [feeds().fold(f64::INFINITY, f64::min), feeds().fold(0.0, f64::max)];
        let length = weld.path.as_ref().map_or((weld.end - weld.start).norm(), |p| p.length());
        Self {
            length: length + weld.run_out,
            feed,
            push: weld.force,
            depth: weld.initial_depth,
            lean: weld.lean,
            spindle: process.spindle,
            pin: process.model.tool_diameter(),
            drag: process.model.planned_drag(process.spindle, weld.force, feed[1]),
        }
    }
}

/// Drawn cells in which measured numbers are as the requirements assume them.
#[derive(Debug, Clone)]
pub struct AssumedDraws {
    /// Every run.
    pub trials: Vec<Trial>,
    /// The requirements on draws, judged.
    pub requirements: Vec<Requirement>,
}
