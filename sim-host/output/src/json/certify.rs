//! A certification.

use super::finite;
use crate::CertifyReport;
use crate::words::certify::{short_numbers, weak};
use crate::words::requirement::reason;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use trueweld_evaluate::certify::{
    AcceptedFault, CertifiedWeld, DriveUse, Evidence, FaultTrial, LimitedFigure, RareFailure,
    Requirement, SampledCell, Sensitivity, Trial, Verdict, WeakPoint, drawn_figure,
};
use trueweld_evaluate::margins::{CHANNEL_NAMES, Condition, Margin, Margins};
use trueweld_evaluate::{
    Distribution, DriveLoad, Group, ReplacedAssumption, SHORT_SOURCE, UncertainCell,
};
use trueweld_plant::input::FileKind;
use trueweld_plant::provenance::{FileDigest, Provenance, sha256};

/// What many welds of uncertain cells show of a compensation law.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CertifyResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "certify/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// `pass`, `not-shown` or `fail`, of all requirements together.
    pub verdict: String,
    /// What is weak although no requirement forbids it, in words: margins below what is customary,
    /// and searched cells beyond a limit. The headline of a pass names them.
    pub weak: Vec<String>,
    /// Name of the law.
    pub law: String,
    /// Name of the hybrid controller.
    pub controller: String,
    /// Welds of one seam in a trial; the last one counts.
    pub passes: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Whether the seed was given, in place of the one that follows from the inputs.
    pub seed_given: bool,
    /// Share of welds that may be beyond a limit.
    pub allowed_failure_probability: f64,
    /// Confidence with which that is to be shown.
    pub confidence: f64,
    /// Every number that the draws differ in.
    pub uncertain: Vec<UncertainRecord>,
    /// What was measured of the cell; `null` where all is assumed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measurement: Option<MeasurementRecord>,
    /// What the requirements assume of numbers that were measured: it is not drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub replaced: Vec<ReplacedAssumption>,
    /// What the draws take as known although it might not be.
    pub left_out: Vec<String>,
    /// The command line that comes to the same.
    pub repeat: String,
    /// The files in which every run is kept, in the folder of the certificate.
    pub kept: Vec<FileDigest>,
    /// Every requirement of every weld: those of the requirements file, and of every weld that it is
    /// the one that was asked for.
    pub requirements: Vec<JudgedRequirement>,
    /// What the runs of every weld came to.
    pub welds: Vec<WeldEvidence>,
    /// SHA-256 of all of the above: it finds a certificate that was damaged, or changed without
    /// computing it anew.
    pub sha256: String,
}

/// A number that the draws differ in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UncertainRecord {
    /// What it is.
    pub number: String,
    /// Its unit; `1` for a share or a ratio.
    pub unit: String,
    /// Whether it is a share by which the number differs from what the files of the cell state.
    pub relative: bool,
    /// How it is distributed, in the unit.
    pub distribution: Distribution,
    /// What it is uncertain with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<Group>,
    /// `measured`, together with all others that are, or `assumed`.
    pub basis: String,
    /// Who assumed it, or which logs measured it.
    pub source: String,
    /// The file that says so.
    pub file: String,
}

/// What was measured of a cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasurementRecord {
    /// Names of the logs.
    pub logs: Vec<String>,
    /// SHA-256 of the SHA-256 of every file of the logs, in their order.
    pub campaign_sha256: String,
    /// Score of the model where nothing was fitted; 1.0 is the noise floor.
    pub score: f64,
    /// Numbers whose values stand at the bound of what is possible.
    pub at_bound: Vec<String>,
    /// Numbers that the logs hardly determine.
    pub undetermined: Vec<String>,
    /// Numbers of which the logs say next to nothing: they are not among those measured.
    pub not_measured: Vec<String>,
}

/// What the trials come to by one requirement where measured numbers are as they are assumed, and as
/// they were measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoughtByMeasurement {
    /// Key of the figure.
    pub name: String,
    /// The most that is allowed, in the unit of the key.
    pub limit: f64,
    /// With what the requirements assume.
    pub assumed: DrawnFigure,
    /// With what was measured.
    pub measured: DrawnFigure,
}

/// A figure over drawn cells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DrawnFigure {
    /// Draws beyond the limit.
    pub beyond: usize,
    /// Largest probability of a weld beyond the limit that the draws leave open.
    pub failure_probability: f64,
    /// Between which 90 % of the draws lie; `null` where they come to no end.
    pub spread: [Option<f64>; 2],
}

/// One requirement, judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JudgedRequirement {
    /// Name of the weld.
    pub weld: String,
    /// Which runs it is judged by: `nominal`, `draws`, `rare`, `worst-case`, `margins` or `faults`.
    pub case: String,
    /// Key of the figure.
    pub name: String,
    /// The most that is allowed, of margins the least, in the unit of the key.
    pub limit: f64,
    /// What was reached; of draws what all but the allowed share stay within.
    pub achieved: Option<f64>,
    /// Confidence with which it is shown.
    pub confidence: f64,
    /// Draws beyond the limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beyond: Option<usize>,
    /// Largest probability of a weld beyond the limit that the draws leave open.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure_probability: Option<f64>,
    /// `pass`, `not-shown` or `fail`.
    pub verdict: String,
    /// Whether the verdict is `pass`.
    pub pass: bool,
    /// Why it is not met or not shown.
    pub reason: Option<String>,
}

/// What the runs of one weld came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeldEvidence {
    /// Name of the weld.
    pub name: String,
    /// Number of drawn cells.
    pub trials: usize,
    /// The cell as it is believed to be.
    pub nominal: TrialFigures,
    /// Drawn cells in which no weld was made.
    pub failed: Vec<UnfinishedTrial>,
    /// How rare a weld beyond any limit is, where that was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rare: Option<RareEvidence>,
    /// The worst cell that a search found.
    pub worst_case: WorstCell,
    /// What the drives gave in the steady part, A1 to A6.
    pub drives: Vec<DriveEvidence>,
    /// Limits of the requirements, by their keys, that corrections are held to by the control file:
    /// they show nothing, and are not judged.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub held_by_control: BTreeMap<String, f64>,
    /// The loop along the weld.
    pub margins: Vec<MarginPlace>,
    /// Instruments that fail, one at a time.
    pub faults: Vec<FaultRun>,
    /// What is not required of these.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_required: Vec<NotRequiredFigure>,
    /// What the measurement brought, where that was asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[serde(rename = "bought")]
    pub value_of_measurement: Vec<BoughtByMeasurement>,
    /// What the failures follow from: of the requirements that draws were beyond, or of the one
    /// that came closest to its limit.
    pub sensitivity: Vec<FigureSensitivity>,
    /// Margins that no requirement limits and that are smaller than is customary.
    pub weak_points: Vec<WeakMargin>,
}

/// What one drive gave in the steady part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DriveEvidence {
    /// Which, as in `A1`.
    pub drive: String,
    /// In the cell as it is believed to be.
    pub nominal: DriveLoad,
    /// The most in any drawn cell, number by number.
    pub drawn: DriveLoad,
    /// Drawn cells in which it stood at a limit of torque or speed.
    pub cells_at_limit: usize,
}

/// What the draws say of a requirement's dependence on the uncertain numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FigureSensitivity {
    /// Key of the figure.
    pub name: String,
    /// Draws beyond its limit.
    pub beyond: usize,
    /// Share of the variance of the figure's logarithm that the numbers explain.
    pub explained: f64,
    /// The numbers that matter beyond chance, the most important first.
    pub numbers: Vec<NumberInfluence>,
}

/// What one uncertain number has to do with a figure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NumberInfluence {
    /// The number, or the group that moves together.
    pub number: String,
    /// Share of the variance of the figure's logarithm.
    pub share: f64,
    /// How the figure follows it: `grows`, `falls`, `at-ends` or `in-middle`.
    pub trend: String,
    /// Draws beyond the limit were the number always in the middle of its range.
    pub beyond_without: usize,
}

/// A margin that is weak and not limited.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeakMargin {
    /// Key of the margin.
    pub name: String,
    /// The least along the weld, in the unit of the key.
    pub least: f64,
    /// What is customary at least.
    pub customary: f64,
    /// Path position, m.
    pub path_m: f64,
    /// What the drives' friction is taken for: `viscous`, `at-speed` or `full`.
    pub friction: String,
    /// Index of the drawn cell; `null` for the nominal one.
    pub draw: Option<u64>,
    /// Where the loop was opened.
    pub channel: String,
}

/// Figures of a run by their keys, or why it has none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum TrialFigures {
    /// SI units, units in the keys.
    Figures(BTreeMap<String, f64>),
    /// Why the weld was not made.
    Failed {
        /// The reason.
        failed: Option<String>,
    },
}

/// A drawn cell in which no weld was made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct UnfinishedTrial {
    pub trial: u64,
    pub why: String,
}

/// A subset simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RareEvidence {
    /// Probability of a weld beyond a limit that is allowed.
    pub allowed: f64,
    /// The probability; where `reached` is false that of the last level, which failures are rarer
    /// than.
    pub probability: f64,
    /// Its coefficient of variation.
    pub variation: f64,
    /// Whether cells beyond a limit were found.
    pub reached: bool,
    /// Runs beside the draws.
    pub runs: usize,
    /// Every level.
    pub levels: Vec<RareLevel>,
}

/// A level of a subset simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RareLevel {
    /// Least share of any limit in its cells; `null` in the first, which are the draws.
    pub from: Option<f64>,
    /// Cells.
    pub cells: usize,
    /// Share of them beyond the next level, of the last one beyond a limit.
    pub share: f64,
    /// Share of the moves that were accepted.
    pub acceptance: f64,
    /// By how much more correlation makes the variance of the share.
    pub correlation: f64,
}

/// The worst cell that a search found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WorstCell {
    /// Runs of the search.
    pub runs: usize,
    /// So many of them are beyond a limit.
    pub beyond: usize,
    /// Key of the figure that it is worst in.
    pub figure: String,
    /// That figure over its limit.
    pub of_limit: Option<f64>,
    /// The cell.
    pub cell: Option<SampledCell>,
    /// Its numbers of `[[uncertain]]`, by what they are.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, f64>,
    /// Its figures.
    pub figures: Option<TrialFigures>,
}

/// The loop at one place of the weld, with one slope of friction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MarginPlace {
    /// Path position, m.
    pub path_m: f64,
    /// Push there, N.
    pub push_n: f64,
    /// Feed there, m/s.
    pub feed_m_s: f64,
    /// Whether push and feed are still rising, or the tool has come to its end.
    pub ramp: bool,
    /// What the drives' friction is taken for: `viscous`, `at-speed` or `full`.
    pub friction: String,
    /// Index of the drawn cell; `null` for the nominal one.
    pub draw: Option<u64>,
    /// Largest magnitude of a closed-loop pole; `null` where the loop runs away.
    pub spectral_radius: Option<f64>,
    /// Whether only a limit holds the loop.
    pub held_at_a_limit: bool,
    /// Margins of every channel by its name; `null` where the loop is not stable.
    pub channels: Option<BTreeMap<String, LoopMargins>>,
    /// Disk margin of corrections and force all at once.
    pub disk: f64,
    /// Disk margin of all drives at once.
    pub drive_disk: f64,
    /// Damping of the position loop at the tool.
    pub passivity: LoopPassivity,
}

/// Margins of one channel with the others closed; `null` where there is no limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct LoopMargins {
    /// Largest factor on the gain.
    pub gain: Option<f64>,
    /// Smallest factor on the gain.
    pub fall: Option<f64>,
    pub phase_rad: Option<f64>,
    pub modulus: Option<f64>,
    pub delay_s: Option<f64>,
}

/// Damping that the position loop needs at the tool and that is there, N·s/m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct LoopPassivity {
    pub needed_ns_m: Option<f64>,
    pub there_ns_m: Option<f64>,
}

/// A figure of a fault that is not required, as it would be judged if it were.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NotRequiredFigure {
    /// Name of the fault.
    pub fault: String,
    /// Key of the figure.
    pub name: String,
    /// What it would have to stay within, in the unit of the key.
    pub limit: f64,
    /// The worst that was reached.
    pub achieved: Option<f64>,
    /// Whether it is within the limit all the same.
    pub pass: bool,
    /// Why it is not required, as the requirements state it.
    pub reason: String,
}

/// One instrument that fails for a while.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FaultRun {
    /// Name of the fault.
    pub name: String,
    /// The fault in words.
    pub fault: String,
    /// Index of the drawn cell; `null` for the nominal one.
    pub draw: Option<u64>,
    /// When it begins, s.
    pub from_s: f64,
    /// When it ends, s.
    pub until_s: f64,
    /// Time after its beginning at which the controller or the law first reported a fault, s;
    /// `null` where they did not while it lasted.
    pub reported_after_s: Option<f64>,
    /// The figure of the weld that was the largest share of its limit, in the unit of its key.
    pub worst_of_weld: Option<LimitedFigure>,
    /// Figures by their keys.
    pub figures: Option<BTreeMap<String, f64>>,
    /// Why there are none.
    pub failed: Option<String>,
}

impl CertifyResult {
    pub(crate) fn of(report: &CertifyReport<'_>) -> Self {
        let requirements = report.welds.iter().flat_map(|weld| {
            weld.requirements.iter().map(|r| JudgedRequirement::of(&weld.name, r))
        });
        let mut result = Self {
            schema: "certify/1".to_owned(),
            provenance: report.provenance.clone(),
            verdict: report.verdict().name().to_owned(),
            weak: weak(report),
            law: report.law.clone(),
            controller: report.controller.to_owned(),
            passes: report.passes,
            seed: report.seed,
            seed_given: report.seed_given,
            allowed_failure_probability: report.asked[0],
            confidence: report.asked[1],
            uncertain: UncertainRecord::all(report),
            measurement: report.uncertain.posterior.as_ref().map(|of| MeasurementRecord {
                logs: of.logs.clone(),
                campaign_sha256: of.campaign.clone(),
                score: of.score,
                at_bound: of.at_bound.clone(),
                undetermined: of.undetermined.clone(),
                not_measured: of.not_measured.clone(),
            }),
            replaced: report.uncertain.replaced.clone(),
            left_out: report.uncertain.left_out().to_vec(),
            repeat: report.repeat.clone(),
            kept: report.kept.clone(),
            requirements: requirements.collect(),
            welds: report
                .welds
                .iter()
                .map(|weld| WeldEvidence::of(weld, report.uncertain))
                .collect(),
            sha256: String::new(),
        };
        result.sha256 = result.seal();
        result
    }

    /// SHA-256 of this certificate without its own, as it is written.
    pub fn seal(&self) -> String {
        let unsealed = Self { sha256: String::new(), ..self.clone() };
        sha256(super::text(&unsealed).as_bytes())
    }
}

impl UncertainRecord {
    /// Those of the short keys, then those of `[[uncertain]]`, then those measured.
    pub(crate) fn all(report: &CertifyReport<'_>) -> Vec<Self> {
        let cell = report.uncertain;
        let file = |role: &str| {
            let file = report.provenance.files.iter().find(|file| file.role == role);
            file.map_or(String::new(), |file| file.file.clone())
        };
        let assumed = |number: String, unit: &str, relative, distribution, source: &str| Self {
            number,
            unit: unit.to_owned(),
            relative,
            distribution,
            group: None,
            basis: "assumed".to_owned(),
            source: source.to_owned(),
            file: file(FileKind::Requirements.name()),
        };
        let short = short_numbers(cell).into_iter().map(|(number, unit, [low, high])| {
            let distribution = Distribution::Uniform { low, high };
            assumed(number, unit, unit == "1", distribution, SHORT_SOURCE)
        });
        let logs = cell.posterior.as_ref().map(|of| {
            let campaign = of.campaign.get(..12).unwrap_or(&of.campaign);
            format!("logs {} of the campaign {campaign}", of.logs.join(", "))
        });
        let numbers = cell.numbers.iter().map(|n| {
            let group = n.group.clone();
            let of = assumed(n.name.clone(), n.unit, n.relative, n.distribution, &n.source);
            match &logs {
                Some(logs) if n.is_measured() => Self {
                    basis: "measured".to_owned(),
                    source: logs.clone(),
                    file: file(FileKind::Model.name()),
                    ..of
                },
                _ => Self { group, ..of },
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
            sorted.get(k).copied().and_then(finite)
        };
        Some(Self {
            beyond: draws.beyond,
            failure_probability: draws.failure_probability,
            spread: [at(0.05), at(0.95)],
        })
    }
}

impl BoughtByMeasurement {
    /// Of every requirement on draws; none where nothing was compared.
    pub(crate) fn all(weld: &CertifiedWeld) -> Vec<Self> {
        let Some(assumed) = &weld.assumed else { return Vec::new() };
        let of = |before: &Requirement| {
            let same = |r: &&Requirement| (r.case, r.name) == (before.case, before.name);
            let now = weld.requirements.iter().find(same)?;
            Some(Self {
                name: before.name.to_owned(),
                limit: before.limit,
                assumed: DrawnFigure::of(&assumed.requirements, before, &assumed.trials)?,
                measured: DrawnFigure::of(&weld.requirements, now, &weld.evidence.trials)?,
            })
        };
        assumed.requirements.iter().filter_map(of).collect()
    }
}

impl JudgedRequirement {
    fn of(weld: &str, requirement: &Requirement) -> Self {
        Self {
            weld: weld.to_owned(),
            case: requirement.case.name().to_owned(),
            name: requirement.name.to_owned(),
            limit: requirement.limit,
            achieved: finite(requirement.achieved),
            confidence: requirement.confidence,
            beyond: requirement.draws.map(|draws| draws.beyond),
            failure_probability: requirement.draws.map(|draws| draws.failure_probability),
            verdict: requirement.verdict.name().to_owned(),
            pass: requirement.verdict == Verdict::Pass,
            reason: reason(requirement),
        }
    }
}

impl TrialFigures {
    fn of(trial: &Trial) -> Self {
        match &trial.figures {
            Some(figures) => Self::Figures(figures.clone()),
            None => Self::Failed { failed: trial.failed.clone() },
        }
    }
}

impl WeldEvidence {
    fn of(weld: &CertifiedWeld, uncertain: &UncertainCell) -> Self {
        let evidence = &weld.evidence;
        let unfinished = evidence.trials.iter().filter_map(|trial| {
            Some(UnfinishedTrial { trial: trial.index, why: trial.failed.clone()? })
        });
        let worst = &evidence.worst;
        Self {
            name: weld.name.clone(),
            trials: evidence.trials.len(),
            nominal: TrialFigures::of(&evidence.nominal),
            failed: unfinished.collect(),
            rare: evidence.rare.as_ref().map(RareEvidence::of),
            worst_case: WorstCell {
                runs: worst.runs.len(),
                beyond: worst.beyond,
                figure: worst.name.to_owned(),
                of_limit: finite(worst.of_limit),
                cell: worst.worst.as_ref().map(|trial| trial.draw.clone()),
                numbers: worst.worst.as_ref().map_or(BTreeMap::new(), |trial| {
                    let values = uncertain.values(&trial.draw.latents);
                    uncertain.numbers.iter().map(|n| n.name.clone()).zip(values).collect()
                }),
                figures: worst.worst.as_ref().map(TrialFigures::of),
            },
            drives: DriveEvidence::all(evidence),
            held_by_control: weld
                .held
                .iter()
                .map(|limit| (limit.figure.key.to_owned(), limit.value))
                .collect(),
            margins: evidence.margins.iter().map(MarginPlace::of).collect(),
            faults: evidence.faults.iter().map(FaultRun::of).collect(),
            not_required: weld.accepted_faults.iter().map(NotRequiredFigure::of).collect(),
            value_of_measurement: BoughtByMeasurement::all(weld),
            sensitivity: weld.sensitivities.iter().map(FigureSensitivity::of).collect(),
            weak_points: weld.weak_points.iter().map(WeakMargin::of).collect(),
        }
    }
}

impl DriveEvidence {
    fn all(evidence: &Evidence) -> Vec<Self> {
        let of = |(joint, of): (usize, DriveUse)| Self {
            drive: format!("A{}", joint + 1),
            nominal: of.nominal,
            drawn: of.drawn,
            cells_at_limit: of.at_limit,
        };
        DriveUse::all(evidence).into_iter().enumerate().map(of).collect()
    }
}

impl RareEvidence {
    fn of(of: &RareFailure) -> Self {
        let levels = of.subset.levels.iter().map(|level| RareLevel {
            from: finite(level.from),
            cells: level.points,
            share: level.share,
            acceptance: level.acceptance,
            correlation: level.correlation,
        });
        Self {
            allowed: of.allowed,
            probability: of.subset.probability,
            variation: of.subset.variation,
            reached: of.subset.reached,
            runs: of.runs,
            levels: levels.collect(),
        }
    }
}

impl FigureSensitivity {
    fn of(of: &Sensitivity) -> Self {
        let numbers = of.influences.iter().map(|by| NumberInfluence {
            number: by.number.clone(),
            share: by.share,
            trend: by.trend.name().to_owned(),
            beyond_without: by.beyond_without,
        });
        Self {
            name: of.name.to_owned(),
            beyond: of.beyond,
            explained: of.explained,
            numbers: numbers.collect(),
        }
    }
}

impl WeakMargin {
    fn of(of: &WeakPoint) -> Self {
        Self {
            name: of.name.to_owned(),
            least: of.least,
            customary: of.customary,
            path_m: of.of.at.path,
            friction: of.of.friction.name().to_owned(),
            draw: of.of.draw,
            channel: of.channel.to_owned(),
        }
    }
}

impl MarginPlace {
    fn of(margins: &Margins) -> Self {
        let Condition { at, friction, draw } = margins.of;
        let one = |margin: &Margin| LoopMargins {
            gain: finite(margin.gain),
            fall: finite(margin.fall),
            phase_rad: finite(margin.phase),
            modulus: finite(margin.modulus),
            delay_s: finite(margin.delay),
        };
        let channels = margins.channels.map(|channels| {
            let named = CHANNEL_NAMES.iter().zip(&channels);
            named.map(|(name, margin)| ((*name).to_owned(), one(margin))).collect()
        });
        Self {
            path_m: at.path,
            push_n: at.push,
            feed_m_s: at.feed,
            ramp: at.ramp,
            friction: friction.name().to_owned(),
            draw,
            spectral_radius: finite(margins.spectral_radius),
            held_at_a_limit: margins.held,
            channels,
            disk: margins.disk[0],
            drive_disk: margins.disk[1],
            passivity: LoopPassivity {
                needed_ns_m: finite(margins.passivity.needed_ns_m),
                there_ns_m: finite(margins.passivity.there_ns_m),
            },
        }
    }
}

impl NotRequiredFigure {
    fn of(of: &AcceptedFault) -> Self {
        Self {
            fault: of.fault.clone(),
            name: of.judged.name.to_owned(),
            limit: of.judged.limit,
            achieved: finite(of.judged.achieved),
            pass: of.judged.verdict == Verdict::Pass,
            reason: of.reason.clone(),
        }
    }
}

impl FaultRun {
    fn of(trial: &FaultTrial) -> Self {
        Self {
            name: trial.name.clone(),
            fault: trial.fault.clone(),
            draw: trial.draw,
            from_s: trial.time[0],
            until_s: trial.time[1],
            reported_after_s: trial.detected,
            worst_of_weld: trial.worst.clone(),
            figures: trial.figures.clone(),
            failed: trial.failed.clone(),
        }
    }
}
