//! What the robot's own instruments hold of its stiffness during a weld: the Fisher information of
//! the way that the arm bends towards the plate, and what it leaves of the lateral deviation. To
//! first order, about the nominal cell: a bound for every law that has no external sensor and no
//! motion of its own (docs/laws.md).

use nalgebra::{DMatrix, SMatrix};
use trueweld_core::{JOINTS, Wrench};
use trueweld_plant::input::{InputFile, Process, Weld};
use trueweld_plant::process::planned;
use trueweld_plant::simulate::{Seam, start_angles};
use trueweld_tests::{KR500, fixture};

/// Places along the seam at which depth is read: as far apart as a plate is uneven.
const PLACES: usize = 41;

/// Standard deviation of each compliance, relative.
const PRIOR: f64 = 0.3;

/// What is known of the plate: offset, m, slope, rad, and unevenness, m; and of the compliance of A5
/// from elsewhere.
struct Known {
    offset: f64,
    slope: f64,
    uneven: f64,
    a5: f64,
}

const LEVEL: Known = Known { offset: 2.5e-4, slope: 1e-9, uneven: 5e-5, a5: PRIOR };
const TILTED: Known = Known { slope: 1e-4, ..LEVEL };

/// Lateral and depth displacement in W per relative error of each compliance, along a weld.
fn displacements(weld: &str) -> Vec<[[f64; JOINTS]; 2]> {
    let weld = Weld::read(fixture(weld)).expect("a fixture");
    let process = Process::read(fixture("processes/lap-weld-2024-t3.toml")).expect("a fixture");
    let (seam, robot) = (Seam::of(&weld), &*KR500);
    let force = planned(&process, weld.force, weld.feed);
    let mut near = start_angles(robot, &seam).expect("in reach");
    let at = |k: usize| {
        let path = seam.length * k as f64 / (PLACES - 1) as f64;
        near = robot.inverse_near(&seam.nominal(path), &near).expect("in reach");
        let w = seam.axes(path);
        let load = Wrench { moment: nalgebra::Vector3::zeros(), force: w * force };
        let jacobian = robot.frames(&near).jacobian().0;
        let torsion = -jacobian.tr_mul(&load.to_vector()).component_div(robot.stiffness());
        let linear = w.transpose() * jacobian.fixed_rows::<3>(3);
        [1, 2].map(|row| std::array::from_fn(|i| linear[(row, i)] * torsion[i]))
    };
    (0..PLACES).map(at).collect()
}

/// Lateral RMS along the weld, m, one standard deviation: before anything is read, and after.
fn lateral(of: &[[[f64; JOINTS]; 2]], length: f64, known: &Known) -> [f64; 2] {
    let mut prior = SMatrix::<f64, 8, 8>::zeros();
    for i in 0..JOINTS {
        prior[(i, i)] = if i == 4 { known.a5.powi(-2) } else { PRIOR.powi(-2) };
    }
    (prior[(6, 6)], prior[(7, 7)]) = (known.offset.powi(-2), known.slope.powi(-2));
    let mut information = prior;
    for (k, [_, depth]) in of.iter().enumerate() {
        let path = length * k as f64 / (of.len() - 1) as f64;
        let row = DMatrix::from_fn(1, 8, |_, i| match i {
            6 => 1.0,
            7 => path,
            i => depth[i],
        });
        information += (row.transpose() * row).fixed_view::<8, 8>(0, 0) / known.uneven.powi(2);
    }
    let after = information.try_inverse().expect("regular");
    let before = SMatrix::<f64, 8, 8>::identity() * PRIOR.powi(2);
    [before, after].map(|covariance| {
        let of_place = |lateral: &[f64; JOINTS]| -> f64 {
            (0..JOINTS)
                .flat_map(|i| (0..JOINTS).map(move |j| (i, j)))
                .map(|(i, j)| lateral[i] * covariance[(i, j)] * lateral[j])
                .sum()
        };
        let squares: f64 = of.iter().map(|[lateral, _]| of_place(lateral)).sum();
        (squares / of.len() as f64).sqrt()
    })
}

#[test]
fn the_plate_tells_the_joints_that_have_a_lever_into_it() {
    for (weld, expected) in [
        ("welds/vertical.toml", [0.90, 0.40, 0.61, 0.22]),
        ("welds/inclined.toml", [0.80, 0.35, 0.50, 0.20]),
    ] {
        let of = displacements(weld);
        let [before, level] = lateral(&of, 2.0, &LEVEL);
        let [_, tilted] = lateral(&of, 2.0, &TILTED);
        let [_, with_a5] = lateral(&of, 2.0, &Known { a5: 0.1, ..LEVEL });
        let found = [before, level, tilted, with_a5].map(|v| 1e3 * v);
        println!("{weld}: {found:.3?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 0.015, "{weld}: {found} {expected}");
        }
        // What stays is A5's, whose axis lies in the line of the push: no lever into the plate.
        let mean = |row: usize, i: usize| {
            of.iter().map(|at| at[row][i].abs()).sum::<f64>() / of.len() as f64
        };
        assert!(mean(1, 4) < 0.01 * mean(1, 1) && mean(0, 4) > 0.5e-3);
    }
}
