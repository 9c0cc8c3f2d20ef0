//! `trueweld rsi-robot`: a simulated KUKA controller with the elastic robot and the process behind
//! it.

use crate::inputs::WeldArguments;
use crate::names::{ControllerParser, LawParser};
use crate::results::{RecordedResults, check_outputs, check_targets};
use crate::rsi_compensate;
use crate::rsi_counts::{bound, of_link, of_malformed};
use crate::rsi_live::LiveViewer;
use crate::rsi_log::LogFolder;
use clap::Args;
use miette::{IntoDiagnostic, Result, miette};
use std::net::SocketAddr;
use std::ops::ControlFlow;
use std::slice;
use std::thread;
use std::time::Duration;
use trueweld::PLANT_STEP;
use trueweld_compensators::{Entry, Uncompensated};
use trueweld_evaluate::WeldFigures;
use trueweld_output::{WeldReport, WeldRun};
use trueweld_plant::controllers::ControllerKind;
use trueweld_plant::simulate::{Recording, Seam, WeldProgram, run_with};
use trueweld_rsi::packet::Element;
use trueweld_rsi::{Client, CorrectionBounds, CycleTimeout, Link, pass_through, serve};

/// Longest that an answer is waited for in lock-step.
const PATIENCE: Duration = Duration::from_secs(1);

/// How long a client in this process waits for its first packet, and bears silence.
const FIRST: Duration = Duration::from_secs(60);
const SILENCE: Duration = Duration::from_millis(300);

/// Arguments of `rsi-robot`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    files: WeldArguments,
    /// Hybrid force/position controller
    #[arg(long, value_parser = ControllerParser, default_value = ControllerKind::default().name())]
    controller: ControllerKind,
    /// Address of the client that answers
    #[arg(long, value_name = "IP:PORT", default_value = "127.0.0.1:49152")]
    to: SocketAddr,
    /// Address that packets are sent from; port 0: any
    #[arg(long, value_name = "IP:PORT", default_value = "127.0.0.1:0")]
    from: SocketAddr,
    /// Run this law at the other end as well, in this process
    #[arg(long, value_name = "LAW", value_parser = LawParser, conflicts_with = "plain")]
    compensator: Option<Entry>,
    /// Wait for each answer instead of for the clock: as fast as both sides are
    #[arg(long)]
    lock_step: bool,
    /// Packets of RIst, AIPos, EIPos, Delay and IPOC alone, as kuka-external-control-sdk reads them; no
    /// law runs on them
    #[arg(long)]
    plain: bool,
    /// Packets of these elements and IPOC, in this order, as the client's <SEND> list has them: of RIst,
    /// RSol, AIPos, ASPos, EIPos, Delay. RIst,RSol,AIPos,ASPos,Delay: the ROS-Industrial driver's
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = element,
          conflicts_with_all = ["plain", "compensator"])]
    send: Vec<Element>,
    /// Largest component of a correction, mm: more is cut off, and the client not told (POSCORR)
    #[arg(long, value_name = "MM", default_value_t = 5.0)]
    clamp_mm: f64,
    /// Largest component of a rotation, degrees
    #[arg(long, value_name = "DEG", default_value_t = 5.0)]
    clamp_deg: f64,
    /// Largest correction, mm: RSI stops above (POSCORRMON)
    #[arg(long, value_name = "MM", default_value_t = 6.0)]
    monitor_mm: f64,
    /// Largest rotation, degrees
    #[arg(long, value_name = "DEG", default_value_t = 6.0)]
    monitor_deg: f64,
    /// Corrections are increments (#RELATIVE), not offsets (#ABSOLUTE)
    #[arg(long)]
    relative: bool,
    /// Without an answer the offset is taken away at once (HOLDON="0")
    #[arg(long)]
    no_hold: bool,
    /// Cycles in a row without an answer after which RSI stops
    #[arg(long, value_name = "N", default_value_t = 10)]
    timeout: u32,
    #[command(flatten)]
    log: LogFolder,
    #[command(flatten)]
    live: LiveViewer,
    #[command(flatten)]
    results: RecordedResults,
}

/// An element of the controller's packet, with or without KUKA's DEF_ before its name.
fn element(name: &str) -> Result<Element, String> {
    let bare = name.strip_prefix("DEF_").unwrap_or(name);
    let known = Element::NAMED.iter().find(|(known, _)| *known == bare);
    known.map(|(_, element)| *element).ok_or_else(|| {
        let names: Vec<&str> = Element::NAMED.iter().map(|(known, _)| *known).collect();
        format!("{name:?} is no element; expected some of {}", names.join(", "))
    })
}

impl Arguments {
    fn elements(&self) -> &[Element] {
        match (self.plain, &self.send[..]) {
            (true, _) => &Element::PLAIN,
            (false, []) => &Element::WELD,
            (false, listed) => listed,
        }
    }

    fn bounds(&self) -> Result<CorrectionBounds> {
        let of = |flag: &str, value: f64| {
            (value.is_finite() && value >= 0.0)
                .then_some(value)
                .ok_or_else(|| miette!("{flag} {value}: expected a number from 0 up"))
        };
        Ok(CorrectionBounds {
            clamp_mm: of("--clamp-mm", self.clamp_mm)?,
            clamp_deg: of("--clamp-deg", self.clamp_deg)?,
            monitor_mm: of("--monitor-mm", self.monitor_mm)?,
            monitor_deg: of("--monitor-deg", self.monitor_deg)?,
            relative: self.relative,
            hold: !self.no_hold,
            timeout: self.timeout,
        })
    }
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let outputs = arguments.results.outputs();
    check_targets(&outputs)?;
    arguments.log.check()?;
    let bounds = arguments.bounds()?;
    let inputs = arguments.files.read()?;
    inputs.must_bear_push("rsi-robot")?;
    check_outputs(&outputs)?;
    let controller = arguments.controller;
    // The law is at the other end.
    let law = Entry::of::<Uncompensated>();
    let control = pass_through(&inputs.control);
    let mut scenario = inputs.scenario(WeldProgram::Weld, controller, &law);
    scenario.control = &control;
    let seam = Seam::of(&inputs.weld);
    let pace =
        if arguments.lock_step { CycleTimeout::LockStep(PATIENCE) } else { CycleTimeout::RealTime };
    let socket = bound(arguments.from)?;
    let how = (bounds, pace, arguments.elements());
    let mut link = Link::new(socket, arguments.to, &seam, control.period, how).into_diagnostic()?;
    let stopped = link.stopped();
    let name = match &arguments.compensator {
        Some(law) => format!("{} over RSI", law.name()),
        None => "over RSI".to_owned(),
    };
    let shown = arguments.live.connect(&scenario, &name)?;
    let duration = WeldProgram::Weld.duration(&inputs.weld, &seam);
    let progress = arguments.results.files.progress("welding over RSI", duration);
    // Wide enough for the guard, and no wider.
    let authority =
        [bounds.clamp_mm.min(bounds.monitor_mm), bounds.clamp_deg.min(bounds.monitor_deg)];
    let client = match &arguments.compensator {
        Some(law) => Some((law, bound(arguments.to)?)),
        None => None,
    };
    let recording = thread::scope(|scope| {
        let inputs = &inputs;
        let served = client.map(|(law, socket)| {
            scope.spawn(move || -> Result<()> {
                // The boxed law belongs to its thread.
                let mut law = rsi_compensate::law(inputs, law)?;
                let knowledge = rsi_compensate::knowledge(inputs);
                let mut client =
                    Client::new(knowledge, &inputs.control, law.as_mut(), authority, SILENCE);
                serve(&socket, &mut client, FIRST, None, |_| {});
                Ok(())
            })
        });
        let recording = run_with(&scenario, &mut link, |row| {
            progress.advance_to(row.time);
            shown.row(row);
            if stopped.get().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if let Some(thread) = served {
            thread.join().map_err(|_| miette!("the client stopped"))??;
        }
        recording.map_err(|error| inputs.failed(controller, &error))
    });
    progress.finish();
    shown.finish()?;
    let recording = Recording { compensator: name, ..recording? };
    say!("{}{}", of_link(&link.counts()), of_malformed(link.malformed()));
    arguments.log.write(&inputs, |log, folder| {
        log.write_simulated(folder, &recording, &inputs.cell, inputs.planned.spindle)
    })?;
    let figures = WeldFigures::of(&recording);
    if let Some(figures) = &figures {
        let simulation = inputs.simulation(&[controller], slice::from_ref(&law), 1, PLANT_STEP);
        arguments.results.write(&WeldReport {
            runs: &[WeldRun::new(&recording, figures, &inputs.robot.robot)],
            from_log: None,
            exaggeration: 50.0,
            provenance: &inputs.provenance("rsi-robot", simulation),
        })?;
    }
    match (stopped.get(), figures) {
        (Some(stop), _) => {
            let time = recording.simulated;
            Err(miette!("RSI stopped {time:.2} s into the weld: {stop}"))
        }
        (None, None) => Err(inputs.too_short()),
        (None, Some(_)) => Ok(()),
    }
}
