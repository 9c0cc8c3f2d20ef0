//! `--live`: a weld over RSI in a running viewer, as it is made.

use clap::Args;
use miette::Result;
#[cfg(feature = "rerun")]
use miette::WrapErr;
#[cfg(feature = "rerun")]
use trueweld_output::{Live, LiveWeld};
#[cfg(feature = "rerun")]
use trueweld_plant::simulate::Recording;
#[cfg(feature = "rerun")]
use trueweld_plant::simulate::Seam;
use trueweld_plant::simulate::{RecordRow, Scenario};

/// The viewer of a weld.
#[derive(Args)]
pub(crate) struct LiveViewer {
    /// Show the weld as it is made in a running Rerun viewer
    #[arg(
        long = "live",
        value_name = "URL",
        num_args = 0..=1,
        default_missing_value = "rerun+http://127.0.0.1:9876/proxy"
    )]
    url: Option<String>,
}

/// A weld that may be shown.
pub(crate) struct Shown {
    #[cfg(feature = "rerun")]
    live: Option<Live>,
}

impl LiveViewer {
    /// Connects to the viewer, if one is asked for. `compensator`: the law's name.
    pub(crate) fn connect(&self, scenario: &Scenario<'_>, compensator: &str) -> Result<Shown> {
        let Some(url) = &self.url else { return Ok(Shown::nowhere()) };
        #[cfg(feature = "rerun")]
        {
            let robot = scenario.controller_model.clone();
            let recording = Recording::begun(scenario, compensator);
            let seam = Seam::of(scenario.weld);
            let weld = LiveWeld { recording, robot, seam, exaggeration: 50.0 };
            let live = Live::connect(url, weld)
                .map_err(miette::Report::from)
                .wrap_err("--live: no viewer is shown the weld")?;
            say!("shown at {url}\n");
            Ok(Shown { live: Some(live) })
        }
        #[cfg(not(feature = "rerun"))]
        {
            let _ = (scenario, compensator);
            Err(miette::miette!(
                "--live {url}: this build has no Rerun; build it with the feature `rerun`"
            ))
        }
    }
}

impl Shown {
    fn nowhere() -> Self {
        Self {
            #[cfg(feature = "rerun")]
            live: None,
        }
    }

    /// Shows one more row.
    pub(crate) fn row(&self, row: &RecordRow) {
        #[cfg(feature = "rerun")]
        if let Some(live) = &self.live {
            live.row(row);
        }
        #[cfg(not(feature = "rerun"))]
        let _ = row;
    }

    /// Waits until all is shown. A viewer that went away does not undo the weld: it is said.
    pub(crate) fn finish(self) -> Result<()> {
        #[cfg(feature = "rerun")]
        if let Some(Err(error)) = self.live.map(Live::finish) {
            say!("not all was shown: {error}\n");
        }
        Ok(())
    }
}
