//! The library as C sees it: compiled by gcc with its sanitizers, and compared with Rust bit for bit.
//!
//! Without gcc on the machine these tests are skipped, and say so.

use nalgebra::{Matrix3, Vector3};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use trueweld_compensators::{Law, LawNumbers, Name, RunningCore, Visitor, for_each};
use trueweld_core::compensation::{DeviationMeasurement, Observation};
use trueweld_core::control::{SensorReadings, Setpoint};
use trueweld_core::scalar::lit;
use trueweld_core::{JointVector, Pose, Real, Robot, Twist, Wrench};

/// The cell of the example, as `trueweld export-core` writes it.
mod cell {
    include!("../examples/cell.rs");
}

/// Control cycles of a test weld.
const CYCLES: usize = 300;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// The static library; `None` where there is no gcc to link it.
fn library() -> Option<&'static Path> {
    static BUILT: OnceLock<Option<PathBuf>> = OnceLock::new();
    let built = BUILT.get_or_init(|| {
        if Command::new("gcc").arg("--version").output().is_err() {
            eprintln!("SKIPPED: there is no gcc on this machine");
            return None;
        }
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("it is in a folder");
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let status = Command::new(cargo)
            .args(["rustc", "--release", "--locked", "--lib", "--crate-type", "staticlib"])
            .args(["--features", "archive", "--quiet", "--manifest-path"])
            .arg(folder("Cargo.toml"))
            .arg("--target-dir")
            .arg(target)
            .status();
        assert!(status.expect("cargo runs").success(), "the library is not built");
        Some(target.join("release/libtrueweld_c.a"))
    });
    built.as_deref()
}

/// Compiles a C program with the library and the sanitizers; it links only without a panic path.
fn compiled(source: &str, name: &str, options: &[&str]) -> Option<PathBuf> {
    let library = library()?;
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let output = Command::new("gcc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-g", "-O1"])
        .args(["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-Wl,--gc-sections"])
        .args(options)
        .arg("-I")
        .arg(folder("include"))
        .arg("-I")
        .arg(folder("examples"))
        .arg(folder(source))
        .arg(library)
        .arg("-o")
        .arg(&program)
        .output()
        .expect("gcc runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(program)
}

#[test]
fn misuse_gives_an_error_code_and_changes_nothing() {
    let Some(program) = compiled("tests/misuse.c", "misuse", &[]) else { return };
    let output = Command::new(program).output().expect("it runs");
    let [printed, errors] =
        [output.stdout, output.stderr].map(|o| String::from_utf8_lossy(&o).into_owned());
    assert!(output.status.success() && printed.is_empty(), "{printed}{errors}");
}

#[test]
fn a_weld_in_c_is_the_weld_in_rust_bit_for_bit_under_every_law_in_float() {
    compare_all::<f32>("weld-float", &[]);
}

#[test]
fn a_weld_in_c_is_the_weld_in_rust_bit_for_bit_under_every_law_in_double() {
    compare_all::<f64>("weld-double", &["-DDOUBLE"]);
}

/// The constants and the header in a program of C++17, which firmware for PLCs is compiled as.
#[test]
fn the_headers_are_cpp_17() {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("headers.cpp");
    let text = "typedef int Needs;\n#include \"cell.h\"\nint main() { return trueweld_cell.law.reserved; }\n";
    fs::write(&program, text).expect("the folder is there");
    let compiler = Command::new("g++")
        .args(["-std=c++17", "-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only", "-I"])
        .arg(folder("include"))
        .arg("-I")
        .arg(folder("examples"))
        .arg(&program)
        .output();
    let Ok(output) = compiler else { return eprintln!("SKIPPED: there is no g++ on this machine") };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// One weld under a law: what every period is given, and what it commands.
struct Weld<'a> {
    law: &'a str,
    given: Vec<f64>,
    expected: Vec<f64>,
}

/// Status, torques and corrections.
const OUTPUTS: usize = 13;

fn compare_all<T: Real + Into<f64>>(name: &str, options: &[&str]) {
    let Some(program) = compiled("examples/weld.c", name, options) else { return };
    struct Names(Vec<&'static str>);
    impl<T: Real> Visitor<T> for Names {
        fn visit<L: Law<T>>(&mut self) {
            self.0.push(L::NAME);
        }
    }
    let mut names = Names(Vec::new());
    for_each::<T>(&mut names);
    assert!(names.0.len() > 6, "{:?}", names.0);
    for law in names.0 {
        let mut weld = Weld { law, given: Vec::new(), expected: Vec::new() };
        for_each::<T>(&mut Each(&mut weld));
        let files = ["given", "told"].map(|file| program.with_extension(format!("{law}.{file}")));
        let bytes: Vec<u8> = weld.given.iter().flat_map(|n| n.to_le_bytes()).collect();
        fs::write(&files[0], bytes).expect("the folder is there");
        let status = Command::new(&program).arg(law).args(&files).status().expect("it runs");
        assert!(status.success(), "{law}");
        let bytes = fs::read(&files[1]).expect("it was written");
        assert_eq!(bytes.len(), CYCLES * OUTPUTS * 8, "{law}");
        let told = bytes.chunks_exact(8).map(|b| b.try_into().map(u64::from_le_bytes));
        let told: Vec<u64> = told.map(|bits| bits.expect("eight bytes")).collect();
        let expected: Vec<u64> = weld.expected.iter().map(|n| n.to_bits()).collect();
        for (k, (c, rust)) in told.chunks(OUTPUTS).zip(expected.chunks(OUTPUTS)).enumerate() {
            assert_eq!(c, rust, "{law}, cycle {k}");
        }
        // Otherwise nothing was compared but faults.
        let faults = weld.expected.chunks(OUTPUTS).filter(|cycle| cycle[0] != 0.0).count();
        assert!((1..20).contains(&faults), "{law}: {faults} faults");
    }
}

struct Each<'a, 'b>(&'a mut Weld<'b>);

impl<T: Real + Into<f64>> Visitor<T> for Each<'_, '_> {
    fn visit<L: Law<T>>(&mut self) {
        if L::NAME != self.0.law {
            return;
        }
        let mut configuration = cell::CONFIGURATION;
        // The law's defaults, as the C program takes them.
        configuration.law =
            LawNumbers { name: Name::new(L::NAME), gain_count: 0, ..configuration.law };
        let core = RunningCore::<T, L::Built>::new::<L>(&configuration).expect("a core");
        weld::<T, L>(core, self.0);
    }
}

/// A tool that moves along y of B with the load of a weld, seen by two readings of a seam sensor a
/// period; a force sensor, an encoder, a set-point and a seam sensor that give no number for a
/// period each.
fn weld<T: Real + Into<f64>, L: Law<T>>(mut core: RunningCore<T, L::Built>, weld: &mut Weld<'_>) {
    let z = -Vector3::<T>::z();
    let x = Vector3::<T>::y();
    let rotation = Matrix3::from_columns(&[x, z.cross(&x), z]);
    // T as the seam has it: its z into the part, its y along the seam.
    let b_from_t = Matrix3::from_columns(&[x.cross(&z), x, z]);
    let robot: Robot<T> = core.robot().clone();
    let pose = |k: usize| Pose {
        rotation: b_from_t,
        position: Vector3::new(lit(1.7), lit(-0.3 + 1.2e-4 * k as f64), lit(0.5)),
    };
    let all = robot.inverse_all(&pose(0)).expect("within reach");
    let mut encoder =
        *all.iter().map(|(_, q)| q).find(|q| robot.beyond_limits(q).is_none()).expect("a branch");
    let torque = JointVector::<T>::repeat(lit(500.0));
    core.start(&encoder, &torque);
    put(&mut weld.given, encoder.iter().chain(torque.iter()).copied());
    for k in 0..CYCLES {
        let nominal = pose(k);
        let before = encoder;
        encoder = robot.inverse_near(&nominal, &encoder).expect("within reach");
        let mut setpoint = Setpoint {
            pose: robot.forward_kinematics(&robot.fake_target(&encoder, &Wrench::zero())),
            b_from_w: rotation,
            force: (k >= 20).then(|| lit(18e3)),
            spindle_speed: lit(-62.83),
        };
        let ripple = 50.0 * ((k % 5) as f64 - 2.0) + 0.01 * k as f64;
        let force: [f64; 3] = [1e3, -4e3, -18e3 + ripple];
        let wrench = Wrench { moment: Vector3::zeros(), force: Vector3::from(force.map(lit::<T>)) };
        let frames = robot.frames(&encoder);
        let load = wrench.rotated(&frames.tcp.rotation);
        let mut sensed = SensorReadings {
            encoder,
            encoder_rate: (encoder - before) / lit::<T>(0.012),
            motor_torque: robot.spring_torque_at_rest(&frames, &encoder, &load),
            wrench,
        };
        let across = Twist { angular: Vector3::z() * lit::<T>(0.02), linear: Vector3::y() };
        let tilted = Twist { angular: Vector3::x(), linear: Vector3::zeros() };
        let mut measurements = [across, tilted].map(|along| DeviationMeasurement {
            deviation: lit(1e-5 * ((k * 7) % 11) as f64 - 2e-5),
            along,
            noise: lit(5e-5),
            age: lit(0.012),
            ahead: lit(0.02),
        });
        match k {
            120 => sensed.wrench.force.x = lit(f64::NAN),
            130 => sensed.encoder[3] = lit(f64::NAN),
            140 => setpoint.pose.position.y = lit(f64::NAN),
            150 => measurements[0].deviation = lit(f64::NAN),
            160 => measurements[1].noise = lit(f64::INFINITY),
            _ => {}
        }
        let seen = if k % 3 == 0 { &measurements[..] } else { &[] };
        let planned = Wrench {
            moment: Vector3::zeros(),
            force: Vector3::new(lit(-4e3), lit(1e3), lit(-18e3)),
        };
        let observation = Observation {
            path: lit(1.2e-4 * k as f64),
            planned,
            measurements: seen,
            ..Observation::of_robot(&setpoint, &nominal, &sensed)
        };
        give(&mut weld.given, &observation);
        let command = core.cycle(&observation);
        let status = command.fault.map_or(0, |fault| match fault {
            trueweld_core::Fault::Encoder(_) => 1,
            trueweld_core::Fault::Force => 2,
            trueweld_core::Fault::Setpoint => 3,
            trueweld_core::Fault::Singular => 4,
            trueweld_core::Fault::Limit(_) => 5,
            trueweld_core::Fault::Compensation => 6,
        });
        weld.expected.push(f64::from(status));
        put(&mut weld.expected, command.torque.iter().copied());
        put(&mut weld.expected, core.correction().to_vector().iter().copied());
    }
}

fn put<T: Real + Into<f64>>(to: &mut Vec<f64>, values: impl IntoIterator<Item = T>) {
    to.extend(values.into_iter().map(Into::<f64>::into));
}

/// An observation as the C program reads it.
fn give<T: Real + Into<f64>>(to: &mut Vec<f64>, observation: &Observation<'_, T>) {
    let Observation { setpoint, nominal, sensed, path, planned, measurements, .. } = observation;
    to.push(f64::from(setpoint.force.is_some()));
    let rows = |m: &Matrix3<T>| m.transpose().iter().copied().collect::<Vec<T>>();
    for pose in [&setpoint.pose, nominal] {
        put(to, rows(&pose.rotation));
        put(to, pose.position.iter().copied());
    }
    put(to, rows(&setpoint.b_from_w));
    put(to, [setpoint.force.unwrap_or(T::zero()), setpoint.spindle_speed]);
    for six in [&sensed.encoder, &sensed.encoder_rate, &sensed.motor_torque] {
        put(to, six.iter().copied());
    }
    put(to, sensed.wrench.to_vector().iter().copied());
    put(to, [*path]);
    put(to, planned.to_vector().iter().copied());
    to.push(measurements.len() as f64);
    for m in *measurements {
        put(to, [m.deviation]);
        put(to, m.along.to_vector().iter().copied());
        put(to, [m.noise, m.age, m.ahead]);
    }
}

#[test]
fn no_law_needs_more_memory_than_the_constants_say() {
    for (bytes, most) in [
        (largest::<f32>(), trueweld_c::MEMORY_BYTES_F32),
        (largest::<f64>(), trueweld_c::MEMORY_BYTES_F64),
    ] {
        // Not so much more that the constant would be of nothing.
        assert!(bytes <= most && bytes * 3 / 2 > most, "{bytes} of {most}");
    }
}

/// Bytes of the largest law, asked for through the interface.
fn largest<T: Real>() -> usize {
    struct Most(usize);
    impl<T: Real> Visitor<T> for Most {
        fn visit<L: Law<T>>(&mut self) {
            let mut configuration = cell::CONFIGURATION;
            configuration.law.name = Name::new(L::NAME);
            let mut bytes = 0;
            // SAFETY: both pointers are to what their types say.
            let status = unsafe {
                if size_of::<T>() == 4 {
                    trueweld_c::trueweld_f32_bytes(&configuration, &mut bytes)
                } else {
                    trueweld_c::trueweld_f64_bytes(&configuration, &mut bytes)
                }
            };
            assert_eq!(status, trueweld_c::Status::Ok);
            self.0 = self.0.max(bytes);
        }
    }
    let mut most = Most(0);
    for_each::<T>(&mut most);
    most.0
}

#[test]
fn the_constants_carry_the_digest_of_what_they_are() {
    assert_eq!(cell::DIGEST, cell::CONFIGURATION.digest());
}
