//! `[[known]]` of a model: effects of which the cell was measured apart from the logs, so that its
//! files are right about them.
//!
//! ```toml
//! [[known]]
//! id = "encoder-offset"
//! at = "A2"                            # left out: at every place
//! deviation = { offset_rad = 2e-5 }    # standard deviations; a parameter that is left out is exact
//! ```
//!
//! A calibration is fitted within these instead of what is usual; an effect that is none is not
//! looked for.

use crate::effects::{EffectKind, Location, library};
use crate::input::place::place;
use crate::input::table::TomlTable;
use crate::input::{Bounds, InputError, RobotFile, nearest};

/// What is known of an effect without the logs.
#[derive(Debug, Clone)]
pub struct KnownEffect {
    /// Which.
    pub kind: &'static EffectKind,
    /// Where; `None` for every place.
    pub at: Option<Location>,
    /// How far each parameter may be from what the model says, one standard deviation in the
    /// parameter's unit; 0 where it is exact.
    pub deviation: Vec<f64>,
}

impl KnownEffect {
    /// Reads the `[[known]]` tables of a model.
    ///
    /// # Errors
    /// The first thing that does not fit, with its place; a place that stands twice.
    pub fn read_all(root: &TomlTable<'_>, robot: &RobotFile) -> Result<Vec<Self>, InputError> {
        let mut places = Vec::new();
        root.each_table("known", |table| {
            let known = Self::read(table, robot)?;
            let place = (known.kind.id, known.at);
            if places.contains(&place) {
                let message = format!("{} stands twice there; expected it once", known.kind.id);
                return Err(table.error(&message, "Say all that is known of it in one table."));
            }
            places.push(place);
            Ok(known)
        })
    }

    fn read(table: &TomlTable<'_>, robot: &RobotFile) -> Result<Self, InputError> {
        let id = table.name("id")?;
        let table = &table.clone().called(&id);
        table.only(&["id", "at", "deviation"])?;
        let Some(kind) = EffectKind::of(&id) else {
            let guess = nearest(&id, library().map(|kind| kind.id));
            let help = guess.map(|name| format!("Did you mean `{name}`?"));
            let help = help.unwrap_or("docs/effects.md lists them.".to_owned());
            return Err(table.wrong("id", "an effect of the library", help));
        };
        let at = table.optional("at", |table, _| place(table, kind, robot))?;
        let mut deviation = vec![0.0; kind.parameters.len()];
        if table.has("deviation") {
            let of = table.table("deviation")?;
            let Some(calibration) = kind.calibration else {
                let message = "stands with an effect that is no calibration; expected it with one";
                let help = "Such an effect is known, and not looked for, or it is not.";
                return Err(of.error(message, help));
            };
            let names: Vec<&str> = kind.parameters.iter().map(|parameter| parameter.name).collect();
            of.only(&names)?;
            // What is usual is expected without a word.
            let usual = kind.parameters.iter().zip(calibration.expected);
            for (value, (parameter, usual)) in deviation.iter_mut().zip(usual) {
                if of.has(parameter.name) {
                    *value = of.number(parameter.name, Bounds::UpTo(*usual))?;
                }
            }
        }
        Ok(Self { kind, at, deviation })
    }

    /// What is known of an effect at a place; what is said of the place before what is said of all.
    pub fn of<'k>(all: &'k [Self], kind: &EffectKind, at: Location) -> Option<&'k Self> {
        let own = || all.iter().filter(|known| known.kind.id == kind.id);
        own().find(|known| known.at == Some(at)).or_else(|| own().find(|known| known.at.is_none()))
    }

    /// True where nothing is left open.
    pub fn is_exact(&self) -> bool {
        self.deviation.iter().all(|deviation| *deviation == 0.0)
    }
}
