use std::path::PathBuf;
use trueweld_measure::campaign::Campaign;
use trueweld_measure::fit::Bench;
use trueweld_measure::log::Log;
use trueweld_measure::noise::instruments;
use trueweld_measure::plan::{Plan, next_experiment};
use trueweld_measure::predict::{Experiment, Model};
use trueweld_plant::effects::Effect;

struct Laboratory {
    logs: Vec<Log>,
    bench: Bench,
}

impl Laboratory {
    fn new(name: &str) -> Self {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/campaigns").join(name);
        let logs = Campaign::read(folder).unwrap().logs;
        let process = logs.iter().find_map(|l| l.process.clone());
        let model = Model { robot: logs[0].robot.robot.clone(), process };
        let noise = instruments(&logs);
        let experiments =
            logs.iter().zip(&noise).map(|(log, noise)| Experiment::new(log, noise, &model).unwrap()).collect();
        Self { logs, bench: Bench { model, known: Vec::new(), experiments } }
    }

    fn rival(&self, text: &str) -> (String, Vec<Effect>) {
        (text.to_owned(), vec![Effect::parse(text, &self.logs[0].robot).unwrap()])
    }

    fn plan(&self, rivals: &[&str]) -> Option<Plan> {
        let rivals: Vec<_> = rivals.iter().map(|r| self.rival(r)).collect();
        next_experiment(&self.bench, &self.logs, &rivals)
    }
}

#[test]
fn friction_against_delay() {
    let laboratory = Laboratory::new("backlash");
    let t = std::time::Instant::now();
    let plan = laboratory.plan(&["joint-friction:A3:coulomb_nm=150,viscous_nms_rad=100", "channel-delay:torque:delay_s=0.01"]).unwrap();
    eprintln!("{:?} {} {:#?} {} {}", t.elapsed(), plan.title, plan.steps, plan.reason, plan.minutes);
    assert!(plan.separation > 5.0);
}
