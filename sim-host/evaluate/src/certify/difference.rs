//! What two results differ in that should be of the same.

use miette::{Result, miette};
use serde_json::Value;
use trueweld_plant::provenance::{FileDigest, Provenance};

/// Checks that a result that was made is of the same as the one that is asked for; where files lie
/// does not count.
///
/// # Errors
/// The first thing in which they differ.
pub fn must_be_of_same(made: &Provenance, asked: &Provenance) -> Result<()> {
    let Provenance { version, sources, command, .. } = asked;
    if made.version != *version {
        let made = &made.version;
        return Err(miette!("made by version {made} of the program, and this is {version}"));
    }
    if made.sources != *sources {
        let made = &made.sources;
        return Err(miette!("made by a build of the sources {made}, and this is one of {sources}"));
    }
    if made.command != *command {
        return Err(miette!("made by `{}`, and this is `{command}`", made.command));
    }
    for i in 0..made.files.len().max(asked.files.len()) {
        match (made.files.get(i), asked.files.get(i)) {
            (Some(a), Some(b)) if (&a.role, &a.sha256) == (&b.role, &b.sha256) => {}
            (Some(FileDigest { role, file, .. }), _) => {
                return Err(miette!("its {role} file was {file}"));
            }
            (None, Some(FileDigest { role, .. })) => {
                return Err(miette!("it had no {role} file"));
            }
            (None, None) => {}
        }
    }
    let value = |provenance: &Provenance| {
        let plain = Provenance { files: Vec::new(), warnings: Vec::new(), ..provenance.clone() };
        serde_json::to_value(plain).unwrap_or_default()
    };
    let (made, asked) = (value(made), value(asked));
    if let [Some(then), Some(now)] = [&made, &asked].map(|all| all["simulation"].as_object()) {
        for (name, then) in then {
            let now = now.get(name).unwrap_or(&Value::Null);
            if then != now {
                return Err(miette!("{name} was {then}, and is {now}"));
            }
        }
    }
    if made != asked {
        return Err(miette!("robot or effects differ"));
    }
    Ok(())
}
