//! A weld as it was recorded, in the bands in which its forces are predicted, and the tool followed
//! through it as the tracker saw it.

use super::super::BaselineModel;
use super::super::columns::vector;
use super::super::instruments::{pose_behind, sensed, unread, wrench_behind};
use crate::predict::wiener::{WienerSmoother, between};
use nalgebra::{Matrix3, Vector3};
use trueweld_core::{Pose, Wrench};
use trueweld_logs::fir::{LowPass, interpolate};
use trueweld_plant::input::Process;
use trueweld_plant::process::{Reaction, reaction};
use trueweld_plant::robot::{Channel, ElasticRobot, Ports, Readings};
use trueweld_plant::simulate::Seam;

/// A weld with tracker and wrench.
#[derive(Debug, Clone)]
pub(super) struct RecordedWeld {
    pub process: Process,
    pub seam: Seam,
    /// Axes of W in B where the tool is, at every row.
    pub axes: Vec<Matrix3<f64>>,
    /// Feed where the log begins, m/s.
    pub feed: f64,
    pub period: f64,
    /// Spindle angle at every row, rad.
    pub angle: Vec<f64>,
    /// Tracker, all rows.
    pub position: [Vec<f64>; 3],
    pub rotation: Vec<Matrix3<f64>>,
    pub force: Vec<Vector3<f64>>,
    /// Components of the force that nobody measured: zero.
    pub unmeasured: [bool; 3],
    pub low: LowPass,
    /// Rows for each reading of the force.
    pub rows_a_force: f64,
    /// In which the tool is followed.
    pub followed: LowPass,
    /// Rows that are compared.
    pub rows: Vec<usize>,
    /// What of that motion is none of the tracker's noise, in W; `None` where it is not known yet.
    pub likeliest: Option<WienerSmoother>,
    /// Motion of the tool as the tracker tells it without a delay or a term of its own.
    pub motion: Vec<Tool>,
}

/// Depth force from which on there is contact to speak of, as a share of the process' reference
/// force.
pub(super) const CONTACT: f64 = 0.03;

/// Share of the feed from which on a tool is on its way: halfway between that and rest.
const ON_ITS_WAY: f64 = 0.5;

/// The tool at one row: TCP and velocity in W, and the channel behind it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tool {
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub channel: f64,
}

/// A tool that carries a measured push: in W, N, m and m/s.
#[derive(Debug, Clone, Copy)]
pub(super) struct LoadedTool {
    pub push: f64,
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub channel: f64,
    /// Mean over a turn of the spindle.
    pub reaction: Reaction,
}

impl RecordedWeld {
    /// The process of this log: the model's, turning as the spindle was recorded.
    pub(crate) fn process(&self, model: &BaselineModel) -> Process {
        let mut process = model.process.clone().unwrap_or_else(|| self.process.clone());
        process.spindle = self.process.spindle;
        process
    }

    /// Motion of the tool in the bands it is followed in. `robot`: whose sensor terms are undone;
    /// `late`: the tracker's delay, s; `memory`: the travel over which the channel follows, m.
    pub(crate) fn tool(&self, robot: Option<&ElasticRobot>, late: f64, memory: f64) -> Vec<Tool> {
        let n = self.angle.len();
        let read = |k: usize| {
            let at = |i: usize| match late {
                0.0 => self.position[i][k],
                _ => interpolate(&self.position[i], k as f64 + late / self.period),
            };
            Vector3::new(at(0), at(1), at(2))
        };
        // What the tracker's terms do to a position changes along a weld as slowly as the tool
        // moves.
        let stride = self.stride();
        let undone: Vec<Vector3<f64>> = (0..n + stride)
            .step_by(stride)
            .map(|k| {
                let k = k.min(n - 1);
                let pose = Pose { position: read(k), rotation: self.rotation[k] };
                robot.map_or(Vector3::zeros(), |r| {
                    pose_behind(&r.ports, &pose, k as f64 * self.period).position - pose.position
                })
            })
            .collect();
        let behind: Vec<Vector3<f64>> =
            (0..n).map(|k| read(k) + between(&undone, stride, k)).collect();
        let [place, rate] = [0, 1].map(|derivative| {
            [0, 1, 2].map(|c| {
                let series: Vec<f64> = behind.iter().map(|p| p[c]).collect();
                self.followed.smooth(derivative, &series)
            })
        });
        let (mut position, mut velocity): (Vec<_>, Vec<_>) = (0..n)
            .map(|k| {
                let placed = self.seam.place(&vector(&place, k));
                (placed.position, placed.axes.tr_mul(&vector(&rate, k)))
            })
            .unzip();
        if let Some(likeliest) = &self.likeliest {
            [&mut position, &mut velocity].into_iter().for_each(|series| likeliest.keep(series));
        }
        // Behind a tool that begins on its way the channel is where it was a memory's length before.
        let mut channel = position[0].y - self.lag(memory, |k| position[k]);
        (0..n)
            .map(|k| {
                let tool = Tool { position: position[k], velocity: velocity[k], channel };
                // ẏ_m = (y − y_m)|v_x|/L, exactly over one row.
                let share = -(-velocity[k].x.abs() * self.period / memory).exp_m1();
                channel += (position[k].y - channel) * share;
                tool
            })
            .collect()
    }

    /// Takes the tool's motion for what it likeliest was, where a reading of the tracker is known to
    /// `tracker`, m.
    pub(crate) fn distrust(&mut self, tracker: f64) {
        let seen: Vec<Vector3<f64>> = self.motion.iter().map(|tool| tool.position).collect();
        let covariance = |lag: usize| tracker.powi(2) * self.followed.covariance(0, lag);
        let low = &self.low;
        let slow = [0, 1].map(|derivative| move |lag: usize| low.covariance(derivative, lag));
        self.likeliest = Some(WienerSmoother::of(&seen, self.stride(), covariance, slow));
        self.motion = self.tool(None, 0.0, self.process.model.memory_length());
    }

    /// How far the channel, which follows over a travel of `memory`, lags behind the tool when the log
    /// begins, across the seam, m: 0 where the tool is not on its way through the plate yet. By the force
    /// and the way over the first window, for noise alone moves a tool by a few millimetres a second, and
    /// by more than its depth. `position`: by row, in W.
    pub(crate) fn lag(&self, memory: f64, position: impl Fn(usize) -> Vector3<f64>) -> f64 {
        let rows = self.low.half();
        let way = position(rows) - position(0);
        let least = ON_ITS_WAY * self.feed * rows as f64 * self.period;
        let is_on_its_way = self.begins_in_contact() && way.x.abs() > least;
        if is_on_its_way { memory * way.y / way.x.abs() } else { 0.0 }
    }

    /// True where there is contact to speak of when the log begins, by the force over the first window.
    pub(crate) fn begins_in_contact(&self) -> bool {
        let rows = self.low.half();
        let first = self.force.iter().take(rows);
        let sum = if self.process.bears_push() {
            first.map(|f| f.z.abs()).sum::<f64>()
        } else {
            first.sum::<Vector3<f64>>().norm()
        };
        sum / rows as f64 > CONTACT * self.process.model.reference_force()
    }

    /// A series without what is slow in it: thousands of newtons that change slowly would show at
    /// every order, little as the filter lets through of what is far from it.
    pub(crate) fn quick(&self, series: &[f64]) -> Vec<f64> {
        let (n, stride) = (series.len(), self.stride());
        let slow: Vec<f64> = (0..n + stride)
            .step_by(stride)
            .map(|k| self.low.at(0, |i| series[i], n, k.min(n - 1)))
            .collect();
        series
            .iter()
            .enumerate()
            .map(|(k, s)| s - interpolate(&slow, k as f64 / stride as f64))
            .collect()
    }

    /// The same of every component.
    pub(crate) fn quick_vectors(&self, series: &[Vector3<f64>]) -> [Vec<f64>; 3] {
        [0, 1, 2].map(|c| self.quick(&series.iter().map(|v| v[c]).collect::<Vec<f64>>()))
    }

    /// Samples between two that tell what is slow.
    pub(crate) fn stride(&self) -> usize {
        self.low.stride()
    }

    /// A tool that carries the push measured around a row, its forces those of a mean over a turn: the
    /// noisy depth itself may have lost contact.
    pub(crate) fn held(&self, process: &Process, row: usize) -> LoadedTool {
        let tool = &self.motion[row];
        let push = self.push(row).max(1.0);
        let depth = if process.bears_push() { process.depth_under(push) } else { tool.position.z };
        let position = Vector3::new(tool.position.x, tool.position.y, depth);
        let velocity = Vector3::new(tool.velocity.x, tool.velocity.y, 0.0);
        let (even, none) = (process.even(), Ports::default());
        let reaction = reaction(&even, &none, 0.0, &position, &velocity, tool.channel, 0.0);
        LoadedTool { push, position, velocity, channel: tool.channel, reaction }
    }

    /// Slopes in W of what the sensor reads of the force that carries the push measured around a row by the
    /// tool's place, N/m, and by its rate, N·s/m, mean over a turn of the spindle: central differences over
    /// what `noise` moves them by, m and m/s. `None` where there is no noise, or no contact to speak of.
    pub(crate) fn slopes(
        &self,
        (process, ports): (&Process, &Ports),
        row: usize,
        noise: [f64; 2],
    ) -> Option<[Matrix3<f64>; 2]> {
        let (even, tool) = (process.even(), &self.motion[row]);
        let time = row as f64 * self.period;
        let force = |by: &[Vector3<f64>; 2]| {
            let (position, velocity) = (tool.position + by[0], tool.velocity + by[1]);
            reaction(&even, ports, time, &position, &velocity, tool.channel, 0.0).force
        };
        let still = force(&[Vector3::zeros(); 2]);
        let turn = self.axes[row].tr_mul(&self.rotation[row]);
        let mut carried = Vector3::repeat(1.0);
        if process.model.plane_follows_push() {
            let measured = turn.tr_mul(&(Vector3::z() * self.push(row).copysign(still.z)));
            let measured = Wrench { moment: Vector3::zeros(), force: measured };
            let push = (turn * wrench_behind(ports, &measured, time).force).z;
            (carried.x, carried.y) = (push / still.z, push / still.z);
        }
        let read = |by: &[Vector3<f64>; 2]| {
            let force = turn.tr_mul(&force(by).component_mul(&carried));
            turn * sensed(ports, Channel::Wrench, Readings { force, ..unread(time) }).force
        };
        let slopes = [0, 1].map(|derivative| {
            let columns = [0, 1, 2].map(|axis| {
                let mut by = [Vector3::zeros(); 2];
                by[derivative][axis] = noise[derivative];
                let ahead = read(&by);
                by[derivative][axis] = -noise[derivative];
                (ahead - read(&by)) / (2.0 * noise[derivative])
            });
            Matrix3::from_columns(&columns)
        });
        let least = CONTACT * process.model.reference_force();
        let is_firm = !process.bears_push() || still.z.abs() > least;
        (is_firm && noise.iter().all(|by| *by > 0.0)).then_some(slopes)
    }

    /// Measured depth force around a row, N; of a process that bears no push, the whole force.
    pub(crate) fn push(&self, row: usize) -> f64 {
        let slow = |of: &dyn Fn(usize) -> f64| self.low.at(0, of, self.force.len(), row);
        if self.process.bears_push() {
            return slow(&|i| self.force[i].z.abs());
        }
        Vector3::from_fn(|c, _| slow(&|i| self.force[i][c])).norm()
    }

    /// The process' force at every row, in W. `shake`: position and velocity, in W, of what the tool does beside the motion.
    pub(crate) fn forces(
        &self,
        process: &Process,
        ports: &Ports,
        motion: &[Tool],
        shake: Option<&[[Vector3<f64>; 2]]>,
    ) -> Vec<Vector3<f64>> {
        let mut forces = Vec::with_capacity(self.angle.len());
        for (k, angle) in self.angle.iter().enumerate() {
            let tool = &motion[k];
            let [by, at] = shake.map_or([Vector3::zeros(); 2], |shake| shake[k]);
            let at = process.vibration_speed(&by, &at);
            let (time, channel) = (k as f64 * self.period, tool.channel);
            let (position, velocity) = (tool.position + by, tool.velocity + at);
            let load = reaction(process, ports, time, &position, &velocity, channel, *angle);
            forces.push(load.force);
        }
        forces
    }

    /// The depth force that was measured, over the predicted one, at every row, both in the band that the tool
    /// is followed in, so that no noise of the depth is left in the slow force's own: as slow as that,
    /// some values a second tell it. 1 where there is no contact to speak of, and of a process whose forces
    /// in the plane do not follow its push. `measured`: in the sensor's axes; `predicted`: in W.
    pub(crate) fn carried(
        &self,
        process: &Process,
        measured: &[Vector3<f64>],
        predicted: &[Vector3<f64>],
    ) -> Vec<f64> {
        let (n, stride) = (measured.len(), self.stride());
        if !process.model.plane_follows_push() {
            return vec![1.0; n];
        }
        let least = CONTACT * process.model.reference_force();
        let depth: Vec<f64> =
            (0..n).map(|k| self.axes[k].column(2).dot(&(self.rotation[k] * measured[k]))).collect();
        let seldom: Vec<f64> = (0..n + stride)
            .step_by(stride)
            .map(|k| {
                let slow = |of: &dyn Fn(usize) -> f64| self.followed.at(0, of, n, k.min(n - 1));
                let (measured, predicted) = (slow(&|i| depth[i]), slow(&|i| predicted[i].z));
                let firm = predicted.abs() > least && measured.abs() > least;
                if firm { measured / predicted } else { 1.0 }
            })
            .collect();
        (0..n).map(|k| interpolate(&seldom, k as f64 / stride as f64)).collect()
    }

    /// A force in W at a row, in the sensor's axes.
    pub(crate) fn in_tool(&self, row: usize, force: &Vector3<f64>) -> Vector3<f64> {
        self.rotation[row].tr_mul(&(self.axes[row] * force))
    }

    /// Variance of a component in the sensor's axes at a row, where those in W have these
    /// deviations.
    pub(crate) fn turned(&self, deviations: &Vector3<f64>, row: usize, component: usize) -> f64 {
        let turn = self.axes[row].tr_mul(&self.rotation[row]);
        (0..3).map(|j| (turn[(j, component)] * deviations[j]).powi(2)).sum()
    }
}
