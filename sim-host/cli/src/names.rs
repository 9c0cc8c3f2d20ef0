//! Names of controllers and laws on the command line.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use trueweld_plant::simulate::{self, BuildLaw};

/// A hybrid controller.
#[derive(Clone, Copy, ValueEnum)]
pub enum Controller {
    /// Parallel hybrid control with selection matrix (2.2)
    Parallel,
    /// Superposed hybrid control (2.3)
    Superposed,
    /// External hybrid control: force loop around a position loop (2.4), (2.5)
    External,
}

impl Controller {
    pub fn controller(self) -> simulate::Controller {
        match self {
            Self::Parallel => simulate::Controller::Parallel,
            Self::Superposed => simulate::Controller::Superposed,
            Self::External => simulate::Controller::External,
        }
    }
}

/// A compensation law.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Compensator(&'static simulate::Law);

impl Compensator {
    const ALL: [Self; simulate::Law::ALL.len()] = {
        const LAWS: &[simulate::Law] = &simulate::Law::ALL;
        let mut all = [Self(&LAWS[0]); LAWS.len()];
        let mut k = 0;
        while k < all.len() {
            all[k] = Self(&LAWS[k]);
            k += 1;
        }
        all
    };

    pub fn law(self) -> &'static simulate::Law {
        self.0
    }
}

impl ValueEnum for Compensator {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()).help(self.0.summary()))
    }
}
