//! The force on the tool of a recorded weld that its model does not explain, along the seam: what a
//! simulation of that weld is disturbed by.
//!
//! It is the slow force of [`residuals`](crate::residuals), measured less predicted, in axes of W. A
//! push that the force loop holds is left out along z: forces in the plane are predicted for the push
//! that was measured, and the simulated loop holds the push as the real one did.

use crate::predict::filled_vectors;
use crate::residuals::compare::{LogComparison, Trace};
use nalgebra::{Matrix3, Vector3};
use trueweld_core::spatial::rotation_from_vector;
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::Log;
use trueweld_plant::effects::formula::{CustomParameter, Definition, PORTS};
use trueweld_plant::effects::table::{DefinedTable, Places, TABLE_PLACES_MAX};
use trueweld_plant::effects::{Effect, Location};
use trueweld_plant::seam::SeamPosition;
use trueweld_plant::simulate::Seam;

/// Names of the axes of W.
pub const WELD_AXES: [&str; 3] = ["x", "y", "z"];

/// Compared rows that a place of the table stands for, at least.
const ROWS_A_PLACE: usize = 2;

/// Force that a fit would change a value of the table by, N.
const FORCE_STEP: f64 = 100.0;

/// Largest plausible value of the table, N.
const FORCE_RANGE: f64 = 1e5;

/// A force on the tool along the seam, axes of W.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceDisturbance {
    /// Places along the seam, rising, m.
    pub path: Vec<f64>,
    /// The force at each place, N.
    pub force: Vec<Vector3<f64>>,
    /// Root mean square of the residuals that it was made of, N.
    pub rms: Vector3<f64>,
    /// Root mean square of the noise in them, N.
    pub noise: Vector3<f64>,
}

/// A residual of the slow force, axes of W.
struct ForceResidual {
    path: f64,
    force: Vector3<f64>,
    variance: Vector3<f64>,
}

impl ForceDisturbance {
    /// Of the pieces of one log with their comparisons; `None` where their forces are not compared.
    pub fn of(logs: &[Log], compared: &[LogComparison]) -> Option<Self> {
        let mut residuals: Vec<ForceResidual> =
            logs.iter().zip(compared).flat_map(|(log, compared)| of_log(log, compared)).collect();
        residuals.sort_by(|a, b| a.path.total_cmp(&b.path));
        let count = residuals.len() as f64;
        let (first, last) = (residuals.first()?.path, residuals.last()?.path);
        let most = (residuals.len() / ROWS_A_PLACE).clamp(2, TABLE_PLACES_MAX);
        let step = (last - first) / (most - 1) as f64;
        if step <= 0.0 {
            return None;
        }
        let places = (0..most).map(|k| first + k as f64 * step);
        let (path, force) =
            places.filter_map(|at| Some((at, mean_near(&residuals, at, step)?))).unzip();
        let mean = |of: fn(&ForceResidual) -> Vector3<f64>| {
            residuals.iter().map(of).sum::<Vector3<f64>>() / count
        };
        let rms = mean(|r| r.force.component_mul(&r.force)).map(f64::sqrt);
        let noise = mean(|r| r.variance).map(f64::sqrt);
        Some(Self { path, force, rms, noise })
    }

    /// The disturbance along some axes of W (0 for x) as effects of a cell.
    pub fn effects(&self, axes: &[usize]) -> Vec<Effect> {
        axes.iter().filter_map(|axis| self.effect(*axis)).collect()
    }

    fn effect(&self, axis: usize) -> Option<Effect> {
        let name = format!("process-force-{}", WELD_AXES[axis]);
        let port = PORTS.iter().find(|port| port.name == name)?;
        let places = Places { x: self.path.clone(), across: Vec::new() };
        let table = DefinedTable { places, bend: f64::INFINITY };
        let range = [-FORCE_RANGE, FORCE_RANGE];
        let values: Vec<f64> = self.force.iter().map(|force| force[axis]).collect();
        let definition = Definition {
            id: format!("recorded-force-{}", WELD_AXES[axis]),
            port,
            expression: "table(x)".to_owned(),
            shows: port.meaning.to_owned(),
            parameters: CustomParameter::of_table(&table, port.unit, FORCE_STEP, range),
            table: Some(table),
        };
        Some(Effect { kind: definition.kind(&values).ok()?, at: Location::Cell, values })
    }
}

/// Mean about a place, with weights that fall to 0 at its neighbours; `None` where there is nothing.
fn mean_near(residuals: &[ForceResidual], at: f64, step: f64) -> Option<Vector3<f64>> {
    let from = residuals.partition_point(|r| r.path <= at - step);
    let near = residuals[from..].iter().take_while(|r| r.path < at + step);
    let (mut sum, mut weights) = (Vector3::zeros(), 0.0);
    for residual in near {
        let weight = 1.0 - (residual.path - at).abs() / step;
        sum += residual.force * weight;
        weights += weight;
    }
    (weights > 0.0).then(|| sum / weights)
}

/// The residuals of the slow force at the rows where it is compared.
fn of_log(log: &Log, compared: &LogComparison) -> Vec<ForceResidual> {
    let name = LogChannel::Force.entry().name;
    let column = |k: u8| compared.traces.iter().find(|t| t.channel == name && t.column == k);
    let (Some(x), Some(y), Some(z)) = (column(0), column(1), column(2)) else {
        return Vec::new();
    };
    let (Some(weld), Some(position)) = (&log.weld, filled_vectors(&log.samples.position)) else {
        return Vec::new();
    };
    let (seam, columns) = (Seam::real(weld), [x, y, z]);
    let start = log.samples.time.first().copied().unwrap_or(0.0);
    let count = columns.iter().map(|column| column.time.len()).min().unwrap_or(0);
    let residual = |k: usize| {
        let row = log.samples.time.partition_point(|t| t - start < x.time[k] - 1e-9);
        let at = position.each_ref().map(|column| column.get(row).copied());
        let place = seam.place(&Vector3::new(at[0]?, at[1]?, at[2]?));
        ForceResidual::new(columns, k, &place, &tool_rotation(log, row))
    };
    (0..count).filter_map(residual).collect()
}

impl ForceResidual {
    /// The `k`th of the columns of T, turned into W; `None` where the place is not known.
    fn new(
        columns: [&Trace; 3],
        k: usize,
        place: &SeamPosition,
        tool: &Matrix3<f64>,
    ) -> Option<Self> {
        let w_from_t = place.axes.transpose() * tool;
        let force = columns.map(|column| column.measured[k] - column.predicted[k]);
        let variance = columns.map(|column| column.deviation[k].powi(2));
        let path = place.position.x;
        path.is_finite().then(|| Self {
            path,
            force: w_from_t * Vector3::from(force),
            variance: w_from_t.component_mul(&w_from_t) * Vector3::from(variance),
        })
    }
}

/// The tool in B at a row: as the tracker saw it, else as the encoders have it.
pub fn tool_rotation(log: &Log, row: usize) -> Matrix3<f64> {
    let seen = log.samples.rotation.as_ref().map(|series| series[row]);
    match seen.filter(|vector| vector.sum().is_finite()) {
        Some(vector) => rotation_from_vector(&vector),
        None => log.robot.robot.forward_kinematics(&log.samples.encoder[row]).rotation,
    }
}
