//! A certification.

use super::{finite, result};
use crate::CertifyReport;
use crate::text::certify::{short_numbers, weak};
use crate::text::requirement::reason;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use trueweld_evaluate::certify::{
    AcceptedFault, CertifiedWeld, DriveUse, FaultTrial, FigureValues, LimitedFigure, RareFailure,
    Requirement, SampledCell, Sensitivity, Trial, Verdict, WeakPoint, WorstCase, drawn_figure,
};
use trueweld_evaluate::margins::{Condition, FrictionSlope, Margins};
use trueweld_evaluate::{Distribution, Group, ReplacedAssumption, SHORT_SOURCE, UncertainCell};
use trueweld_plant::input::{FileKind, Posterior};
use trueweld_plant::provenance::{FileDigest, Provenance, sha256};

result! {
    /// What many welds of uncertain cells show of a compensation law.
    CertifyResult<'a> of (report: &'a CertifyReport) with {
        let requirements = report.certificate.welds.iter().flat_map(|weld| {
            weld.requirements.iter().map(|judged| JudgedRequirement::of(&weld.name, judged))
        });
        let welds = report.certificate.welds.iter();
        let cell = &report.certificate.uncertain;
    } {
        /// What the result is of.
        provenance: &'a Provenance = &report.certificate.provenance,
        /// `pass`, `not-shown` or `fail`, of all requirements together.
        verdict: Verdict = report.certificate.verdict(),
        /// What is weak although no requirement forbids it, in words: margins below what is customary,
        /// and searched cells beyond a limit. The headline of a pass names them.
        weak: Vec<String> = weak(report),
        /// Name of the law.
        law: &'a str = &report.certificate.law,
        /// Name of the hybrid controller.
        controller: &'a str = report.certificate.controller,
        /// Welds of one seam in a trial; the last one counts.
        passes: usize = report.certificate.passes,
        /// Seed of the draws.
        seed: u64 = report.certificate.seed,
        /// Whether the seed was given, in place of the one that follows from the inputs.
        seed_given: bool = report.seed_given,
        /// Share of welds that may be beyond a limit.
        allowed_failure_probability: f64 = report.certificate.asked[0],
        /// Confidence with which that is to be shown.
        confidence: f64 = report.certificate.asked[1],
        /// Every number that the draws differ in.
        uncertain: Vec<UncertainRecord> = UncertainRecord::all(report),
        /// What was measured of the cell; `null` where all is assumed.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        measurement: Option<&'a Posterior> = cell.posterior.as_ref(),
        /// What the requirements assume of numbers that were measured: it is not drawn.
        #[serde(default, skip_serializing_if = "<[_]>::is_empty")]
        replaced: &'a [ReplacedAssumption] = &cell.replaced,
        /// What the draws take as known although it might not be.
        left_out: &'a [String] = cell.left_out(),
        /// The command line that comes to the same.
        repeat: &'a str = &report.repeat,
        /// The files in which every run is kept, in the folder of the certificate.
        kept: &'a [FileDigest] = &report.certificate.files,
        /// Every requirement of every weld: those of the requirements file, and of every weld that it is
        /// the one that was asked for.
        requirements: Vec<JudgedRequirement<'a>> = requirements.collect(),
        /// What the runs of every weld came to.
        welds: Vec<WeldEvidence<'a>> = welds.map(|weld| WeldEvidence::of(weld, cell)).collect(),
        /// SHA-256 of all of the above: it finds a certificate that was damaged, or changed without
        /// computing it anew.
        sha256: String = String::new(),
    }
}

impl CertifyResult<'_> {
    pub(crate) const SCHEMA: &'static str = "certify/1";

    /// With its SHA-256.
    pub(crate) fn sealed(self) -> Self {
        Self { sha256: sha256(super::text(Self::SCHEMA, &self).as_bytes()), ..self }
    }
}

/// A number that the draws differ in.
#[derive(Clone, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(crate) struct UncertainRecord {
    /// What it is.
    pub number: String,
    /// Its unit; `1` for a share or a ratio.
    pub unit: &'static str,
    /// Whether it is a share by which the number differs from what the files of the cell state.
    pub relative: bool,
    /// How it is distributed, in the unit.
    pub distribution: Distribution,
    /// What it is uncertain with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<Group>,
    /// `measured`, together with all others that are, or `assumed`.
    pub basis: &'static str,
    /// Who assumed it, or which logs measured it.
    pub source: String,
    /// The file that says so.
    pub file: String,
}

/// What the trials come to by one requirement where measured numbers are as they are assumed, and as
/// they were measured.
#[derive(Clone, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(rename = "BoughtByMeasurement")]
pub(crate) struct ValueOfMeasurement {
    /// Key of the figure.
    pub name: &'static str,
    /// The most that is allowed, in the unit of the key.
    pub limit: f64,
    /// With what the requirements assume.
    pub assumed: DrawnFigure,
    /// With what was measured.
    pub measured: DrawnFigure,
}

/// A figure over drawn cells.
#[derive(Clone, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(crate) struct DrawnFigure {
    /// Draws beyond the limit.
    pub beyond: usize,
    /// Largest probability of a weld beyond the limit that the draws leave open.
    pub failure_probability: f64,
    /// Between which 90 % of the draws lie; `null` where they come to no end.
    #[schemars(with = "[Option<f64>; 2]")]
    pub spread: [f64; 2],
}

result! {
    /// One requirement, judged.
    JudgedRequirement<'a> of (of_weld: &'a str, requirement: &'a Requirement) {
        /// Name of the weld.
        weld: &'a str = of_weld,
        #[serde(flatten)]
        judged: &'a Requirement = requirement,
        /// Whether the verdict is `pass`.
        pass: bool = requirement.verdict == Verdict::Pass,
        /// Why it is not met or not shown.
        reason: Option<String> = reason(requirement),
    }
}

result! {
    /// What the runs of one weld came to.
    WeldEvidence<'a> of (weld: &'a CertifiedWeld, uncertain: &'a UncertainCell) with {
        let evidence = &weld.evidence;
        let unfinished = evidence.trials.iter().filter_map(|trial| {
            Some(UnfinishedTrial { trial: trial.index, why: trial.failed.as_deref()? })
        });
        let held = weld.held.iter().map(|limit| (limit.figure.key, limit.value));
    } {
        /// Name of the weld.
        name: &'a str = &weld.name,
        /// Number of drawn cells.
        trials: usize = evidence.trials.len(),
        /// The cell as it is believed to be.
        nominal: TrialFigures<'a> = TrialFigures::of(&evidence.nominal),
        /// Drawn cells in which no weld was made.
        failed: Vec<UnfinishedTrial<'a>> = unfinished.collect(),
        /// How rare a weld beyond any limit is, where that was asked for.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        rare: Option<&'a RareFailure> = evidence.rare.as_ref(),
        /// The worst cell that a search found.
        worst_case: WorstCell<'a> = WorstCell::of(&evidence.worst, uncertain),
        /// What the drives gave in the steady part, A1 to A6.
        drives: Vec<DriveUse> = DriveUse::all(evidence).into(),
        /// Limits of the requirements, by their keys, that corrections are held to by the control file:
        /// they show nothing, and are not judged.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        held_by_control: BTreeMap<&'a str, f64> = held.collect(),
        /// The loop along the weld.
        margins: &'a [Margins] = &evidence.margins,
        /// Instruments that fail, one at a time.
        faults: Vec<FaultRun<'a>> = evidence.faults.iter().map(FaultRun::of).collect(),
        /// What is not required of these.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        not_required: Vec<NotRequiredFigure<'a>> =
            weld.accepted_faults.iter().map(NotRequiredFigure::of).collect(),
        /// What the measurement brought, where that was asked for.
        #[serde(rename = "bought", default, skip_serializing_if = "Vec::is_empty")]
        value_of_measurement: Vec<ValueOfMeasurement> = ValueOfMeasurement::all(weld),
        /// What the failures follow from: of the requirements that draws were beyond, or of the one
        /// that came closest to its limit.
        sensitivity: &'a [Sensitivity] = &weld.sensitivities,
        /// Margins that no requirement limits and that are smaller than is customary.
        weak_points: Vec<WeakMargin<'a>> = weld.weak_points.iter().map(WeakMargin::of).collect(),
    }
}

result! {
    /// A margin that is weak and not limited.
    WeakMargin<'a> of (weak: &'a WeakPoint) with {
        let Condition { at, friction: slope, draw: cell } = weak.of;
    } {
        /// Key of the margin.
        name: &'a str = weak.name,
        /// The least along the weld, in the unit of the key.
        least: f64 = weak.least,
        /// What is customary at least.
        customary: f64 = weak.customary,
        /// Path position, m.
        path_m: f64 = at.path,
        /// What the drives' friction is taken for: `viscous`, `at-speed` or `full`.
        friction: FrictionSlope = slope,
        /// Index of the drawn cell; `null` for the nominal one.
        draw: Option<u64> = cell,
        /// Where the loop was opened.
        channel: &'a str = weak.channel,
    }
}

/// Figures of a run by their keys, or why it has none.
#[derive(Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum TrialFigures<'a> {
    /// SI units, units in the keys.
    Figures(&'a FigureValues),
    /// Why the weld was not made.
    Failed {
        /// The reason.
        failed: Option<&'a str>,
    },
}

/// A drawn cell in which no weld was made.
#[derive(Clone, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(crate) struct UnfinishedTrial<'a> {
    trial: u64,
    why: &'a str,
}

result! {
    /// The worst cell that a search found.
    WorstCell<'a> of (search: &'a WorstCase, uncertain: &'a UncertainCell) with {
        let worst = search.worst.as_ref();
        let named = worst.map_or(BTreeMap::new(), |trial| {
            let values = uncertain.values(&trial.draw.latents);
            uncertain.numbers.iter().map(|n| n.name.as_str()).zip(values).collect()
        });
    } {
        /// Runs of the search.
        runs: usize = search.runs.len(),
        /// So many of them are beyond a limit.
        beyond: usize = search.beyond,
        /// Key of the figure that it is worst in.
        figure: &'a str = search.name,
        /// That figure over its limit.
        of_limit: Option<f64> = finite(search.of_limit),
        /// The cell.
        cell: Option<&'a SampledCell> = worst.map(|trial| &trial.draw),
        /// Its numbers of `[[uncertain]]`, by what they are.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        numbers: BTreeMap<&'a str, f64> = named,
        /// Its figures.
        figures: Option<TrialFigures<'a>> = worst.map(TrialFigures::of),
    }
}

result! {
    /// A figure of a fault that is not required, as it would be judged if it were.
    NotRequiredFigure<'a> of (accepted: &'a AcceptedFault) with {
        let judged = &accepted.judged;
    } {
        /// Name of the fault.
        fault: &'a str = &accepted.fault,
        /// Key of the figure.
        name: &'a str = judged.name,
        /// What it would have to stay within, in the unit of the key.
        limit: f64 = judged.limit,
        /// The worst that was reached.
        achieved: Option<f64> = finite(judged.achieved),
        /// Whether it is within the limit all the same.
        pass: bool = judged.verdict == Verdict::Pass,
        /// Why it is not required, as the requirements state it.
        reason: &'a str = &accepted.reason,
    }
}

result! {
    /// One instrument that fails for a while.
    FaultRun<'a> of (trial: &'a FaultTrial) {
        /// Name of the fault.
        name: &'a str = &trial.name,
        /// The fault in words.
        fault: &'a str = &trial.fault,
        /// Index of the drawn cell; `null` for the nominal one.
        draw: Option<u64> = trial.draw,
        /// When it begins, s.
        from_s: f64 = trial.time[0],
        /// When it ends, s.
        until_s: f64 = trial.time[1],
        /// Time after its beginning at which the controller or the law first reported a fault, s;
        /// `null` where they did not while it lasted.
        reported_after_s: Option<f64> = trial.detected,
        /// The figure of the weld that was the largest share of its limit, in the unit of its key.
        worst_of_weld: Option<&'a LimitedFigure> = trial.worst.as_ref(),
        /// Figures by their keys.
        figures: Option<&'a FigureValues> = trial.figures.as_ref(),
        /// Why there are none.
        failed: Option<&'a str> = trial.failed.as_deref(),
    }
}

/// Basis of a number that was measured, and of one that was not.
pub(crate) const MEASURED: &str = "measured";
const ASSUMED: &str = "assumed";

impl UncertainRecord {
    /// Those of the short keys, then those of `[[uncertain]]`, then those measured.
    pub(crate) fn all(report: &CertifyReport) -> Vec<Self> {
        let cell = &report.certificate.uncertain;
        let file = |role: &str| {
            let file = report.certificate.provenance.files.iter().find(|file| file.role == role);
            file.map_or(String::new(), |file| file.file.clone())
        };
        let [requirements, model] =
            [FileKind::Requirements, FileKind::Model].map(|k| file(k.name()));
        let short = short_numbers(cell).into_iter().map(|(number, unit, [low, high])| Self {
            number,
            unit,
            relative: unit == "1",
            distribution: Distribution::Uniform { low, high },
            group: None,
            basis: ASSUMED,
            source: SHORT_SOURCE.to_owned(),
            file: requirements.clone(),
        });
        let logs = cell.posterior.as_ref().map(|of| {
            let campaign = of.campaign.get(..12).unwrap_or(&of.campaign);
            format!("logs {} of the campaign {campaign}", of.logs.join(", "))
        });
        let numbers = cell.numbers.iter().map(|n| {
            let measured = logs.as_ref().filter(|_| n.is_measured());
            let (basis, source, file) = match measured {
                Some(logs) => (MEASURED, logs, &model),
                None => (ASSUMED, &n.source, &requirements),
            };
            Self {
                number: n.name.clone(),
                unit: n.unit,
                relative: n.relative,
                distribution: n.distribution,
                group: n.group.clone().filter(|_| measured.is_none()),
                basis,
                source: source.clone(),
                file: file.clone(),
            }
        });
        short.chain(numbers).collect()
    }
}

impl DrawnFigure {
    fn of(judged: &[Requirement], requirement: &Requirement, trials: &[Trial]) -> Option<Self> {
        let draws = requirement.draws?;
        let figure = |trial| drawn_figure(judged, requirement, trial);
        let mut sorted: Vec<f64> = trials.iter().map(figure).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let k = (share * sorted.len().saturating_sub(1) as f64).round() as usize;
            sorted.get(k).copied().unwrap_or(f64::INFINITY)
        };
        Some(Self {
            beyond: draws.beyond,
            failure_probability: draws.failure_probability,
            spread: [at(0.05), at(0.95)],
        })
    }
}

impl ValueOfMeasurement {
    /// Of every requirement on draws; none where nothing was compared.
    pub(crate) fn all(weld: &CertifiedWeld) -> Vec<Self> {
        let Some(assumed) = &weld.assumed else { return Vec::new() };
        let all = &assumed.requirements;
        let assumed = |before| DrawnFigure::of(all, before, &assumed.trials);
        all.iter().filter_map(|before| Self::of(before, assumed(before)?, weld)).collect()
    }

    fn of(before: &Requirement, assumed: DrawnFigure, weld: &CertifiedWeld) -> Option<Self> {
        let same = |r: &&Requirement| (r.case, r.name) == (before.case, before.name);
        let now = weld.requirements.iter().find(same)?;
        let measured = DrawnFigure::of(&weld.requirements, now, &weld.evidence.trials)?;
        Some(Self { name: before.name, limit: before.limit, assumed, measured })
    }
}

impl<'a> TrialFigures<'a> {
    fn of(trial: &'a Trial) -> Self {
        match &trial.figures {
            Some(figures) => Self::Figures(figures),
            None => Self::Failed { failed: trial.failed.as_deref() },
        }
    }
}
