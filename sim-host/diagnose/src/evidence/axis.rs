//! The variables that effects follow, a value for every row of every log.

use super::context::{Abscissa, EvidenceContext};
use std::f64::consts::TAU;
use trueweld_logs::log::{Log, LogKind};
use trueweld_logs::rates::{rate, reach};

impl Abscissa {
    /// Its values, by log, then by row, NaN where they are not known; `None` where no log has them.
    pub(super) fn values(self, ctx: &EvidenceContext<'_>) -> Option<Vec<Option<Vec<f64>>>> {
        let values: Vec<_> = (0..ctx.logs.len()).map(|log| self.of_log(ctx, log)).collect();
        values.iter().any(Option::is_some).then_some(values)
    }

    fn of_log(self, ctx: &EvidenceContext<'_>, index: usize) -> Option<Vec<f64>> {
        let log = ctx.logs.get(index)?;
        let samples = &log.samples;
        let motion = ctx.found.residuals[index].motion.as_ref();
        match self {
            Self::Time => {
                let begin = samples.time.first()?;
                Some(samples.time.iter().map(|t| t - begin).collect())
            }
            Self::TimeTo(end) => {
                let times = Self::Time.of_log(ctx, index)?;
                Some(times.into_iter().map(|t| if t <= end { t } else { f64::NAN }).collect())
            }
            Self::SpringTorque(j) => {
                let spring = &motion.filter(|m| m.spring.len() == samples.len())?.spring;
                Some(averaged(log, spring.iter().map(|t| t[j]).collect()))
            }
            Self::Angle(j) => Some(samples.encoder.iter().map(|q| q[j]).collect()),
            Self::Phase(j, order) => {
                let period = TAU / order;
                Some(samples.encoder.iter().map(|q| q[j].rem_euclid(period)).collect())
            }
            Self::Rate(j) => rate(log, &samples.encoder.iter().map(|q| q[j]).collect::<Vec<_>>()),
            Self::Path => log.along_weld(),
            Self::Feed => rate(log, &log.along_weld()?),
            Self::AxialForce => {
                Some(averaged(log, samples.force.as_ref()?.iter().map(|f| f.z).collect()))
            }
            Self::PushBySpindle => {
                let push = Self::AxialForce.of_log(ctx, index)?;
                Some(
                    push.iter()
                        .zip(samples.spindle.as_ref()?)
                        .map(|(f, turning)| -f * turning.signum())
                        .collect(),
                )
            }
            Self::Load => {
                let force = samples.force.as_ref()?;
                let [x, y, z] =
                    [0, 1, 2].map(|c| averaged(log, force.iter().map(|f| f[c]).collect()));
                Some((0..x.len()).map(|k| x[k].hypot(y[k]).hypot(z[k])).collect())
            }
            Self::ToolSpeed => {
                let tool = tool(log);
                let rates: Option<Vec<_>> = tool.iter().map(|t| rate(log, t)).collect();
                let rates = rates?;
                Some(
                    (0..samples.len())
                        .map(|k| rates[0][k].hypot(rates[1][k]).hypot(rates[2][k]))
                        .collect(),
                )
            }
            Self::Tool(i) => Some(tool(log).swap_remove(i.min(2))),
            Self::SpindleOrder => None,
        }
    }
}

/// TCP in B by the encoders, by component.
fn tool(log: &Log) -> Vec<Vec<f64>> {
    let positions: Vec<_> = log
        .samples
        .encoder
        .iter()
        .map(|q| log.robot.robot.forward_kinematics(q).position)
        .collect();
    (0..3).map(|i| positions.iter().map(|p| p[i]).collect()).collect()
}

/// Means over the time that a rate is taken over, so that the spindle's ripple does not spread a load.
fn averaged(log: &Log, series: Vec<f64>) -> Vec<f64> {
    let Some(reach) = reach(log).filter(|_| log.kind == LogKind::Weld) else {
        return series;
    };
    let mut sums = vec![0.0; series.len() + 1];
    let mut counts = vec![0.0; series.len() + 1];
    for (k, v) in series.iter().enumerate() {
        let known = v.is_finite();
        sums[k + 1] = sums[k] + if known { *v } else { 0.0 };
        counts[k + 1] = counts[k] + f64::from(u8::from(known));
    }
    let mean = |k: usize| {
        let (a, b) = (k.saturating_sub(reach), (k + reach + 1).min(series.len()));
        (sums[b] - sums[a]) / (counts[b] - counts[a])
    };
    (0..series.len()).map(mean).collect()
}
