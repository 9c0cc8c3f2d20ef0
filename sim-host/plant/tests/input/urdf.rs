//! URDFs become robot files, and what they do not say must be filled in.

use crate::input::{URDF, fixture, rendered};
use nalgebra::{Matrix3, Matrix4, Rotation3, Vector3, Vector4};
use std::fs;
use trueweld_plant::input::*;

/// The imported text with its markers filled in.
fn filled(text: &str) -> String {
    let fill = |line: &str| match line.split_once(" = \"FILL IN") {
        None => format!("{line}\n"),
        Some((key, _)) => {
            let value = match key {
                "gravity_m_s2" => "[0.0, 0.0, -9.80665]",
                "cos_nm" => "[]",
                "viscous_nms_rad" | "coulomb_nm" => "[1, 1, 1, 1, 1, 1]",
                _ => "1.0",
            };
            format!("{key} = {value}\n")
        }
    };
    text.lines().map(fill).collect()
}

#[test]
fn an_imported_urdf_keeps_its_bodies_and_geometry() {
    let text = import_urdf(fixture("robots/arm6.urdf")).unwrap();
    let file = RobotFile::parse(&filled(&text), "arm6.toml").unwrap();
    assert_eq!(file.name, "arm6");
    let p = &file.parameters;
    assert_eq!(p.joints.map(|j| j.mass), [900.0, 550.0, 600.0, 120.0, 80.0, 250.0]);
    assert_eq!(p.joints.map(|j| j.mass).iter().sum::<f64>(), 2500.0);
    let expected = [
        (Vector3::new(0.0, 0.0, 0.675), Vector3::z()),
        (Vector3::new(0.5, 0.0, 0.37), Vector3::y()),
        (Vector3::new(0.0, 0.0, 1.3), Vector3::y()),
        (Vector3::new(1.025, 0.0, -0.055), Vector3::x()),
        (Vector3::new(0.25, 0.0, 0.0), Vector3::y()),
        (Vector3::new(0.29, 0.0, 0.0), Vector3::x()),
    ];
    for (i, (j, (origin, axis))) in p.joints.iter().zip(expected).enumerate() {
        assert!((j.origin - origin).norm() < 1e-11, "origin of joint {i}");
        assert_eq!(j.axis, axis);
        assert!((j.limits[1] - 6.0).abs() < 1e-12 && (j.max_rate - 10.0).abs() < 1e-11);
        assert_eq!(j.max_torque, 1e6);
    }
    assert!((p.joints[5].center_of_mass - Vector3::new(0.25, 0.0, -0.1)).norm() < 1e-11);
    assert!((p.joints[2].inertia.diagonal() - Vector3::new(30.0, 120.0, 115.0)).norm() < 1e-11);
    // The tool frame: 0.4 m on, 0.15 m down, turned by 45 degrees about y.
    let half = 0.5f64.sqrt();
    assert!(
        (p.tool.flange_offset + p.tool.tcp_from_flange - Vector3::new(0.4, 0.0, -0.15)).norm()
            < 1e-11
    );
    assert!((p.tool.z_axis - Vector3::new(half, 0.0, half)).norm() < 1e-11);
    assert_eq!((p.tool.y_axis, p.tool.mass), (Vector3::y(), 0.0));
}

#[test]
fn the_shipped_arm_is_its_urdf_filled_in() {
    let text = import_urdf(fixture("robots/kr210-r2700.urdf")).unwrap();
    let (robot, tool) = text.split_once("[tool]").unwrap();
    let filled = std::fs::read_to_string(fixture("robots/kr210-fsw.toml")).unwrap();
    for line in robot.lines().filter(|line| line.contains(" = ") && !line.starts_with('#')) {
        let (key, value) = line.split_once(" = ").unwrap();
        if value.contains("FILL IN") {
            let of = |l: &&str| l.starts_with(key) && l.ends_with("# filled in");
            assert!(filled.lines().any(|l| of(&l)), "{key}");
        } else if !value.contains("KR 210") {
            assert!(filled.lines().any(|l| l == line), "{line}");
        }
    }
    let offset = tool.lines().find(|line| line.starts_with("flange_offset_m")).unwrap();
    assert!(filled.lines().any(|line| line == offset));
    let file = RobotFile::read(fixture("robots/kr210-fsw.toml")).unwrap();
    // 645 + 1150 + 115 mm up with the upper arm upright, 330 + 1220 + 215 + 350 mm out.
    let upright = [0.0, -90.0_f64.to_radians(), 90.0_f64.to_radians(), 0.0, 0.0, 0.0];
    let tool = file.robot.forward_kinematics(&upright.into()).position;
    assert!((tool - Vector3::new(2.115, 0.0, 1.91)).norm() < 1e-9, "{tool}");
}

#[test]
fn what_a_urdf_cannot_say_must_be_filled_in() {
    let text = import_urdf_text(URDF, "arm6.urdf").unwrap();
    for key in [
        "gravity_m_s2",
        "stiffness_nm_rad",
        "damping_nms_rad",
        "rotor_inertia_kg_m2",
        "viscous_nms_rad",
        "coulomb_nm",
        "smoothing_rad_s",
        "cos_nm",
    ] {
        let start = format!("{key} = ");
        let marker =
            text.lines().find(|l| l.starts_with(&format!("{start}\"FILL IN: "))).expect(key);
        // Everything filled in but this one value: the reader names it.
        let rest =
            |line: &str| format!("{}\n", if line.starts_with(&start) { marker } else { line });
        let left: String = filled(&text).lines().map(rest).collect();
        let shown = rendered(&RobotFile::parse(&left, "dir/arm.toml").unwrap_err());
        for needle in ["dir/arm.toml:", key, "still to be filled in", "expected"] {
            assert!(shown.contains(needle), "{shown}");
        }
    }
}

/// A URDF in which every frame is turned and every link is split in two by a fixed joint.
fn turned_urdf() -> String {
    let mut xml = r#"<robot name="turned"><link name="world"/><link name="base"/>
        <joint name="floor" type="fixed"><parent link="world"/><child link="base"/>
        <origin xyz="0 0 0.2" rpy="0 0 1.5707963267948966"/></joint>"#
        .to_owned();
    let mut parent = "base".to_owned();
    for i in 1..=6 {
        xml += &format!(
            r#"<link name="l{i}"><inertial><origin xyz="0.1 0.2 0.3" rpy="0.3 -0.2 0.5"/><mass value="{i}0"/>
            <inertia ixx="3" iyy="4" izz="5" ixy="0.1" ixz="-0.2" iyz="0.3"/></inertial></link>
            <link name="m{i}"><inertial><origin xyz="0 0 0.1"/><mass value="2"/>
            <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
            <joint name="j{i}" type="revolute"><parent link="{parent}"/><child link="l{i}"/>
            <origin xyz="0.5 -0.1 0.2" rpy="0.4 0.5 -0.6"/><axis xyz="0 0 2"/>
            <limit lower="-1" upper="2" effort="30" velocity="4"/></joint>
            <joint name="f{i}" type="fixed"><parent link="l{i}"/><child link="m{i}"/>
            <origin xyz="0.3 0 0" rpy="1.5707963267948966 0 0"/></joint>"#
        );
        parent = format!("m{i}");
    }
    xml + r#"<link name="tool0"/><joint name="t" type="fixed"><parent link="m6"/><child link="tool0"/>
        <origin xyz="0 0 0" rpy="0.4 0 0"/></joint></robot>"#
}

/// The turned arm against sums over its bodies, each placed by a product of homogeneous transforms.
#[test]
fn links_are_merged_and_turned_into_base_axes() {
    let transform = |x: [f64; 3], [roll, pitch, yaw]: [f64; 3]| {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), pitch)
            * Rotation3::from_axis_angle(&Vector3::x_axis(), roll);
        Matrix4::new_translation(&Vector3::from(x)) * turn.to_homogeneous()
    };
    let column = |m: &Matrix4<f64>, i: usize| Vector3::new(m[(0, i)], m[(1, i)], m[(2, i)]);
    let quarter = std::f64::consts::FRAC_PI_2;
    let text = import_urdf_text(&turned_urdf(), "t.urdf").unwrap();
    let file = RobotFile::parse(&filled(&text), "t.toml").unwrap();
    let uneven = Matrix3::new(3.0, 0.1, -0.2, 0.1, 4.0, 0.3, -0.2, 0.3, 5.0);
    // A symmetric tensor is fixed by the energy of turning about the axes and about the diagonals
    // between them.
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let turns = [x, y, z, x + y, x + z, y + z];

    let mut parent = transform([0.0, 0.0, 0.2], [0.0, 0.0, quarter]);
    let mut origin = Vector3::zeros();
    for (i, j) in file.parameters.joints.iter().enumerate() {
        let l = parent * transform([0.5, -0.1, 0.2], [0.4, 0.5, -0.6]);
        let m = l * transform([0.3, 0.0, 0.0], [quarter, 0.0, 0.0]);
        let at = column(&l, 3);
        assert!((j.origin - (at - origin)).norm() < 1e-11, "origin of joint {i}");
        assert!((j.axis - (l * Vector4::z()).xyz()).norm() < 1e-11, "axis of joint {i}");
        let bodies = [
            (10.0 * (i + 1) as f64, l * transform([0.1, 0.2, 0.3], [0.3, -0.2, 0.5]), uneven),
            (2.0, m * transform([0.0, 0.0, 0.1], [0.0; 3]), Matrix3::identity()),
        ];
        let mass: f64 = bodies.iter().map(|b| b.0).sum();
        let com =
            bodies.iter().map(|(mass, pose, _)| column(pose, 3) * *mass).sum::<Vector3<f64>>()
                / mass;
        assert!((j.mass - mass).abs() < 1e-12);
        assert!((j.center_of_mass - (com - at)).norm() < 1e-11, "centre of link {i}");
        for w in turns {
            let energy = |(mass, pose, inertia): &(f64, Matrix4<f64>, Matrix3<f64>)| {
                let local = pose.fixed_view::<3, 3>(0, 0).transpose() * w;
                local.dot(&(inertia * local))
                    + mass * w.cross(&(column(pose, 3) - com)).norm_squared()
            };
            let sum: f64 = bodies.iter().map(energy).sum();
            assert!((w.dot(&(j.inertia * w)) - sum).abs() < 1e-9, "inertia of link {i}");
        }
        (parent, origin) = (m, at);
    }
    // tool0 is the flange; it sits on the last link's second half.
    let t = &file.parameters.tool;
    let tool = parent * transform([0.0; 3], [0.4, 0.0, 0.0]);
    assert!(
        (t.flange_offset - (column(&parent, 3) - origin)).norm() < 1e-11
            && t.tcp_from_flange.norm() < 1e-11
    );
    assert!(
        (t.z_axis - column(&tool, 2)).norm() < 1e-11
            && (t.y_axis - column(&tool, 1)).norm() < 1e-11
    );
}

/// As [`mistake`], in the URDF.
#[track_caller]
fn urdf_mistake(from: &str, to: &str, needles: &[&str]) {
    let broken = URDF.replacen(from, to, 1);
    assert_ne!(broken, URDF, "the fixture no longer holds `{from}`");
    let error = import_urdf_text(&broken, "dir/arm.urdf").expect_err(to);
    let shown = rendered(&error);
    for needle in [&["dir/arm.urdf", "expected"], needles].concat() {
        assert!(shown.contains(needle), "`{needle}` is not in:\n{shown}");
    }
    assert!(!error.help_text().is_empty());
}

#[test]
fn a_urdf_that_is_no_six_axis_arm_is_refused() {
    let a3 = r#"<joint name="A3" type="revolute">"#;
    urdf_mistake(
        a3,
        r#"<joint name="A3" type="prismatic">"#,
        &["dir/arm.urdf:10:", "`A3` is prismatic", "revolute"],
    );
    urdf_mistake(a3, r#"<joint name="A3" type="planar">"#, &["`A3` is planar"]);
    urdf_mistake(a3, r#"<joint name="A3" type="hinge">"#, &["<joint>", "hinge"]);
    urdf_mistake(a3, r#"<joint name="A3" type="fixed">"#, &["5 revolute joints", "expected six"]);
    urdf_mistake(
        r#"name="tool" type="fixed""#,
        r#"name="tool" type="revolute""#,
        &["`tool`", "number 7"],
    );
    let (on_l2, on_l1) = (r#"<parent link="l2"/>"#, r#"<parent link="l1"/>"#);
    urdf_mistake(on_l2, on_l1, &["`A2` and `A3` branch"]);
    urdf_mistake(r#"<parent link="base"/>"#, r#"<parent link="tcp"/>"#, &["not connected"]);
    urdf_mistake(r#"<child link="l1"/>"#, r#"<child link="l2"/>"#, &["hangs on joint"]);
    urdf_mistake(
        r#"<child link="l1"/>"#,
        r#"<child link="l11"/>"#,
        &["`l11`", "Did you mean `l1`?"],
    );
    urdf_mistake(r#"<link name="l2">"#, r#"<link name="l1">"#, &["another link `l1`"]);
    urdf_mistake(
        r#"<link name="tcp"/>"#,
        r#"<link name="tcp"/><link name="table"/>"#,
        &["`base` and `table`"],
    );
    let axis = r#"<axis xyz="0 0 1"/>"#;
    urdf_mistake(axis, r#"<axis xyz="0 0 0"/>"#, &["`A1` is 0 0 0"]);
    let seventh = r#"<link name="l7"><inertial><mass value="1"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="A7" type="revolute"><parent link="tcp"/><child link="l7"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#;
    urdf_mistake("</robot>", seventh, &["`A7`", "number 7", "expected six"]);
}

#[test]
fn bad_numbers_and_broken_xml_in_a_urdf_are_shown() {
    let mass = r#"<mass value="550"/>"#;
    urdf_mistake(
        mass,
        r#"<mass value="much"/>"#,
        &["dir/arm.urdf:7:", "`value` of <mass> is \"much\"", "one finite"],
    );
    urdf_mistake(mass, r#"<mass value="-550"/>"#, &["`l2` is -550 kg"]);
    urdf_mistake(mass, "", &["<link>", "mass"]);
    urdf_mistake(r#"iyz="0""#, "", &["<link>", "iyz"]);
    let place = r#"xyz="0.2 0 0.15""#;
    urdf_mistake(place, r#"xyz="0.2 0""#, &["\"0.2 0\"", "3 finite numbers"]);
    urdf_mistake(place, r#"xyz="0.2 nan 0.15""#, &["0.2 nan 0.15"]);
    urdf_mistake(place, r#"xyz="${a} 0 0.15""#, &["${a}"]);
    urdf_mistake(
        r#"<link name="l3"><inertial>"#,
        r#"<link name="l3"><inertia>"#,
        &["well-formed XML"],
    );
    urdf_mistake("</robot>", "", &["still open"]);
    let name = r#"name="l3""#;
    urdf_mistake(name, r#"name="l3"#, &["dir/arm.urdf:"]);
    urdf_mistake(name, r#"name="l3" name="l3""#, &["attribute of <link>"]);
    urdf_mistake(name, r#"name="&none;""#, &["attribute of <link>"]);
    urdf_mistake(r#"<link name="base"/>"#, r#"<xacro:include filename="x"/>"#, &["macro", "xacro"]);
    urdf_mistake(r#"<robot name="arm6">"#, r#"<sdf><robot name="arm6">"#, &["<sdf>"]);
    for text in [
        "",
        "schema = \"robot/1\"",
        "<robot",
        "<robot/>",
        "<a:robot xmlns:a='b'/>",
        "<robot><link/></robot>",
    ] {
        assert!(import_urdf_text(text, "x.urdf").is_err(), "{text}");
    }
    // Depth alone must not exhaust the stack.
    let deep = format!("<robot>{}", "<link name='a'>".repeat(100_000));
    assert!(import_urdf_text(&deep, "deep.urdf").is_err());
}

#[test]
fn what_surrounds_the_arm_in_a_urdf_does_not_matter() {
    let plain = import_urdf_text(URDF, "arm.urdf").unwrap();
    let dressed = URDF.replace("<robot name", "<robot xmlns:xacro=\"http://ros.org/wiki/xacro\" name").replace(
        r#"<link name="base"/>"#,
        r#"<link name="base"><visual><geometry><mesh filename="a.stl"/></geometry></visual></link>
            <transmission name="t"><joint name="A1"><hardwareInterface>x</hardwareInterface></joint></transmission>
            <gazebo reference="l1"><link name="l1"/></gazebo><!-- <joint> -->"#,
    );
    assert_eq!(import_urdf_text(&dressed, "arm.urdf").unwrap(), plain);
}

#[test]
fn joints_that_mimic_others_are_held_or_axes_and_the_file_says_which() {
    let plain = import_urdf_text(URDF, "arm.urdf").unwrap();
    // A finger turned by 0.5 rad and one that slides: fixed to the last link, at their offsets.
    let fingers = r#"<link name="f1"><inertial><origin xyz="0.1 0 0"/><mass value="2"/>
        <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="F1" type="revolute"><parent link="l6"/><child link="f1"/><axis xyz="0 0 1"/>
        <mimic joint="A6" multiplier="-1" offset="0.5"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
        <link name="f2"/><joint name="F2" type="prismatic"><parent link="f1"/><child link="f2"/>
        <axis xyz="1 0 0"/><mimic joint="F1" multiplier="2"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#;
    let text = import_urdf_text(&URDF.replace("</robot>", fingers), "arm.urdf").unwrap();
    assert!(
        text.contains("# Note: Joint F1 is held at 0.5 rad: it follows A6 by a factor of -1"),
        "{text}"
    );
    assert!(
        text.contains("# Note: Joint F2 is held at 0 m: it follows F1 by a factor of 2"),
        "{text}"
    );
    let last = |text: &str| RobotFile::parse(&filled(text), "a.toml").unwrap().parameters.joints[5];
    let (with, without) = (last(&text), last(&plain));
    assert!((with.mass - without.mass - 2.0).abs() < 1e-12);
    let finger = Vector3::new(0.1 * 0.5_f64.cos(), 0.1 * 0.5_f64.sin(), 0.0);
    let expected = (without.center_of_mass * without.mass + finger * 2.0) / with.mass;
    assert!((with.center_of_mass - expected).norm() < 1e-11);

    let axis = r#"<axis xyz="0 0 1"/>"#;
    let coupled = URDF.replacen(axis, &format!("{axis}<mimic joint=\"A2\"/>"), 1);
    let text = import_urdf_text(&coupled, "arm.urdf").unwrap();
    let said = "# Note: Joint A1 is an axis of its own here: that it follows A2 by a factor of 1 is left out.";
    assert!(text.contains(said), "{text}");
    let all = |text: &str| RobotFile::parse(&filled(text), "a.toml").unwrap().parameters;
    assert_eq!(all(&text), all(&plain));
}

#[test]
fn every_entry_still_to_be_filled_in_is_listed_with_its_place_and_meaning() {
    let bare = URDF.replace(
        r#"<mass value="120"/><inertia ixx="2" iyy="6" izz="6" ixy="0" ixz="0" iyz="0"/>"#,
        "",
    );
    let bare = bare.replace(r#"<inertial><origin xyz="0.15 0 0"/></inertial>"#, "");
    let text = import_urdf_text(&bare, "arm.urdf").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm.toml");
    fs::write(&path, &text).unwrap();
    let open: Vec<String> = open_entries(&path).unwrap().iter().map(ToString::to_string).collect();
    assert_eq!(open.len(), text.matches("= \"FILL IN").count(), "{open:#?}");
    // Gravity, three values of each drive, three of the link without inertia, friction, weight.
    assert_eq!(open.len(), 1 + 6 * 3 + 3 + 3 + 1);
    let line = text.lines().position(|l| l.starts_with("mass_kg = \"FILL IN")).unwrap() + 1;
    let mass = open.iter().find(|entry| entry.contains("mass_kg")).unwrap();
    for words in [&format!("arm.toml:{line}:11"), "[[joint]] 4 (A4)", "mass of a link", "in kg"] {
        assert!(mass.contains(words), "{words} in {mass}");
    }
    assert_eq!(open_entries(fixture("robots/kr500-mt.toml")).unwrap().len(), 0);
}

#[test]
fn what_a_urdf_leaves_unstated_must_be_filled_in() {
    let endless = URDF.replace(r#"name="A6" type="revolute""#, r#"name="A6" type="continuous""#);
    let text = import_urdf_text(&endless, "arm.urdf").unwrap();
    assert_eq!(text.matches("limits_deg = \"FILL IN").count(), 1);
    let unrated = URDF.replacen(r#"effort="1e6" velocity="10""#, r#"effort="0" velocity="0""#, 1);
    let text = import_urdf_text(&unrated, "arm.urdf").unwrap();
    assert!(
        text.contains("max_torque_nm = \"FILL IN") && text.contains("max_speed_deg_s = \"FILL IN")
    );
    let toolless = URDF.replace("\"tcp\"", "\"end\"");
    assert!(
        import_urdf_text(&toolless, "arm.urdf").unwrap().contains("tcp_from_flange_m = \"FILL IN")
    );
    let flange = import_urdf_text(&URDF.replace("\"tcp\"", "\"flange\""), "arm.urdf").unwrap();
    assert!(
        flange.contains("flange_offset_m = [0.4, 0.0, -0.15]")
            && flange.contains("z_axis = \"FILL IN")
    );
}

/// Many descriptions have `ee_link`, x out of the flange, beside `tool0`, z out of it.
#[test]
fn a_tool_frame_whose_z_is_square_to_the_last_axis_is_not_taken_silently() {
    let frame = |name: &str, rpy: &str| {
        format!(
            r#"<link name="{name}"/><joint name="to {name}" type="fixed"><parent link="l6"/><child link="{name}"/>
            <origin xyz="0.1 0 0" rpy="{rpy}"/></joint>"#
        )
    };
    let of = |frames: &str| {
        let text =
            URDF.replace("\"tcp\"", "\"end\"").replace("</robot>", &format!("{frames}</robot>"));
        import_urdf_text(&text, "arm.urdf").unwrap()
    };
    // The last axis is x of the base.
    let (square, along) =
        (frame("ee_link", "0 0 1.5707963267948966"), frame("tool0", "0 1.5707963267948966 0"));
    let both = of(&format!("{square}{along}"));
    assert!(both.contains("z_axis = [1.0, 0.0, 0.0]"), "{both}");
    assert!(both.contains("the URDF's tool0. Its ee_link is passed over"), "{both}");
    let alone = of(&square);
    assert!(
        alone.contains("z_axis = \"FILL IN: z of ee_link is square to the last axis"),
        "{alone}"
    );
}

#[test]
fn the_frame_of_the_tool_is_told_and_inertias_are_checked_against_their_masses() {
    let text = import_urdf_text(URDF, "arm.urdf").unwrap();
    assert!(text.contains("# Note: The tool is the URDF's tcp, its z axis "), "{text}");
    assert!(!text.contains("steel ball"), "{text}");

    let link = r#"<mass value="120"/><inertia ixx="2" iyy="6" izz="6" ixy="0" ixz="0" iyz="0"/>"#;
    let with = |inertia: [f64; 3]| {
        let [x, y, z] = inertia;
        let other = format!(
            r#"<mass value="120"/><inertia ixx="{x}" iyy="{y}" izz="{z}" ixy="0" ixz="0" iyz="0"/>"#
        );
        assert!(URDF.contains(link));
        import_urdf_text(&URDF.replace(link, &other), "arm.urdf").unwrap()
    };
    // A steel ball of 120 kg: radius 0.154 m, 1.14 kg m² about each axis.
    let noted = "less inertia than a steel ball of its mass has";
    assert!(with([1.0, 1.0, 1.0]).contains(noted));
    assert!(!with([1.2, 1.2, 1.2]).contains(noted));
    for of_no_body in [[0.0, 0.0, 0.0], [1.0, 2.0, 6.0]] {
        let text = with(of_no_body);
        assert!(text.contains("inertia_kg_m2 = \"FILL IN: in the URDF it is one that no body"));
    }
}
