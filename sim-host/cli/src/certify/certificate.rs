//! A certificate held against a run: it is of this cell, this law and this weld, and this is the weld
//! that was asked for, or it says nothing of them.

use miette::{Result, miette};
use serde::Deserialize;
use serde_json::Value;
use std::path::Path;
use trueweld_evaluate::WeldFigures;
use trueweld_evaluate::certify::{Verdict, must_be_of_same};
use trueweld_output::missed_in_words;
use trueweld_plant::input::read_text;
use trueweld_plant::provenance::{Provenance, SimulationRecord, sha256};

/// What is asked of a certificate.
#[derive(Deserialize)]
pub(crate) struct ReadCertificate {
    provenance: Provenance,
    verdict: Verdict,
    weak: Vec<String>,
    law: String,
    sha256: String,
}

/// A certificate, and the SHA-256 of its text without its own.
fn read(text: &str) -> serde_json::Result<(ReadCertificate, String)> {
    let certificate = serde_json::from_str(text)?;
    let mut unsealed: Value = serde_json::from_str(text)?;
    unsealed["sha256"] = "".into();
    Ok((certificate, sha256(format!("{unsealed:#}\n").as_bytes())))
}

/// Checks that a certificate passes and is of what a run is of: the bytes of every file, options,
/// effects and the sources of the program. That its runs came out as it states, only
/// `certify --verify` shows.
///
/// # Errors
/// What the certificate is of instead; a certificate that does not pass, or is none.
pub(crate) fn check(path: &Path, run: &Provenance) -> Result<ReadCertificate> {
    let at = format!("--certificate {}", path.display());
    let (_, text) = read_text(path)?;
    let (certificate, seal) = read(&text)
        .map_err(|error| miette!("{at}: expected certify.json of an evidence folder: {error}"))?;
    if seal != certificate.sha256 {
        return Err(miette!(
            help = "Take it from the evidence folder again; `certify` writes it anew from the runs that are kept there.",
            "{at}: it is not as `certify` wrote it; expected a text of the SHA-256 that it states"
        ));
    }
    let mut of = certificate.provenance.clone();
    let here = |digest: &str| run.files.iter().any(|file| file.sha256 == digest);
    // Of its welds the one that is run, where it is among them.
    let is_among = of.files.iter().any(|f| f.role == "weld" && here(&f.sha256));
    of.files.retain(|f| match f.role.as_str() {
        "requirements" => false,
        "weld" => !is_among || here(&f.sha256),
        _ => true,
    });
    let mut run = run.clone();
    for one in [&mut of, &mut run] {
        one.files.sort_by(|a, b| a.role.cmp(&b.role));
    }
    of.command.clone_from(&run.command);
    if let (Some(of), Some(now)) = (&mut of.simulation, &run.simulation) {
        *of = SimulationRecord {
            welds: now.welds.clone(),
            noise_seed: now.noise_seed,
            draws_seed: now.draws_seed,
            // Of the files and options that are compared, and of each weld alone.
            cores: now.cores.clone(),
            ..of.clone()
        };
    }
    if let Err(difference) = must_be_of_same(&of, &run) {
        return Err(miette!(
            help = "A certificate says nothing of another cell or another build: run `certify` for this one.",
            "{at} is of something else than this run: {difference}"
        ));
    }
    if certificate.verdict != Verdict::Pass {
        return Err(miette!(
            help = "Its page certify.html says why.",
            "{at}: the law {} is not certified for this cell; the certificate says {:?}",
            certificate.law,
            certificate.verdict.name()
        ));
    }
    Ok(certificate)
}

/// Says that a run is certified, with what is weak: it is the weld that was asked for.
///
/// # Errors
/// A run that is not, whatever the certificate says of other noise.
pub(crate) fn tell(path: &Path, certificate: &ReadCertificate, run: &WeldFigures) -> Result<()> {
    let missed = run.judged.iter().filter(|judged| !judged.met).map(missed_in_words);
    let missed: Vec<String> = missed.collect();
    if !missed.is_empty() {
        return Err(miette!(
            help = "Run it without --certificate to see it, and `certify` with this --seed.",
            "--certificate {}: this is not the weld that was asked for: {}",
            path.display(),
            missed.join("; ")
        ));
    }
    let weak = match &certificate.weak[..] {
        [] => String::new(),
        weak => format!("; weak: {}", weak.join("; ")),
    };
    say!("certified: {} in this cell, by {}{weak}\n", certificate.law, path.display());
    Ok(())
}
