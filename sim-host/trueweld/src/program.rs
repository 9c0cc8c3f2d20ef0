//! Laws and effects of one's own, beside those of this project.

use miette::{IntoDiagnostic, Result};
use trueweld_compensators::{Entry, Law};
use trueweld_plant::effects::EffectKind;

/// The laws and effects that a program knows by name.
///
/// Control files, model files, diagnosis and certification then take them as those of this project.
///
/// ```
/// # use trueweld::laws::Uncompensated;
/// # struct MyLaw;
/// # impl trueweld::laws::Law<f64> for MyLaw {
/// #     const NAME: &'static str = "my-law";
/// #     const SUMMARY: &'static str = "Nothing";
/// #     type Gains = <Uncompensated as trueweld::laws::Law<f64>>::Gains;
/// #     type Built = <Uncompensated as trueweld::laws::Law<f64>>::Built;
/// #     fn build(
/// #         gains: &Self::Gains,
/// #         setup: &trueweld::laws::Setup<f64>,
/// #     ) -> Result<Self::Built, trueweld::laws::GainError> {
/// #         Uncompensated::build(gains, setup)
/// #     }
/// # }
/// # use trueweld::effects::{Action, EffectKind};
/// # static MY_EFFECT: EffectKind =
/// #     EffectKind { id: "my-effect", action: Action::Process(|_, _| {}), ..EffectKind::DEFAULT };
/// trueweld::Program::new().law::<MyLaw>().effect(&MY_EFFECT).install()?;
/// assert_eq!(trueweld::law("my-law")?.name(), "my-law");
/// # Ok::<(), miette::Report>(())
/// ```
#[derive(Debug, Default)]
pub struct Program {
    laws: Vec<Entry>,
    effects: Vec<&'static EffectKind>,
}

impl Program {
    /// The laws and effects of this project.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a law, which is then known by its name.
    #[must_use]
    pub fn law<L: Law<f64>>(mut self) -> Self {
        self.laws.push(Entry::of::<L>());
        self
    }

    /// Adds an effect, which is then known by its identifier.
    #[must_use]
    pub fn effect(mut self, effect: &'static EffectKind) -> Self {
        self.effects.push(effect);
        self
    }

    /// Makes the laws and effects known to this process, once and before anything is read.
    ///
    /// # Errors
    /// A name that is taken or is none; laws or effects that were installed or asked for before.
    pub fn install(self) -> Result<()> {
        trueweld_compensators::install(self.laws).into_diagnostic()?;
        trueweld_plant::effects::install(self.effects).into_diagnostic()
    }
}
