//! `trueweld rsi-compensate`: a law that drives a robot over RSI, simulated or real.

use crate::inputs::WeldArguments;
use crate::names::LawParser;
use crate::rsi_counts::{bound, of_client, of_malformed};
use crate::rsi_live::LiveViewer;
use crate::rsi_log::LogFolder;
use crate::terminal;
use clap::Args;
use miette::{IntoDiagnostic, Result, miette};
use std::net::{IpAddr, SocketAddr};
use std::time::Duration;
use trueweld::WeldingCell;
use trueweld_compensators::Entry;
use trueweld_core::compensation::Compensator;
use trueweld_laboratory::ReadRow;
use trueweld_output::{fault_in_words, warning_in_words};
use trueweld_plant::simulate::{ControllerKind, RecordRow, Seam, WeldProgram, health_warnings};
use trueweld_rsi::client::Knowledge;
use trueweld_rsi::{Client, Seen, Served, serve};

/// Arguments of `rsi-compensate`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    files: WeldArguments,
    /// Compensation law, or several with + between them
    #[arg(long, value_name = "LAW", value_parser = LawParser, default_value = "elastostatic")]
    compensator: Entry,
    /// Address at which the controller's packets arrive
    #[arg(long, value_name = "IP:PORT", default_value = "127.0.0.1:49152")]
    listen: SocketAddr,
    /// Address of the controller: packets from any other are not read. Without it the first that sends a
    /// packet which can be answered is the controller
    #[arg(long, value_name = "IP")]
    controller: Option<IpAddr>,
    /// Largest correction that the controller lets through, mm: the law keeps within it
    #[arg(long, value_name = "MM", default_value_t = 5.0)]
    authority_mm: f64,
    /// Largest rotation that the controller lets through, degrees
    #[arg(long, value_name = "DEG", default_value_t = 5.0)]
    authority_deg: f64,
    /// Seconds for which a controller is waited for
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    wait: f64,
    /// Seconds of silence after which the controller has gone
    #[arg(long, value_name = "S", default_value_t = 2.0)]
    silence: f64,
    #[command(flatten)]
    log: LogFolder,
    #[command(flatten)]
    live: LiveViewer,
}

/// What a client knows of the cell.
pub(crate) fn knowledge(inputs: &WeldingCell) -> Knowledge {
    Knowledge {
        model: inputs.controller_model.clone(),
        seam: Seam::of(&inputs.weld),
        process: inputs.planned.clone(),
        sensor: inputs.sensors.seam.clone(),
        force_sensor_limits: inputs.sensors.force.limits,
    }
}

/// The law of a client.
pub(crate) fn law(inputs: &WeldingCell, law: &Entry) -> Result<Box<dyn Compensator<f64>>> {
    let scenario = inputs.scenario(WeldProgram::Weld, ControllerKind::EXTERNAL, law);
    Ok(scenario.build_law().into_diagnostic()?)
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let above = |flag: &str, value: f64| {
        (value.is_finite() && value > 0.0 && value < 1e6)
            .then_some(value)
            .ok_or_else(|| miette!("{flag} {value}: expected a number above 0"))
    };
    let authority = [
        above("--authority-mm", arguments.authority_mm)?,
        above("--authority-deg", arguments.authority_deg)?,
    ];
    let seconds = |flag, value| above(flag, value).map(Duration::from_secs_f64);
    let first = seconds("--wait", arguments.wait)?;
    let silence = seconds("--silence", arguments.silence)?;
    arguments.log.check()?;
    let inputs = arguments.files.read()?;
    inputs.must_bear_push("rsi-compensate")?;
    terminal::tell_warnings();
    let socket = bound(arguments.listen)?;
    let mut law = law(&inputs, &arguments.compensator)?;
    let mut client =
        Client::new(knowledge(&inputs), &inputs.control, law.as_mut(), authority, silence);
    say!("{} listens at {}\n", arguments.compensator.name(), arguments.listen);
    let mut most = 0.0_f64;
    let (mut read, mut rows) = (Vec::new(), Vec::<RecordRow>::new());
    let scenario =
        inputs.scenario(WeldProgram::Weld, ControllerKind::EXTERNAL, &arguments.compensator);
    let shown = arguments.live.connect(&scenario, arguments.compensator.name())?;
    let served = serve(&socket, &mut client, first, arguments.controller, |client| {
        most = most.max(client.correction().linear.norm());
        // A packet that came twice is answered twice.
        let is_new = |seen: &Seen| rows.last().is_none_or(|row| row.time < seen.row.time);
        if let Some(Seen { sensed, row }) = client.seen().filter(is_new) {
            shown.row(&row);
            read.push(ReadRow { time: row.time, encoder: sensed.encoder, wrench: sensed.wrench });
            rows.push(row);
        }
    });
    shown.finish()?;
    say!("{}{}", of_client(&client.counts()), of_malformed(client.malformed()));
    if let Some((time, fault)) = client.fault() {
        say!("first fault             {:>9.3} s: {}\n", time, fault_in_words(fault));
    }
    for warning in health_warnings(&rows, inputs.control.period) {
        say!("warning: {}\n", warning_in_words(&warning));
    }
    if !read.is_empty() {
        arguments.log.write(&inputs, |log, folder| {
            log.write_read(folder, inputs.control.period, inputs.planned.spindle, &read)
        })?;
    }
    match served {
        Served::Silent => {
            say!("largest correction      {:>9.3} mm\n", most * 1e3);
            match client.unwelded() {
                Some(left) if left > 0.0 => Err(miette!(
                    help = "Look for a cable or switch that failed, and for why RSI stopped on the \
                            controller.",
                    "the controller fell silent {:.1} mm before the end of the seam",
                    left * 1e3
                )),
                _ => Ok(()),
            }
        }
        Served::Nothing => Err(miette!(
            help = "Expected <Rob> packets with what a law needs: see docs/rsi.md.",
            "no packet that can be answered came to {} in {} s",
            arguments.listen,
            arguments.wait
        )),
        Served::Socket(kind) => Err(miette!("{}: {kind}", arguments.listen)),
    }
}
