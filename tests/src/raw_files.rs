//! A plain log as the instruments of a laboratory would have written it. Nothing here is shared with
//! the code that reads such files.

// Public in one of the crates that take it.
#![allow(unreachable_pub)]

use nalgebra::{Matrix3, Vector3};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use trueweld_core::spatial::rotation_from_vector;

/// How an instrument writes a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PoseForm {
    /// Euler angles as KUKA writes them, degrees.
    Abc,
    /// A quaternion.
    Quaternion,
    /// Points of three reflectors.
    Reflectors,
}

impl PoseForm {
    /// Every form.
    pub const ALL: [Self; 3] = [Self::Abc, Self::Quaternion, Self::Reflectors];
}

/// Where the reflectors sit on the tool, m.
pub const PLACES: [[f64; 3]; 3] = [[0.12, 0.02, -0.05], [-0.08, 0.10, -0.02], [0.01, -0.11, 0.06]];

/// A number with a decimal comma; empty where there is none.
fn comma(value: f64) -> String {
    if value.is_finite() { format!("{value:.9}").replace('.', ",") } else { String::new() }
}

/// Writes a plain log as two instruments do: a controller with semicolons, decimal commas, degrees,
/// milliseconds and one axis the wrong way round, and a tracker with a clock of its own, in mm.
/// `stated`: `log.toml` says how the tracker's clock runs.
///
/// # Panics
/// Where `clean` is no plain log, or `raw` cannot be written.
pub fn raw(clean: &Path, raw: &Path, form: PoseForm, stated: bool) {
    fs::create_dir_all(raw).expect("a folder");
    let text = fs::read_to_string(clean.join("samples.csv")).expect("samples");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|v| v.parse().unwrap_or(f64::NAN)).collect())
        .collect();
    let place = |name: &str| header.iter().position(|h| *h == name);
    let tracker = ["px_m", "py_m", "pz_m", "rx_rad", "ry_rad", "rz_rad"];
    let turned = place("rx_rad").is_some();
    let (offset, drift) = (512.345678, 23e-6);

    let mut columns = vec![(0, "Time [ms]".to_owned(), 1e3)];
    let mut mapping = "\"Time [ms]\" = { channel = \"t\", unit = \"ms\" }\n".to_owned();
    for (k, name) in header.iter().enumerate().skip(1).filter(|(_, n)| !tracker.contains(n)) {
        let (channel, _) = name.split_once('_').expect("a unit");
        let (title, unit, factor, wrong) = match channel {
            "qe3" => ("AXIS_ACT.A3 [deg]".to_owned(), "deg", 180.0 / std::f64::consts::PI, -1.0),
            c if c.starts_with('q') => {
                (format!("{}.{} [deg]", &c[..2], &c[2..]), "deg", 180.0 / std::f64::consts::PI, 1.0)
            }
            c if c.starts_with("tm") => (format!("TORQUE_{}", &c[2..]), "kNm", 1e-3, 1.0),
            "spindle" => ("Drehzahl".to_owned(), "rpm", 60.0 / std::f64::consts::TAU, 1.0),
            "cx" | "cy" | "cz" => (format!("load {channel}"), "mm", 1e3, 1.0),
            "payload" => ("load".to_owned(), "kg", 1.0, 1.0),
            c if c.starts_with('f') => (c.to_uppercase(), "kN", 1e-3, 1.0),
            c => (c.to_uppercase(), "Nm", 1.0, 1.0),
        };
        writeln!(
            mapping,
            "{title:?} = {{ channel = \"{channel}\", unit = \"{unit}\", factor = {wrong:?} }}"
        )
        .expect("text");
        columns.push((k, title, factor * wrong));
    }
    let mut krc = columns.iter().map(|(_, title, _)| title.as_str()).collect::<Vec<_>>().join(";");
    for row in &rows {
        let fields: Vec<String> = columns.iter().map(|(k, _, f)| comma(row[*k] * f)).collect();
        krc += "\r\n";
        krc += &fields.join(";");
    }
    fs::write(raw.join("krc.csv"), krc).expect("krc.csv");

    let titles: Vec<String> = match form {
        _ if !turned => ["X", "Y", "Z"].map(str::to_owned).to_vec(),
        PoseForm::Abc => ["X", "Y", "Z", "A", "B", "C"].map(str::to_owned).to_vec(),
        PoseForm::Quaternion => ["X", "Y", "Z", "Q0", "Q1", "Q2", "Q3"].map(str::to_owned).to_vec(),
        PoseForm::Reflectors => {
            (1..=3).flat_map(|r| ["X", "Y", "Z"].map(|c| format!("R{r}_{c}"))).collect()
        }
    };
    let channels: Vec<String> = match form {
        _ if !turned => ["px", "py", "pz"].map(str::to_owned).to_vec(),
        PoseForm::Abc => ["px", "py", "pz", "a", "b", "c"].map(str::to_owned).to_vec(),
        PoseForm::Quaternion => {
            ["px", "py", "pz", "qw", "qx", "qy", "qz"].map(str::to_owned).to_vec()
        }
        PoseForm::Reflectors => {
            (1..=3).flat_map(|r| ["x", "y", "z"].map(|c| format!("reflector{r}_{c}"))).collect()
        }
    };
    let mut table = format!("Tracker export\nStamp\t{}", titles.join("\t"));
    mapping += "\"Stamp\" = { channel = \"t\", unit = \"s\" }\n";
    for (title, channel) in titles.iter().zip(&channels) {
        let unit = match channel.as_str() {
            "a" | "b" | "c" => "deg",
            q if q.starts_with('q') => "1",
            _ => "mm",
        };
        writeln!(mapping, "{title:?} = {{ channel = \"{channel}\", unit = \"{unit}\" }}")
            .expect("text");
    }
    for row in &rows {
        let at = |name: &str| place(name).map_or(f64::NAN, |k| row[k]);
        let position = Vector3::new(at("px_m"), at("py_m"), at("pz_m"));
        let vector = Vector3::new(at("rx_rad"), at("ry_rad"), at("rz_rad"));
        let r: Matrix3<f64> = rotation_from_vector(&vector);
        let mut values: Vec<f64> = Vec::new();
        if !turned || form != PoseForm::Reflectors {
            values.extend((position * 1e3).iter());
        }
        match form {
            _ if !turned => {}
            PoseForm::Abc => {
                let angles =
                    [r.m21.atan2(r.m11), -r.m31.asin(), r.m32.atan2(r.m33)].map(f64::to_degrees);
                values.extend(angles);
            }
            PoseForm::Quaternion => {
                let half = 0.5 * vector.norm();
                let sine = half.sin() / vector.norm();
                values.push(half.cos());
                values.extend(vector.iter().map(|v| v * sine));
            }
            PoseForm::Reflectors => {
                for place in PLACES {
                    values.extend(((position + r * Vector3::from(place)) * 1e3).iter());
                }
            }
        }
        let stamp = offset + (1.0 + drift) * row[0];
        let fields: Vec<String> = values.iter().map(|v| format!("{v:.8}")).collect();
        write!(table, "\n{stamp:.9}\t{}", fields.join("\t")).expect("text");
    }
    fs::write(raw.join("tracker.txt"), table).expect("tracker.txt");

    // What the clean log says besides: kind, paths, noise.
    let toml = fs::read_to_string(clean.join("log.toml")).expect("log.toml");
    let toml =
        toml.replace("\"../", &format!("\"{}/", clean.parent().expect("a parent").display()));
    let toml = toml.replace("\"weld.toml\"", &format!("{:?}", clean.join("weld.toml")));
    let (top, noise) = toml.split_once("[noise]").expect("noise");
    let clock =
        if stated { format!("offset_s = {offset}\ndrift = {drift}\n") } else { String::new() };
    let files = "files = [ { path = \"krc.csv\", clock = \"krc\", delimiter = \";\", decimal = \",\" },\n\
                 { path = \"tracker.txt\", clock = \"tracker\", delimiter = \"\\t\", header = 2 } ]\n";
    let places: String =
        PLACES.iter().enumerate().map(|(i, p)| format!("reflector{}_m = {p:?}\n", i + 1)).collect();
    let places = if form == PoseForm::Reflectors { places } else { String::new() };
    fs::write(
        raw.join("log.toml"),
        format!(
            "{top}{files}[noise]{noise}\n[clock.tracker]\n{clock}[reflectors]\n{places}[columns]\n{mapping}"
        ),
    )
    .expect("log.toml");
}
