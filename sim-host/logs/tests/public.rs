//! Files of the shapes that programs in public repositories write, each with its source. Numbers are
//! made here; what is promised is which columns are read, and as what.

use std::fs;
use std::path::PathBuf;
use trueweld_logs::log::import::{Stated, propose};
use trueweld_plant::input::{InputFile, RobotFile};

/// A file of a shape that somebody writes.
struct Shape {
    /// Repository and file, or page, that shows it.
    source: &'static str,
    /// What stands above the rows.
    head: &'static str,
    between: &'static str,
    /// A letter a column: see [`value`].
    columns: &'static str,
    /// Every column that is mapped: header, channel, unit.
    mapped: &'static str,
}

/// Of a column in a row: `s` `m` `n` time from 0 in s, ms, ns; `e` `E` of an epoch in s, ns; `w` time of
/// day over midnight; `c` count; `d` `r` angle in deg, rad; `f` force of some hundred; `a` of some ones;
/// `p` `q` position in mm, m; `h` 0.5; `x` text; `-` none.
fn value(letter: char, column: usize, k: usize) -> String {
    let (time, phase) = (0.008 * k as f64, 0.05 * k as f64 + column as f64);
    match letter {
        's' => format!("{time:.3}"),
        'm' => format!("{:.0}", 1e3 * time),
        'n' => format!("{}", 8_000_000 * k),
        'e' => format!("{:.3}", 1.7e9 + time),
        'E' => format!("{}", 1_700_000_000_000_000_000 + 8_000_000 * k as u64),
        'w' => {
            let of_day = (86_399.9 + time) % 86_400.0;
            let (hours, minutes) = ((of_day / 3600.0).floor(), (of_day / 60.0).floor() % 60.0);
            format!("{hours:02}:{minutes:02}:{:06.3}", of_day % 60.0)
        }
        'c' => k.to_string(),
        'd' => format!("{:.4}", 40.0 * phase.sin()),
        'r' => format!("{:.6}", 1.5 * phase.sin()),
        'f' => format!("{:.2}", 500.0 * phase.sin()),
        'a' => format!("{:.4}", 3.0 * phase.sin()),
        'p' => format!("{:.3}", 1500.0 + 50.0 * phase.sin()),
        'q' => format!("{:.6}", 1.5 + 0.05 * phase.sin()),
        'h' => "0.5".to_owned(),
        'x' => "tool0".to_owned(),
        _ => String::new(),
    }
}

/// What is mapped of a file with these lines above its rows.
fn mapped(shape: &Shape) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.csv");
    let mut text = shape.head.to_owned();
    for k in 0..60 {
        let values = shape.columns.chars().enumerate().map(|(c, letter)| value(letter, c, k));
        text += &(values.collect::<Vec<_>>().join(shape.between) + "\n");
    }
    fs::write(&path, text).expect("a file");
    let found = propose(&[path], None, Stated::default())
        .unwrap_or_else(|error| panic!("{}: {error}", shape.source));
    let columns = found.columns.iter().filter_map(|column| column.mapping.as_ref().ok());
    let shown = columns.map(|m| format!("{}={} {}", m.header, m.channel(), m.unit));
    shown.collect::<Vec<_>>().join("; ")
}

const SHAPES: &[Shape] = &[
    Shape {
        source: "MingyuTang0728/Universal-Robots-Notts, CSV_READER.py: target angles beside the actual ones",
        head: "pc_ts,runtime_state,q_0,q_1,q_2,q_3,q_4,q_5,qd_0,qd_1,qd_2,qd_3,qd_4,qd_5\n",
        between: ",",
        columns: "ecrrrrrraaaaaa",
        mapped: "pc_ts=t s; q_0=qe1 rad; q_1=qe2 rad; q_2=qe3 rad; q_3=qe4 rad; q_4=qe5 rad; q_5=qe6 rad",
    },
    Shape {
        source: "rpiRobotics/abb_motion_program_exec, robot/HOME/motion_program_logger.mod: blanks behind commas",
        head: "timestamp, cmd_num, J1, J2, J3, J4, J5, J6\n",
        between: ", ",
        columns: "scdddddd",
        mapped: "timestamp=t s; J1=qe1 deg; J2=qe2 deg; J3=qe3 deg; J4=qe4 deg; J5=qe5 deg; J6=qe6 deg",
    },
    Shape {
        source: "rpiRobotics/fanuc_motion_program_exec, fanuc_motion_program_exec_client.py: times in ms",
        head: "timestamp,line,J1,J2,J3,J4,J5,J6\n",
        between: ",",
        columns: "mcdddddd",
        mapped: "timestamp=t ms; J1=qe1 deg; J2=qe2 deg; J3=qe3 deg; J4=qe4 deg; J5=qe5 deg; J6=qe6 deg",
    },
    Shape {
        source: "a fork of fanucpy, reader of X Y Z W P R beside J1 to J6: the pose is the controller's",
        head: "time,power,X,Y,Z,W,P,R,J1,J2,J3,J4,J5,J6\n",
        between: ",",
        columns: "sfpppddddddddd",
        mapped: "time=t s; J1=qe1 deg; J2=qe2 deg; J3=qe3 deg; J4=qe4 deg; J5=qe5 deg; J6=qe6 deg",
    },
    Shape {
        source: "lbr-stack/pyfri, doc/examples.rst: seven axes, of which none is left out by guess",
        head: "index,time,record_time_nsec,tsec,tnsec,mp1,mp2,mp3,mp4,mp5,mp6,mp7\n",
        between: ",",
        columns: "csEsnrrrrrrr",
        mapped: "time=t s",
    },
    Shape {
        source: "utexas-bwi/segbot_arm, joint_states_capture_csv.sh: `rostopic echo -p`",
        head: "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.position0,field.position1,\
               field.position2,field.position3,field.position4,field.position5,field.effort0,field.effort1,\
               field.effort2,field.effort3,field.effort4,field.effort5\n",
        between: ",",
        columns: "EcExrrrrrraaaaaa",
        mapped: "field.header.stamp=t ns; field.position0=qe1 rad; field.position1=qe2 rad; field.position2=qe3 rad; \
                 field.position3=qe4 rad; field.position4=qe5 rad; field.position5=qe6 rad; field.effort0=tm1 Nm; \
                 field.effort1=tm2 Nm; field.effort2=tm3 Nm; field.effort3=tm4 Nm; field.effort4=tm5 Nm; field.effort5=tm6 Nm",
    },
    Shape {
        source: "rostopic echo -p of geometry_msgs/WrenchStamped, as ATI's drivers publish it",
        head: "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.wrench.force.x,\
               field.wrench.force.y,field.wrench.force.z,field.wrench.torque.x,field.wrench.torque.y,field.wrench.torque.z\n",
        between: ",",
        columns: "EcExfffaaa",
        mapped: "field.header.stamp=t ns; field.wrench.force.x=fx N; field.wrench.force.y=fy N; field.wrench.force.z=fz N; \
                 field.wrench.torque.x=mx Nm; field.wrench.torque.y=my Nm; field.wrench.torque.z=mz Nm",
    },
    Shape {
        source: "a recorder of ATI's sensors by rospy (force_torque_sensor_data.csv)",
        head: "Timestamp,Force_X,Force_Y,Force_Z,Torque_X,Torque_Y,Torque_Z\n",
        between: ",",
        columns: "efffaaa",
        mapped: "Timestamp=t s; Force_X=fx N; Force_Y=fy N; Force_Z=fz N; Torque_X=mx Nm; Torque_Y=my Nm; Torque_Z=mz Nm",
    },
    Shape {
        source: "ATI Net F/T, a recorder over UDP with units in the header",
        head: "Time (s),Fx (N),Fy (N),Fz (N),Tx (Nm),Ty (Nm),Tz (Nm)\n",
        between: ",",
        columns: "sfffaaa",
        mapped: "Time (s)=t s; Fx (N)=fx N; Fy (N)=fy N; Fz (N)=fz N; Tx (Nm)=mx Nm; Ty (Nm)=my Nm; Tz (Nm)=mz Nm",
    },
    Shape {
        source: "facontidavide/PlotJuggler, export as CSV: the joints by their names",
        head: "__time,/joint_states/joint_a1/position,/joint_states/joint_a2/position,/joint_states/joint_a3/position,\
               /joint_states/joint_a4/position,/joint_states/joint_a5/position,/joint_states/joint_a6/position\n",
        between: ",",
        columns: "errrrrr",
        mapped: "__time=t s; /joint_states/joint_a1/position=qe1 rad; /joint_states/joint_a2/position=qe2 rad; \
                 /joint_states/joint_a3/position=qe3 rad; /joint_states/joint_a4/position=qe4 rad; \
                 /joint_states/joint_a5/position=qe5 rad; /joint_states/joint_a6/position=qe6 rad",
    },
    Shape {
        source: "README of a trajectory_from_file node: `t[s]`, `q1` …",
        head: "t[s],q1,q2,q3,q4,q5,q6\n",
        between: ",",
        columns: "srrrrrr",
        mapped: "t[s]=t s; q1=qe1 rad; q2=qe2 rad; q3=qe3 rad; q4=qe4 rad; q5=qe5 rad; q6=qe6 rad",
    },
    Shape {
        source: "README of a legged robot's logger: q_*, dq_*, ddq_*, Tau_* of an arm",
        head: "time,q_1,q_2,q_3,q_4,q_5,q_6,dq_1,dq_2,dq_3,dq_4,dq_5,dq_6,Tau_1,Tau_2,Tau_3,Tau_4,Tau_5,Tau_6\n",
        between: ",",
        columns: "srrrrrraaaaaaffffff",
        mapped: "time=t s; q_1=qe1 rad; q_2=qe2 rad; q_3=qe3 rad; q_4=qe4 rad; q_5=qe5 rad; q_6=qe6 rad; Tau_1=tm1 Nm; \
                 Tau_2=tm2 Nm; Tau_3=tm3 Nm; Tau_4=tm4 Nm; Tau_5=tm5 Nm; Tau_6=tm6 Nm",
    },
    Shape {
        source: "ladisk/lvm_read and NI's specification of .lvm: a preamble with its own end",
        head: "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n\
               Date\t2015/05/14\nTime\t10:09:23.1\n***End_of_Header***\t\n\nChannels\t3\t\t\t\nSamples\t60\t60\t60\t\n\
               Y_Unit_Label\tN\tN\tN\t\nX0\t0\t0\t0\t\n***End_of_Header***\t\t\t\t\nX_Value\tFx\tFy\tFz\tComment\n",
        between: "\t",
        columns: "sfff-",
        mapped: "X_Value=t s; Fx=fx N; Fy=fy N; Fz=fz N",
    },
    Shape {
        source: "AG6GR/Vicon_CSV: Vicon Tracker, names and units in rows",
        head: "Objects\n100\nFrame,Sub Frame,RX,RY,RZ,TX,TY,TZ\n,,rad,rad,rad,mm,mm,mm\n",
        between: ",",
        columns: "ccrrrppp",
        mapped: "RX=rx rad; RY=ry rad; RZ=rz rad; TX=px mm; TY=py mm; TZ=pz mm",
    },
    Shape {
        source: "DynoWare of Kistler as text: units in a row, decimal commas, times over midnight",
        head: "File name:\tweld.dwd\nSampling rate [Hz]:\t125\nTime\tFx\tFy\tFz\tMz\nhh:mm:ss\tN\tN\tN\tN·m\n",
        between: "\t",
        columns: "wfffa",
        mapped: "Time=t s; Fx=fx N; Fy=fy N; Fz=fz N; Mz=mz Nm",
    },
    Shape {
        source: "RoboDK, macro for laser trackers: points alone, without a header",
        head: "",
        between: ", ",
        columns: "sppp",
        mapped: "1=t s",
    },
    Shape {
        source: "a recorder of rtde_receive by pandas: actual angles, and the pose that the controller computes",
        head: ",q0,q1,q2,q3,q4,q5,px,py,pz,rx,ry,rz\n",
        between: ",",
        columns: "crrrrrrqqqaaa",
        mapped: "q0=qe1 rad; q1=qe2 rad; q2=qe3 rad; q3=qe4 rad; q4=qe5 rad; q5=qe6 rad; px=px m; py=py m; pz=pz m; \
                 rx=rx rad; ry=ry rad; rz=rz rad",
    },
    Shape {
        source: "sclerp gazebo writeJointTrajectoryCsv, with Yaskawa's names of joints",
        head: "time,joint_1_s,joint_2_l,joint_3_u,joint_4_r,joint_5_b,joint_6_t\n",
        between: ",",
        columns: "srrrrrr",
        mapped: "time=t s; joint_1_s=qe1 rad; joint_2_l=qe2 rad; joint_3_u=qe3 rad; joint_4_r=qe4 rad; joint_5_b=qe5 rad; \
                 joint_6_t=qe6 rad",
    },
    Shape {
        source: "ros2 bag export of geometry_msgs/PoseStamped (ros2bag tools): seconds and nanoseconds apart",
        head: "timestamp,pose.position.x,pose.position.y,pose.position.z,pose.orientation.x,pose.orientation.y,\
               pose.orientation.z,pose.orientation.w\n",
        between: ",",
        columns: "Eqqqhhhh",
        mapped: "timestamp=t ns; pose.position.x=px m; pose.position.y=py m; pose.position.z=pz m; \
                 pose.orientation.x=qx 1; pose.orientation.y=qy 1; pose.orientation.z=qz 1; pose.orientation.w=qw 1",
    },
    Shape {
        source: "frankaemika/libfranka, log.h: seven axes of a cobot",
        head: "time,q[0],q[1],q[2],q[3],q[4],q[5],q[6],tau_J[0],tau_J[1],tau_J[2],tau_J[3],tau_J[4],tau_J[5],tau_J[6]\n",
        between: ",",
        columns: "srrrrrrraaaaaaa",
        mapped: "time=t s",
    },
];

#[test]
fn files_of_public_programs_are_read_as_they_mean() {
    for shape in SHAPES {
        assert_eq!(mapped(shape), shape.mapped, "{}", shape.source);
    }
}

/// The controller shows A3 less A2: ros-industrial/fanuc#290.
#[test]
fn an_axis_counted_from_the_horizontal_is_proposed_as_a_sum() {
    let fixtures = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let controller = fs::read_to_string(fixtures.join("raw/krc.csv")).expect("a fixture");
    let header: Vec<&str> = controller.lines().next().expect("a header").split(';').collect();
    let [second, third] = ["AXIS_ACT.A2 [deg]", "AXIS_ACT.A3 [deg]"]
        .map(|name| header.iter().position(|field| *field == name).expect("a column"));
    let shown = |line: &str| {
        let mut fields: Vec<String> = line.split(';').map(str::to_owned).collect();
        let value = |k: usize| fields[k].replace(',', ".").parse::<f64>();
        if let (Ok(a), Ok(b)) = (value(second), value(third)) {
            fields[third] = format!("{:.4}", b - a).replace('.', ",");
        }
        fields.join(";") + "\n"
    };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("krc.csv");
    fs::write(&path, controller.lines().map(shown).collect::<String>()).expect("a file");
    let robot = RobotFile::read(fixtures.join("campaigns/backlash/robot.toml")).expect("a robot");
    let files = [path, fixtures.join("raw/tracker.txt")];
    let found = propose(&files, Some(&robot), Stated::default()).expect("a proposal");
    let axis = found.columns.iter().find(|c| c.header == "AXIS_ACT.A3 [deg]").expect("A3");
    let mapping = axis.mapping.as_ref().expect("it is mapped");
    assert!(mapping.line().contains("plus = { qe2 = 1.0 }"), "{}", mapping.line());
}
