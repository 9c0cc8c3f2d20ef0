//! The variables of a port, row by row of the logs: what an effect there may depend on.

use trueweld_core::JOINTS;
use trueweld_estimate::fit::{FitProblem, Residuals};
use trueweld_logs::log::{Log, LogKind};
use trueweld_logs::rates::rate;
use trueweld_plant::effects::Location;
use trueweld_plant::effects::expression::Expression;
use trueweld_plant::effects::formula::NamedPort;

/// Values of an expression over a port's variables, by log and row; NaN where one of them is not
/// known.
pub(super) type ExpressionValues = Vec<Vec<f64>>;

/// The logs with what the model says of their links.
#[derive(Clone, Copy)]
pub(super) struct LogRows<'a> {
    pub problem: &'a FitProblem,
    pub logs: &'a [Log],
    pub at: &'a Residuals,
}

impl LogRows<'_> {
    /// An expression over the variables of a port at every row; `None` where no log knows it. What it
    /// remembers begins at nothing in each log.
    pub(crate) fn of(
        &self,
        port: &NamedPort,
        at: Location,
        text: &str,
    ) -> Option<ExpressionValues> {
        let names: Vec<&str> = port.variables.iter().map(|v| v.name).collect();
        let expression = Expression::parse(text, &names, &[]).ok()?;
        let joint = if let Location::Joint(joint) = at { joint } else { 0 };
        let of_log = |log: usize| self.values(&expression, &names, joint, log);
        let all: ExpressionValues = (0..self.logs.len()).map(of_log).collect();
        all.iter().flatten().any(|v| v.is_finite()).then_some(all)
    }

    /// An expression over these variables, those of a joint at this one, at every row of a log.
    fn values(
        &self,
        expression: &Expression,
        names: &[&str],
        joint: usize,
        log: usize,
    ) -> Vec<f64> {
        let column = |(k, name): (usize, &&str)| {
            let used = expression.has_variable(k);
            if used { self.variable(log, name, joint) } else { None }
        };
        let columns: Vec<Option<Vec<f64>>> = names.iter().enumerate().map(column).collect();
        let way = |row: usize| {
            let series = columns[expression.variable_remembered()?].as_ref()?;
            Some(series[row] - series[row.saturating_sub(1)])
        };
        let mut variables = vec![0.0; names.len() + 1];
        let mut values = Vec::with_capacity(self.logs[log].samples.len());
        for row in 0..self.logs[log].samples.len() {
            if let (Some(way), Some((law, width))) = (way(row), expression.remembered(&[])) {
                variables[names.len()] = law.after(way, width, variables[names.len()]);
            }
            for (k, column) in columns.iter().enumerate() {
                let unknown = if expression.has_variable(k) { f64::NAN } else { 0.0 };
                variables[k] = column.as_ref().map_or(unknown, |c| c[row]);
            }
            values.push(expression.eval(&variables, &[]));
        }
        values
    }

    fn variable(&self, index: usize, name: &str, joint: usize) -> Option<Vec<f64>> {
        let log = &self.logs[index];
        let (samples, n) = (&log.samples, log.samples.len());
        let motion = self.at[index].motion.as_ref();
        let encoder = |j: usize| samples.encoder.iter().map(|q| q[j]).collect::<Vec<f64>>();
        let link = |j: usize| match motion.filter(|m| m.link.len() == n) {
            Some(motion) => motion.link.iter().map(|q| q[j]).collect(),
            None => encoder(j),
        };
        let spring = |j: usize| {
            let motion = motion.filter(|m| m.spring.len() == n)?;
            Some(motion.spring.iter().map(|t| t[j]).collect::<Vec<f64>>())
        };
        // What rests has no rates.
        let rate = |series: &[f64]| match log.kind {
            LogKind::StaticLoad => Some(vec![0.0; n]),
            _ => rate(log, series),
        };
        let force =
            |c: usize| Some(samples.force.as_ref()?.iter().map(|f| f[c]).collect::<Vec<f64>>());
        let tool = |c: usize| {
            let robot = &log.robot.robot;
            samples.encoder.iter().map(|q| robot.forward_kinematics(q).position[c]).collect()
        };
        match name {
            "time" => {
                let begin = samples.time.first()?;
                Some(samples.time.iter().map(|t| t - begin).collect())
            }
            "encoder" => Some(encoder(joint)),
            "encoder_rate" => rate(&encoder(joint)),
            "link" => Some(link(joint)),
            "link_rate" => rate(&link(joint)),
            "twist" => Some(encoder(joint).iter().zip(link(joint)).map(|(a, b)| a - b).collect()),
            "encoder_before" => joint.checked_sub(1).map(encoder),
            "smoothing" => Some(vec![self.problem.model.robot.parameters().friction.smoothing; n]),
            "spring_torque" => spring(joint),
            "torque" => samples.motor_torque[joint].clone(),
            "fz" => force(2),
            "depth_force" => Some(force(2)?.iter().map(|f| -f).collect()),
            "px" => Some(tool(0)),
            "py" => Some(tool(1)),
            "pz" => Some(tool(2)),
            "x" => log.along_weld(),
            "vx" => rate(&log.along_weld()?),
            "spindle" => samples.spindle.clone(),
            _ => {
                let number: usize = name.strip_prefix("encoder_")?.parse().ok()?;
                (1..=JOINTS).contains(&number).then(|| encoder(number - 1))
            }
        }
    }
}
