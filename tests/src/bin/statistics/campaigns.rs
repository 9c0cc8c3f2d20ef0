//! Writes one synthetic campaign, to try the tools on.

use clap::Args;
use std::path::PathBuf;
use trueweld_laboratory::{OutOfLibrary, OutOfLibraryKind, Recipe};
use trueweld_plant::effects::{Effect, library};
use trueweld_plant::input::{InputFile, RobotFile};
use trueweld_tests::{LABORATORY, fixture};

/// Writes one synthetic measurement campaign, with what was built in stated in its truth.toml.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Folder to write into.
    #[arg(long)]
    out: PathBuf,
    /// An effect of the truth, ID:AT:NAME=VALUE,… or ID alone for a random place and size; may be
    /// repeated.
    #[arg(long)]
    effect: Vec<String>,
    /// An effect outside the library, NAME, or NAME:JOINT with the joint from 1 to 6.
    #[arg(long)]
    outside: Option<String>,
    /// Factor on the size of effects drawn at random and of the one outside the library.
    #[arg(long, default_value_t = 1.0)]
    size: f64,
    /// Standard deviation of the joints' stiffness errors, relative.
    #[arg(long, default_value_t = 0.0)]
    stiffness: f64,
    /// Standard deviation of the encoders' zeros, rad.
    #[arg(long, default_value_t = 0.0)]
    offset: f64,
    /// Standard deviation of the tracker's registration in each log, m.
    #[arg(long, default_value_t = 0.0)]
    registration: f64,
    /// Factor on the noise.
    #[arg(long, default_value_t = 1.0)]
    noise: f64,
    /// Leaves the noise unstated.
    #[arg(long)]
    unstated: bool,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn std::error::Error>> {
    let mut recipe = Recipe::plain(arguments.seed).with_nuisance(
        arguments.stiffness,
        arguments.offset,
        arguments.registration,
    );
    recipe.noise = arguments.noise;
    recipe.noise_stated = !arguments.unstated;
    let robot = RobotFile::read(fixture("robots/kr500-mt.toml"))?;
    for (seed, text) in (arguments.seed..).zip(&arguments.effect) {
        let alone = library().any(|k| k.id == text);
        let effect = if alone {
            let drawn = LABORATORY.draw(text, arguments.size, &recipe.protocol, seed);
            drawn.ok_or_else(|| format!("`{text}` has no usual size: expected its parameters"))?
        } else {
            Effect::parse(text, &robot)?
        };
        recipe = recipe.with_effect(effect);
    }
    if let Some(text) = &arguments.outside {
        let (name, joint) =
            text.split_once(':').map_or((text.as_str(), None), |(name, joint)| (name, Some(joint)));
        let names = OutOfLibraryKind::ALL.map(OutOfLibraryKind::name).join(", ");
        let kind = OutOfLibraryKind::ALL.into_iter().find(|k| k.name() == name);
        let kind = kind.ok_or_else(|| {
            format!("no effect `{name}` outside the library: expected one of {names}")
        })?;
        let mut effect = OutOfLibrary::draw(kind, arguments.size, arguments.seed);
        if let Some(joint) = joint {
            let joint = joint.parse().ok().filter(|j| (1..=6).contains(j));
            let joint: usize =
                joint.ok_or_else(|| format!("`{text}` names no joint from 1 to 6"))?;
            effect.joint = joint - 1;
        }
        recipe = recipe.with_out_of_library(effect);
    }
    LABORATORY.write(&recipe, &arguments.out)?;
    println!("{} written, seed {}", arguments.out.display(), arguments.seed);
    Ok(())
}
