//! Where to put a part: every placement of a family looked at by statics and kinematics, the best one
//! searched between them, and confirmed by full runs.
//!
//! Reserves must be kept: of torque and speed, from collinear axes and from the joints' limits. Among
//! placements that keep them, the best one is that whose deviation or tilt takes the least share of
//! what it is allowed ([`Allowance`]), the largest share counting. Nothing is weighed against anything
//! else; what is traded for what is shown by the placements that no other one is better than in
//! everything ([`pareto`]).

use super::place::{ArmAlongSeam, Placement, RealArm, Workpiece, rolled};
use crate::figure::{Figure, FigureOf};
use crate::laws::NoFigures;
use crate::margins::{Margins, OperatingPoint, sector_margins};
use crate::weld::WeldFigures;
use rayon::prelude::*;
use trueweld_compensators::Entry;
use trueweld_core::{Branch, KinematicsError, Robot};
use trueweld_plant::cell::Cell;
use trueweld_plant::input::{Process, Weld};
use trueweld_plant::simulate::{Recording, RunError, Scenario, Seam, run_passes, start_angles};

/// Places along a seam at which the arm is looked at in the search, and where a placement is chosen.
pub const SEAM_PLACES: [usize; 2] = [21, 101];

/// Figures of a way along a seam.
pub static WAY_FIGURES: [FigureOf<ArmAlongSeam>; 10] = [
    FigureOf::new("lateral_max_m", "lateral, largest, by statics", "m", |way| {
        way.most(|at| at.displacement.linear.y.abs())
    }),
    FigureOf::new("along_max_m", "along the seam, largest, by statics", "m", |way| {
        way.most(|at| at.displacement.linear.x.abs())
    }),
    FigureOf::new("tilt_max_rad", "tilt, largest, by statics", "rad", |way| {
        way.most(|at| at.displacement.angular.x.hypot(at.displacement.angular.y))
    }),
    FigureOf::new("torque_share", "torque, largest share", "1", |way| {
        way.most(|at| largest(&at.torque))
    }),
    FigureOf::new("speed_share", "speed, largest share", "1", |way| {
        way.most(|at| largest(&at.speed))
    }),
    FigureOf::new("collinear_min_rad", "angle between axes 4 and 6, least", "rad", |way| {
        way.least(|at| at.collinearity)
    }),
    FigureOf::new("limit_min_rad", "angle to a joint's limit, least", "rad", |way| {
        way.least(|at| at.to_limit)
    }),
    FigureOf::new("stiffness_across_n_m", "stiffness across the seam, least", "N/m", |way| {
        way.least(|at| at.cartesian.y)
    }),
    FigureOf::new("stiffness_tool_n_m", "stiffness along the tool, least", "N/m", |way| {
        way.least(|at| at.cartesian.z)
    }),
    FigureOf::new("mode_min_rad_s", "first natural frequency, least", "rad/s", |way| {
        way.least(|at| at.mode_rad_s)
    }),
];

fn largest(of: &[f64]) -> f64 {
    of.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// The figure of a key, and its place in [`WAY_FIGURES`].
pub fn way_figure(key: &str) -> Option<(usize, &'static Figure)> {
    let found = WAY_FIGURES.iter().enumerate().find(|(_, of)| of.figure.key == key);
    found.map(|(k, of)| (k, &of.figure))
}

/// Figures of which more is better.
pub fn more_is_better(figure: usize) -> bool {
    figure >= 5
}

/// Figures that are a reserve, which must be kept; the others are what the weld is worth.
fn is_reserve(figure: usize) -> bool {
    figure >= 3
}

/// What a reserve that is not kept costs, over a deviation that takes as large a share.
const NOT_KEPT: f64 = 1e3;

/// What a figure may be: at most, or where more is better at least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowance {
    /// Place of the figure in [`WAY_FIGURES`].
    pub figure: usize,
    /// The limit, SI units.
    pub limit: f64,
}

impl Allowance {
    /// What is allowed of a weld with a pin of this diameter, m: what `weld` judges, a tenth of
    /// torque and speed in reserve, and axes 4 and 6 and the joints away from where they stop.
    pub fn usual(pin_diameter: f64) -> Vec<Self> {
        let limits = [
            0.5 * pin_diameter,
            pin_diameter,
            0.5_f64.to_radians(),
            0.9,
            0.9,
            10.0_f64.to_radians(),
            5.0_f64.to_radians(),
        ];
        limits.into_iter().enumerate().map(|(figure, limit)| Self { figure, limit }).collect()
    }

    /// The share of the allowed that is taken.
    fn share(&self, values: &[f64]) -> f64 {
        let value = values[self.figure];
        if more_is_better(self.figure) {
            self.limit / value.max(f64::MIN_POSITIVE)
        } else {
            value / self.limit
        }
    }
}

/// Values from one to another, evenly, in the unit of what is varied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// The first.
    pub low: f64,
    /// The last.
    pub high: f64,
    /// Between two of them; not used where the first is the last.
    pub step: f64,
}

impl Range {
    /// One value.
    pub fn at(value: f64) -> Self {
        Self { low: value, high: value, step: 0.0 }
    }

    /// The values.
    pub fn values(&self) -> Vec<f64> {
        if self.high <= self.low {
            return vec![self.low];
        }
        let count = ((self.high - self.low) / self.step + 1e-9).floor() as usize;
        (0..=count).map(|k| self.low + k as f64 * self.step).collect()
    }
}

/// Placements to choose from: a range of x, y, z, turn, inclination and roll.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacementRange(pub [Range; 6]);

impl PlacementRange {
    /// A placement by its six numbers.
    fn placement([x_m, y_m, z_m, turn_rad, incline_rad, roll_rad]: [f64; 6]) -> Placement {
        Placement { x_m, y_m, z_m, turn_rad, incline_rad, roll_rad }
    }

    /// How many placements its grid has.
    pub fn count(&self) -> usize {
        self.0.iter().map(|range| range.values().len()).product()
    }

    /// All placements of its grid, the last number running fastest.
    pub fn placements(&self) -> Vec<Placement> {
        let values = self.0.map(|range| range.values());
        let mut placements = Vec::with_capacity(self.count());
        for mut index in 0..self.count() {
            let mut numbers = [0.0; 6];
            for k in (0..6).rev() {
                numbers[k] = values[k][index % values[k].len()];
                index /= values[k].len();
            }
            placements.push(Self::placement(numbers));
        }
        placements
    }
}

/// The six numbers of a placement.
pub fn numbers(at: &Placement) -> [f64; 6] {
    [at.x_m, at.y_m, at.z_m, at.turn_rad, at.incline_rad, at.roll_rad]
}

/// A part to be placed.
#[derive(Debug, Clone, Copy)]
pub struct LayoutTask<'a> {
    /// The robot as the controller believes in it.
    pub robot: &'a Robot<f64>,
    /// The process as the welds are planned with it.
    pub planned: &'a Process,
    /// The part.
    pub part: &'a Workpiece,
    /// Where it may be put.
    pub family: &'a PlacementRange,
    /// What is allowed.
    pub allowed: &'a [Allowance],
}

/// The figure that takes the largest share of what it is allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limiting {
    /// Place of its allowance in [`LayoutTask::allowed`].
    pub allowance: usize,
    /// The share; above 1 it is not kept.
    pub share: f64,
}

/// A placement that the arm reaches.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedPart {
    /// Where.
    pub placement: Placement,
    /// The posture of every seam.
    pub branches: Vec<Branch>,
    /// [`WAY_FIGURES`], the worst of all seams.
    pub values: [f64; WAY_FIGURES.len()],
    /// Of deviation and tilt: what is made least where all reserves are kept.
    pub deviation: Limiting,
    /// Of the reserves.
    pub reserve: Limiting,
}

impl PlacedPart {
    /// Of everything that is allowed.
    pub fn limiting(&self) -> Limiting {
        if self.reserve.share > self.deviation.share { self.reserve } else { self.deviation }
    }

    /// What is made least: the share of deviation and tilt where all reserves are kept; else it is
    /// far above any such share, and the larger the less is kept.
    pub fn cost(&self) -> f64 {
        if self.reserve.share > 1.0 { NOT_KEPT * self.reserve.share } else { self.deviation.share }
    }
}

/// Why the arm does not hold its tool along a seam: how far it comes, m, and what stops it there.
pub type OutOfReach = (f64, KinematicsError);

/// A placement, and what it is worth.
#[derive(Debug, Clone, PartialEq)]
pub struct RatedPlacement {
    /// Where.
    pub placement: Placement,
    /// What it is worth.
    pub outcome: Result<PlacedPart, OutOfReach>,
}

impl LayoutTask<'_> {
    /// What a placement is worth: every seam in the posture that costs least.
    ///
    /// # Errors
    /// [`OutOfReach`].
    pub fn place(&self, at: &Placement, places: usize) -> Result<PlacedPart, OutOfReach> {
        self.place_with(at, places, |_, _| true)
    }

    /// The same in postures that `is` picks, by the seam's number.
    ///
    /// # Errors
    /// [`OutOfReach`].
    pub fn place_with(
        &self,
        at: &Placement,
        places: usize,
        is: impl Fn(usize, &ArmAlongSeam) -> bool,
    ) -> Result<PlacedPart, OutOfReach> {
        let robot =
            rolled(self.robot, at.roll_rad).map_err(|_| (0.0, KinematicsError::NotFinite))?;
        let mut part: Option<PlacedPart> = None;
        for (k, weld) in self.part.welds_at(at).iter().enumerate() {
            let ways = ArmAlongSeam::all(&robot, self.planned, weld, places)?;
            let of = ways.iter().filter(|way| is(k, way)).map(|way| self.worth(at, way));
            let best = of.reduce(|a, b| if b.cost() < a.cost() { b } else { a });
            let best = best.ok_or((0.0, KinematicsError::Unreachable))?;
            part = Some(match part {
                None => best,
                Some(others) => self.both(others, best),
            });
        }
        part.ok_or((0.0, KinematicsError::NotFinite))
    }

    /// The way of a seam in the posture of a branch.
    pub fn way(
        &self,
        at: &Placement,
        seam: usize,
        branch: Branch,
        places: usize,
    ) -> Option<ArmAlongSeam> {
        let robot = rolled(self.robot, at.roll_rad).ok()?;
        let weld = self.part.welds_at(at).into_iter().nth(seam)?;
        let ways = ArmAlongSeam::all(&robot, self.planned, &weld, places).ok()?;
        ways.into_iter().find(|way| way.branch == branch)
    }

    fn worth(&self, at: &Placement, way: &ArmAlongSeam) -> PlacedPart {
        let mut values = [0.0; WAY_FIGURES.len()];
        WAY_FIGURES.iter().zip(&mut values).for_each(|(of, value)| *value = (of.value)(way));
        self.shared(*at, vec![way.branch], values)
    }

    fn shared(
        &self,
        placement: Placement,
        branches: Vec<Branch>,
        values: [f64; WAY_FIGURES.len()],
    ) -> PlacedPart {
        let most = |reserve: bool| {
            let of =
                self.allowed.iter().enumerate().filter(|(_, a)| is_reserve(a.figure) == reserve);
            let shares = of.map(|(allowance, a)| Limiting { allowance, share: a.share(&values) });
            let none = Limiting { allowance: 0, share: 0.0 };
            shares.fold(none, |most, one| if one.share > most.share { one } else { most })
        };
        PlacedPart { placement, branches, values, deviation: most(false), reserve: most(true) }
    }

    /// Two seams of one part: the worse of every figure.
    fn both(&self, one: PlacedPart, other: PlacedPart) -> PlacedPart {
        let values = std::array::from_fn(|k| {
            let (a, b) = (one.values[k], other.values[k]);
            if more_is_better(k) { a.min(b) } else { a.max(b) }
        });
        let branches = one.branches.into_iter().chain(other.branches).collect();
        self.shared(one.placement, branches, values)
    }

    /// Every placement of the family's grid, on all cores.
    pub fn grid(&self, progress: impl Fn() + Sync) -> Vec<RatedPlacement> {
        let place = |at: &Placement| {
            let outcome = self.place(at, SEAM_PLACES[0]);
            progress();
            RatedPlacement { placement: *at, outcome }
        };
        self.family.placements().par_iter().map(place).collect()
    }

    /// The best placement within the family's ranges, between the points of its grid too: a pattern
    /// search from the best points of the grid, one number after the other, with steps that are
    /// halved where none makes it better. `None` where the grid has none that is reached.
    pub fn best(&self, grid: &[RatedPlacement]) -> Option<PlacedPart> {
        /// Points that the search begins at, how often its steps are halved, and from where on the
        /// arm is looked at closely.
        const LAYOUT_SEARCH_STARTS: usize = 4;
        const LAYOUT_STEP_HALVINGS: usize = 7;
        const CLOSE_LOOK_HALVING: usize = 4;
        let mut starts: Vec<&PlacedPart> =
            grid.iter().filter_map(|placed| placed.outcome.as_ref().ok()).collect();
        starts.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
        starts.truncate(LAYOUT_SEARCH_STARTS);
        let found = starts.into_par_iter().map(|start| {
            let mut best = start.clone();
            for halving in 0..LAYOUT_STEP_HALVINGS {
                let step = 0.5_f64.powi(halving as i32 + 1);
                while let Some(better) = self.better(&best, step, SEAM_PLACES[0]) {
                    best = better;
                }
            }
            best
        });
        // In the order of the starts: of equals the first.
        let found: Vec<PlacedPart> = found.collect();
        let best = found.into_iter().reduce(|a, b| if b.cost() < a.cost() { b } else { a })?;
        // What is told of it is looked at closely: a reserve may be kept at few places and not between.
        let mut best = self.place(&best.placement, SEAM_PLACES[1]).ok()?;
        for halving in CLOSE_LOOK_HALVING..LAYOUT_STEP_HALVINGS {
            let step = 0.5_f64.powi(halving as i32 + 1);
            while let Some(better) = self.better(&best, step, SEAM_PLACES[1]) {
                best = better;
            }
        }
        Some(best)
    }

    /// The best neighbour of a placement, where one is better.
    fn better(&self, than: &PlacedPart, step: f64, places: usize) -> Option<PlacedPart> {
        let here = numbers(&than.placement);
        let neighbours = (0..6).flat_map(|k| {
            let range = self.family.0[k];
            [-1.0, 1.0].map(|side| {
                let mut next = here;
                next[k] = (here[k] + side * step * range.step).clamp(range.low, range.high);
                next
            })
        });
        let neighbours = neighbours.filter(|next| *next != here);
        let placed =
            neighbours.filter_map(|n| self.place(&PlacementRange::placement(n), places).ok());
        let best = placed.reduce(|a, b| if b.cost() < a.cost() { b } else { a })?;
        // A gain that no one would move a part for ends the search.
        (best.cost() < than.cost() * (1.0 - 1e-4)).then_some(best)
    }
}

/// The placements that no other one is at least as good as in all of these figures, and better in
/// one.
pub fn pareto<'p>(all: &[&'p PlacedPart], figures: &[usize]) -> Vec<&'p PlacedPart> {
    let worth = |placed: &PlacedPart, k: usize| {
        if more_is_better(k) { -placed.values[k] } else { placed.values[k] }
    };
    let dominates = |a: &PlacedPart, b: &PlacedPart| {
        figures.iter().all(|k| worth(a, *k) <= worth(b, *k))
            && figures.iter().any(|k| worth(a, *k) < worth(b, *k))
    };
    let is_front = |one: &&&PlacedPart| !all.iter().any(|other| dominates(other, one));
    all.iter().filter(is_front).copied().collect()
}

/// A full run of a weld where it is put.
#[derive(Debug, Clone)]
pub struct ConfirmedWeld {
    /// Number of the seam.
    pub seam: usize,
    /// Name of the law.
    pub law: String,
    /// What came of it.
    pub outcome: Result<(WeldFigures, Recording), NoFigures>,
}

/// Full runs of a part where it is put, and the margins of its loop.
#[derive(Debug, Clone)]
pub struct Confirmation {
    /// What statics have of it.
    pub placed: PlacedPart,
    /// Runs, seam by seam with every law.
    pub welds: Vec<ConfirmedWeld>,
    /// Margins of the loop of the last law at both ends and in the middle of every seam.
    pub margins: Result<Vec<Margins>, RunError>,
}

/// Runs a part where it is put, with every law. `scenario`: everything but cell, weld and law.
pub fn confirm(
    task: &LayoutTask<'_>,
    scenario: &Scenario<'_>,
    arm: &RealArm<'_>,
    placed: &PlacedPart,
    laws: &[Entry],
    progress: impl Fn() + Sync,
) -> Confirmation {
    let jobs: Vec<(usize, &Entry)> = (0..placed.branches.len())
        .flat_map(|seam| laws.iter().map(move |law| (seam, law)))
        .collect();
    let weld = |(seam, law): &(usize, &Entry)| {
        let held = held(task, arm, placed, *seam).map_err(NoFigures::from);
        let outcome = held.and_then(|held| held.weld(arm, scenario, law));
        progress();
        ConfirmedWeld { seam: *seam, law: law.name().to_owned(), outcome }
    };
    let welds = jobs.par_iter().map(weld).collect();
    let of_seam = |seam: usize| -> Result<Vec<Margins>, RunError> {
        let Some(law) = laws.last() else { return Ok(Vec::new()) };
        held(task, arm, placed, seam)?.margins(arm, scenario, law)
    };
    let margins: Result<Vec<_>, RunError> = (0..placed.branches.len()).map(of_seam).collect();
    progress();
    Confirmation { placed: placed.clone(), welds, margins: margins.map(|all| all.concat()) }
}

/// A weld, and the arm that is held to a way along it.
struct HeldWeld {
    weld: Weld,
    /// The arm as it is, and as the controller believes in it.
    robots: [Robot<f64>; 2],
}

/// A seam of a placed part with the arm held to its posture.
fn held(
    task: &LayoutTask<'_>,
    arm: &RealArm<'_>,
    placed: &PlacedPart,
    seam: usize,
) -> Result<HeldWeld, RunError> {
    let at = &placed.placement;
    let reach = || RunError::Reach { path: 0.0, reason: "no posture welds there" };
    let way = task.way(at, seam, placed.branches[seam], SEAM_PLACES[1]).ok_or_else(reach)?;
    let weld = task.part.welds_at(at).into_iter().nth(seam).ok_or_else(reach)?;
    let robot = |of: &Robot<f64>| {
        rolled(of, at.roll_rad).and_then(|robot| way.held(&robot)).map_err(|_| RunError::Cell)
    };
    Ok(HeldWeld { weld, robots: [robot(arm.robot)?, robot(task.robot)?] })
}

impl HeldWeld {
    /// The weld's figures and its recording with a law.
    fn weld(
        &self,
        arm: &RealArm<'_>,
        scenario: &Scenario<'_>,
        law: &Entry,
    ) -> Result<(WeldFigures, Recording), NoFigures> {
        let cell = self.cell(arm, scenario.planned)?;
        let passes = if law.needs().passes { 2 } else { 1 };
        let recording = run_passes(&self.scenario(scenario, &cell, law), passes, |_| {})?;
        let figures = WeldFigures::of(&recording).ok_or(NoFigures::NotSteady)?;
        Ok((figures, recording))
    }

    /// Margins of the loop with a law at both ends and in the middle, without the process' ripple.
    fn margins(
        &self,
        arm: &RealArm<'_>,
        scenario: &Scenario<'_>,
        law: &Entry,
    ) -> Result<Vec<Margins>, RunError> {
        let still = Process { ripple: Vec::new(), ..scenario.planned.clone() };
        let cell = self.cell(arm, &still)?;
        let scenario = self.scenario(scenario, &cell, law);
        let length = Seam::of(&self.weld).length;
        let points =
            [0.0, 0.5, 1.0].map(|share| OperatingPoint::steady(&self.weld, share * length));
        let each: Result<Vec<_>, RunError> =
            points.par_iter().map(|at| sector_margins(&scenario, at)).collect();
        Ok(each?.concat())
    }

    fn cell(&self, arm: &RealArm<'_>, process: &Process) -> Result<Cell, RunError> {
        Cell::new(&self.robots[0], arm.effects, process, Seam::real(&self.weld))
            .map_err(|_| RunError::Cell)
    }

    fn scenario<'s>(&'s self, of: &Scenario<'s>, cell: &'s Cell, law: &'s Entry) -> Scenario<'s> {
        Scenario { cell, weld: &self.weld, controller_model: &self.robots[1], law, ..*of }
    }
}

/// What statics have of the part where its files put it, in the postures that a run takes there.
///
/// # Errors
/// [`OutOfReach`].
pub fn as_filed(task: &LayoutTask<'_>) -> Result<PlacedPart, OutOfReach> {
    let at = task.part.placement();
    let taken: Vec<Option<Branch>> = task
        .part
        .welds
        .iter()
        .map(|weld| {
            let start = start_angles(task.robot, &Seam::of(weld)).ok()?;
            task.robot.branch_of(&start).ok()
        })
        .collect();
    task.place_with(&at, SEAM_PLACES[1], |seam, way| taken[seam].is_none_or(|b| b == way.branch))
}
