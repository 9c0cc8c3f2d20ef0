//! A URDF → the text of a robot file.
//!
//! Carried over: the six joints' origins, axes, limits and ratings, and the masses, centres and
//! inertias of the links, merged across fixed joints. In a robot file all link frames are parallel
//! to the base at zero, so everything is turned into the axes of the URDF's root link at zero. A
//! URDF knows nothing of elasticity, drives, friction, counterbalance and mounting: those stand as
//! [`FILL_IN`] markers, which the robot reader refuses, as does what a link without `<inertial>`
//! leaves open. A joint that mimics another and carries no axis of its own (a finger of a gripper)
//! is held where it stands when that other is at zero; one that carries an axis is an axis, and its
//! coupling is left out. The file says so of each. Left out: shapes.

use super::{FILL_IN, InputError, Source, nearest, read_text};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use quick_xml::Reader;
use quick_xml::escape::escape;
use quick_xml::events::{BytesStart, Event};
use std::collections::HashMap;
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;
use trueweld_core::JOINTS;
use urdf_rs::JointType;

/// Children of `<link>`, `<inertial>` and `<joint>` that a robot file has use for.
const KEPT: &[(&str, &[&str])] = &[
    ("link", &["inertial"]),
    ("inertial", &["origin", "mass", "inertia"]),
    ("joint", &["origin", "parent", "child", "axis", "limit", "mimic"]),
];

/// Attributes that hold numbers: element, attribute, how many.
const NUMBERS: &[(&str, &str, usize)] = &[
    ("origin", "xyz", 3),
    ("origin", "rpy", 3),
    ("axis", "xyz", 3),
    ("mass", "value", 1),
    ("inertia", "ixx", 1),
    ("inertia", "ixy", 1),
    ("inertia", "ixz", 1),
    ("inertia", "iyy", 1),
    ("inertia", "iyz", 1),
    ("inertia", "izz", 1),
];

/// Words in the name of a fixed frame behind the last joint that make it the tool centre point, the
/// likeliest first.
const TCP_WORDS: &[&str] = &["tcp", "tool", "ee", "eef", "effector", "tool0", "flange"];

/// Words in the name of a fixed frame behind the last joint that make it the flange.
const FLANGE_WORDS: &[&str] = &["flange", "tool0"];

/// Beyond this a coordinate, mass or inertia is a mistake, and products would overflow.
const LARGEST: f64 = 1e9;

/// Turns a URDF of a six-axis arm into the text of a `robot/1` file.
///
/// # Errors
/// Broken XML, missing or bad numbers, and whatever is no serial chain of six revolute joints with
/// inertias.
pub fn import_urdf(path: impl AsRef<Path>) -> Result<String, InputError> {
    let (name, text) = read_text(path.as_ref())?;
    import_urdf_text(&text, &name)
}

/// As [`import_urdf`], from text; `name` is what errors call it.
///
/// # Errors
/// As [`import_urdf`].
pub fn import_urdf_text(text: &str, name: &str) -> Result<String, InputError> {
    let source = Source::new(name, text);
    let urdf = Urdf::read(&source)?;
    let arm = Arm::from_urdf(&urdf, &source)?;
    Ok(arm.write(&urdf.name, name))
}

/// A URDF's links and joints with their places.
struct Urdf {
    name: String,
    links: Vec<Placed<urdf_rs::Link>>,
    joints: Vec<Placed<urdf_rs::Joint>>,
}

/// An element and its start tag's place.
struct Placed<E> {
    element: E,
    span: Range<usize>,
    /// A link's `<inertial>` or a joint's `<limit>` is there; urdf-rs puts zeros where it is not.
    stated: bool,
}

/// The part of a `<link>` or `<joint>` that is kept, as XML again.
struct Kept {
    xml: String,
    is_link: bool,
    span: Range<usize>,
    stated: bool,
}

impl Urdf {
    /// Reads the XML twice: once for well-formedness, places and numbers, then each link and joint
    /// by urdf-rs, which knows the format's versions and defaults but no places.
    fn read(source: &Source) -> Result<Self, InputError> {
        let (name, version, kept) = scan(source)?;
        let mut urdf = Self { name, links: Vec::new(), joints: Vec::new() };
        for k in kept {
            let xml =
                format!("<robot name=\"r\" version=\"{}\">{}</robot>", escape(&version), k.xml);
            let robot = urdf_rs::read_from_string(&xml).map_err(|error| {
                let what = if k.is_link { "link" } else { "joint" };
                let message = format!(
                    "this <{what}> is not what URDF asks for: {error}; expected a complete <{what}>"
                );
                source.error(
                    k.span.clone(),
                    message,
                    "in this element",
                    "Compare it with the URDF reference.",
                )
            })?;
            let place = |stated| (k.span.clone(), stated);
            for element in robot.links {
                let (span, stated) = place(k.stated);
                urdf.links.push(Placed { element, span, stated });
            }
            for element in robot.joints {
                let (span, stated) = place(k.stated);
                urdf.joints.push(Placed { element, span, stated });
            }
        }
        Ok(urdf)
    }
}

/// Checks the XML and keeps what a robot file needs: the robot's name, the URDF version, links and
/// joints.
fn scan(source: &Source) -> Result<(String, String, Vec<Kept>), InputError> {
    let text = source.text();
    let mut reader = Reader::from_str(text);
    let mut robot: Option<(String, String)> = None;
    let mut kept: Vec<Kept> = Vec::new();
    // Names of the open elements; None once inside something that is not kept.
    let mut open: Vec<Option<&'static str>> = Vec::new();
    loop {
        let start = reader.buffer_position() as usize;
        let event = reader.read_event().map_err(|error| {
            let at = reader.error_position() as usize;
            let message = format!(
                "this is not well-formed XML: {error}; read `{}`",
                source.excerpt(at..text.len())
            );
            let help = "Close every tag and quote; an XML checker such as xmllint shows the rest.";
            source.error(at..text.len(), message, "expected well-formed XML", help)
        })?;
        let span = start..reader.buffer_position() as usize;
        let (tag, closed) = match event {
            Event::Start(tag) => (tag, false),
            Event::Empty(tag) => (tag, true),
            Event::End(_) => {
                if let Some(Some(name)) = open.pop()
                    && let Some(element) = kept.last_mut().filter(|_| name != "robot")
                {
                    element.xml.push_str(&format!("</{name}>"));
                }
                continue;
            }
            Event::Eof => break,
            _ => continue,
        };
        let name = String::from_utf8_lossy(tag.name().as_ref()).into_owned();
        if name.starts_with("xacro:") {
            let message =
                format!("<{name}> is a macro; expected a URDF in which macros are expanded");
            return Err(source.error(
                span,
                message,
                "a macro",
                "Run `xacro arm.xacro > arm.urdf` and import its output.",
            ));
        }
        let name = match (open.last(), open.len()) {
            (None, _) if name == "robot" && robot.is_none() => {
                let attributes = attributes(source, &tag, &name, &span)?;
                let get =
                    |key: &str| attributes.iter().find(|(k, _)| k == key).map(|(_, v)| v.clone());
                robot = Some((
                    get("name").unwrap_or_default(),
                    get("version").unwrap_or("1.0".to_owned()),
                ));
                Some("robot")
            }
            (None, _) => {
                let message = format!("the file's element is <{name}>; expected one <robot>");
                return Err(source.error(
                    span,
                    message,
                    "expected <robot>",
                    "Give the URDF of the arm.",
                ));
            }
            (Some(Some("robot")), _) => ["link", "joint"].into_iter().find(|n| *n == name),
            (Some(Some(parent)), _) => {
                let children = KEPT.iter().find(|(p, _)| p == parent).map_or(&[][..], |(_, c)| c);
                children.iter().copied().find(|n| *n == name)
            }
            (Some(None), _) => None,
        };
        if let Some(name) = name.filter(|n| *n != "robot") {
            let attributes = attributes(source, &tag, name, &span)?;
            if open.len() == 1 {
                kept.push(Kept {
                    xml: String::new(),
                    is_link: name == "link",
                    span,
                    stated: false,
                });
            }
            if let Some(element) = kept.last_mut() {
                element.stated |= matches!(name, "inertial" | "limit");
                element.xml.push('<');
                element.xml.push_str(name);
                for (key, value) in attributes {
                    element.xml.push_str(&format!(" {key}=\"{}\"", escape(&value)));
                }
                element.xml.push_str(if closed { "/>" } else { ">" });
            }
        }
        if !closed {
            open.push(name);
        }
    }
    if !open.is_empty() {
        let end = text.trim_end().len();
        let message =
            format!("the file ends with {} elements still open; expected </robot>", open.len());
        return Err(source.error(
            end..end,
            message,
            "ends here",
            "The file was cut off: get the whole of it.",
        ));
    }
    let Some((name, version)) = robot else {
        return Err(source.error_of_file(
            "there is no element; expected one <robot>",
            "Give the URDF of the arm.",
        ));
    };
    Ok((name, version, kept))
}

/// The attributes of a tag without namespaces, numbers checked.
fn attributes(
    source: &Source,
    tag: &BytesStart<'_>,
    element: &str,
    span: &Range<usize>,
) -> Result<Vec<(String, String)>, InputError> {
    let broken = |error: &dyn std::fmt::Display| {
        let message =
            format!("an attribute of <{element}> cannot be read: {error}; expected name=\"value\"");
        source.error(
            span.clone(),
            message,
            "in this tag",
            "Quote every value and name an attribute once.",
        )
    };
    let mut list = Vec::new();
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|error| broken(&error))?;
        let key = String::from_utf8_lossy(attribute.key.as_ref()).into_owned();
        if key.contains(':') || key.starts_with("xmlns") {
            continue;
        }
        let raw = String::from_utf8_lossy(&attribute.value).into_owned();
        let value = quick_xml::escape::unescape(&raw).map_err(|error| broken(&error))?.into_owned();
        let count = NUMBERS.iter().find(|(e, k, _)| *e == element && *k == key).map(|(_, _, n)| *n);
        if let Some(count) = count.filter(|n| !are_numbers(&value, *n)) {
            let offset =
                source.text().get(span.clone()).and_then(|tag| tag.find(&raw)).unwrap_or(0);
            let at = span.start + offset..span.start + offset + raw.len();
            let expected = if count == 1 {
                "one finite number".to_owned()
            } else {
                format!("{count} finite numbers")
            };
            let message = format!(
                "`{key}` of <{element}> is \"{}\"; expected {expected}",
                source.excerpt(at.clone())
            );
            return Err(source.error(
                at,
                message,
                format!("expected {expected}"),
                "Separate numbers by spaces.",
            ));
        }
        list.push((key, value));
    }
    Ok(list)
}

fn are_numbers(value: &str, count: usize) -> bool {
    let numbers: Vec<_> = value.split_whitespace().map(str::parse::<f64>).collect();
    numbers.len() == count
        && numbers.iter().all(|n| n.as_ref().is_ok_and(|x| x.is_finite() && x.abs() <= LARGEST))
}

/// A rigid body, the URDF at zero, in axes of B.
struct Body {
    mass: f64,
    center_of_mass: Vector3<f64>,
    /// About the centre of mass.
    inertia: Matrix3<f64>,
}

impl Body {
    /// Several bodies fixed to one another, by the parallel-axis theorem. Without mass, centred at
    /// `origin`.
    fn merged(bodies: &[Self], origin: Vector3<f64>) -> Self {
        let mass: f64 = bodies.iter().map(|b| b.mass).sum();
        let moment: Vector3<f64> = bodies.iter().map(|b| b.center_of_mass * b.mass).sum();
        let center_of_mass = if mass > 0.0 { moment / mass } else { origin };
        let about = |b: &Self| {
            let d = b.center_of_mass - center_of_mass;
            b.inertia + (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * b.mass
        };
        Self { mass, center_of_mass, inertia: bodies.iter().map(about).sum() }
    }
}

/// A link of the URDF that is fixed to a moving one.
struct Frame {
    name: String,
    b_from_frame: Isometry3<f64>,
    /// Nothing hangs on it and it has no inertia.
    is_bare_leaf: bool,
}

/// A joint and the link behind it, the URDF at zero, in axes of B.
struct Stage {
    name: String,
    origin: Vector3<f64>,
    axis: Vector3<f64>,
    /// None where the URDF states none.
    limits: Option<[f64; 2]>,
    max_rate: Option<f64>,
    max_torque: Option<f64>,
    /// None where no link behind the joint has an `<inertial>`.
    body: Option<Body>,
    frames: Vec<Frame>,
}

/// The serial arm.
struct Arm {
    stages: Vec<Stage>,
    /// What became of joints that mimic others, a sentence each.
    mimics: Vec<String>,
}

impl Arm {
    fn from_urdf(urdf: &Urdf, source: &Source) -> Result<Self, InputError> {
        let tree = Tree::new(urdf, source)?;
        let (mut stages, mut mimics) = (Vec::new(), Vec::new());
        let mut seen = 0;
        let mut next = tree.explore(tree.root, Isometry3::identity())?;
        seen += next.links.len();
        mimics.append(&mut next.mimics);
        while let Some((joint, b_from_parent)) = next.joint {
            let b_from_joint = b_from_parent * pose(&joint.element.origin);
            let child = tree.link(&joint.element.child.link, joint)?;
            next = tree.explore(child, b_from_joint)?;
            seen += next.links.len();
            mimics.append(&mut next.mimics);
            stages.push(tree.stage(joint, b_from_joint, &next)?);
            if stages.len() > JOINTS {
                let names: Vec<_> = stages.iter().map(|s| s.name.as_str()).collect();
                let message = format!(
                    "joint `{}` is revolute number {}: {}; expected six",
                    joint.element.name,
                    stages.len(),
                    names.join(", ")
                );
                let help = "Make joints that are no axes of the arm fixed: linear tracks, turntables, grippers.";
                return Err(source.error(joint.span.clone(), message, "one too many", help));
            }
        }
        // Links that cannot be reached from the root hang on each other in a ring.
        if seen < urdf.links.len() {
            let message = format!(
                "{} of {} links are not connected to `{}`; expected one tree",
                urdf.links.len() - seen,
                urdf.links.len(),
                urdf.links[tree.root].element.name
            );
            return Err(source
                .error_of_file(message, "A joint's child must not be one of its own ancestors."));
        }
        if stages.len() != JOINTS {
            let names: Vec<_> = stages.iter().map(|s| s.name.as_str()).collect();
            let message = format!(
                "there are {} revolute joints in the chain ({}); expected six",
                names.len(),
                names.join(", ")
            );
            return Err(source.error_of_file(
                message,
                "Only serial arms with six revolute joints can be imported.",
            ));
        }
        Ok(Self { stages, mimics })
    }
}

fn pose(origin: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = origin.rpy.0;
    Isometry3::from_parts(
        Translation3::from(Vector3::from(origin.xyz.0)),
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_euler_angles(roll, pitch, yaw)),
    )
}

/// Who hangs on whom.
struct Tree<'u> {
    urdf: &'u Urdf,
    source: &'u Source,
    links: HashMap<&'u str, usize>,
    /// Joints by the link they hang on.
    joints_of: Vec<Vec<usize>>,
    root: usize,
}

/// Links fixed to one another, with their poses, and the one moving joint behind them.
struct Group<'u> {
    links: Vec<(usize, Isometry3<f64>)>,
    joint: Option<(&'u Placed<urdf_rs::Joint>, Isometry3<f64>)>,
    mimics: Vec<String>,
}

impl<'u> Tree<'u> {
    fn new(urdf: &'u Urdf, source: &'u Source) -> Result<Self, InputError> {
        let mut links = HashMap::new();
        for (i, link) in urdf.links.iter().enumerate() {
            if links.insert(link.element.name.as_str(), i).is_some() {
                let message = format!(
                    "there is another link `{}`; expected each name once",
                    link.element.name
                );
                return Err(source.error(
                    link.span.clone(),
                    message,
                    "second of this name",
                    "Rename one of them.",
                ));
            }
        }
        let mut tree =
            Self { urdf, source, links, joints_of: vec![Vec::new(); urdf.links.len()], root: 0 };
        let mut joint_of: Vec<Option<&str>> = vec![None; urdf.links.len()];
        for (j, joint) in urdf.joints.iter().enumerate() {
            let parent = tree.link(&joint.element.parent.link, joint)?;
            let child = tree.link(&joint.element.child.link, joint)?;
            if let Some(other) = joint_of[child].replace(&joint.element.name) {
                let message = format!(
                    "link `{}` hangs on joint `{other}` and on `{}`; expected one joint",
                    joint.element.child.link, joint.element.name
                );
                let help =
                    "Closed chains (parallel linkages) cannot be imported; keep the driven branch.";
                return Err(source.error(
                    joint.span.clone(),
                    message,
                    "second joint of this link",
                    help,
                ));
            }
            tree.joints_of[parent].push(j);
        }
        let mut roots = (0..urdf.links.len()).filter(|i| joint_of[*i].is_none());
        let Some(root) = roots.next() else {
            let message = "there is no link without a joint above it; expected a base";
            return Err(
                source.error_of_file(message, "Give the URDF of the whole arm, from its base on.")
            );
        };
        if let Some(second) = roots.next() {
            let name = |i: usize| &urdf.links[i].element.name;
            let message = format!(
                "links `{}` and `{}` both hang on nothing; expected one base",
                name(root),
                name(second)
            );
            let help = "Connect them by a fixed joint, or remove the one that is not of the arm.";
            return Err(source.error(
                urdf.links[second].span.clone(),
                message,
                "hangs on nothing",
                help,
            ));
        }
        tree.root = root;
        Ok(tree)
    }

    fn link(&self, name: &str, joint: &Placed<urdf_rs::Joint>) -> Result<usize, InputError> {
        self.links.get(name).copied().ok_or_else(|| {
            let message = format!(
                "joint `{}` names a link `{name}`; expected one of the file's",
                joint.element.name
            );
            let help = match nearest(name, self.links.keys().copied()) {
                Some(near) => format!("Did you mean `{near}`?"),
                None => "Add the link, or correct the name.".to_owned(),
            };
            self.source.error(joint.span.clone(), message, "no such link", help)
        })
    }

    /// Everything fixed to a link, and the one revolute joint behind it.
    fn explore(&self, link: usize, b_from_link: Isometry3<f64>) -> Result<Group<'u>, InputError> {
        let mut group = Group { links: vec![(link, b_from_link)], joint: None, mimics: Vec::new() };
        let mut at = 0;
        while let Some((link, b_from_link)) = group.links.get(at).copied() {
            for joint in self.joints_of[link].iter().map(|j| &self.urdf.joints[*j]) {
                let e = &joint.element;
                match e.joint_type {
                    JointType::Fixed => {
                        group.links.push((
                            self.link(&e.child.link, joint)?,
                            b_from_link * pose(&e.origin),
                        ));
                    }
                    _ if e.mimic.is_some() && !self.carries_axis(joint) => {
                        let (b_from_child, said) = self.held(joint, b_from_link)?;
                        group.links.push((self.link(&e.child.link, joint)?, b_from_child));
                        group.mimics.push(said);
                    }
                    JointType::Revolute | JointType::Continuous => {
                        if let Some(mimic) = &e.mimic {
                            group.mimics.push(format!(
                                "Joint {} is an axis of its own here: that it follows {} by a factor of {} is left out.",
                                e.name, mimic.joint, mimic.multiplier.unwrap_or(1.0)
                            ));
                        }
                        if let Some((other, _)) = group.joint.replace((joint, b_from_link)) {
                            let message = format!(
                                "joints `{}` and `{}` branch off the same link; expected one chain",
                                other.element.name, e.name
                            );
                            let help = "Only serial arms can be imported; make the joints of grippers fixed.";
                            return Err(self.source.error(
                                joint.span.clone(),
                                message,
                                "a second branch",
                                help,
                            ));
                        }
                    }
                    _ => {
                        let kind = format!("{:?}", e.joint_type).to_lowercase();
                        let message =
                            format!("joint `{}` is {kind}; expected revolute or fixed", e.name);
                        let help = "Only arms with revolute joints can be imported; make this joint fixed if it is no axis.";
                        return Err(self.source.error(
                            joint.span.clone(),
                            message,
                            format!("a {kind} joint"),
                            help,
                        ));
                    }
                }
            }
            at += 1;
        }
        Ok(group)
    }

    /// True where a joint that moves on its own hangs on this one.
    fn carries_axis(&self, joint: &Placed<urdf_rs::Joint>) -> bool {
        let mut behind = vec![joint];
        while let Some(joint) = behind.pop() {
            let link = self.links.get(joint.element.child.link.as_str());
            for j in link.into_iter().flat_map(|link| &self.joints_of[*link]) {
                let next = &self.urdf.joints[*j];
                let moves = !matches!(next.element.joint_type, JointType::Fixed);
                if moves && next.element.mimic.is_none() {
                    return true;
                }
                behind.push(next);
            }
        }
        false
    }

    /// The child's pose of a joint that mimics another, held where it stands when that other is at
    /// zero, and what to say of it.
    fn held(
        &self,
        joint: &Placed<urdf_rs::Joint>,
        b_from_link: Isometry3<f64>,
    ) -> Result<(Isometry3<f64>, String), InputError> {
        let e = &joint.element;
        let Some(mimic) = &e.mimic else {
            return Ok((b_from_link * pose(&e.origin), String::new()));
        };
        let offset = mimic.offset.unwrap_or(0.0);
        let axis = Vector3::from(e.axis.xyz.0).try_normalize(1e-9).unwrap_or_default() * offset;
        let (motion, unit) = match e.joint_type {
            JointType::Prismatic => (Isometry3::translation(axis.x, axis.y, axis.z), "m"),
            _ => (Isometry3::rotation(axis), "rad"),
        };
        let factor = mimic.multiplier.unwrap_or(1.0);
        let said = format!(
            "Joint {} is held at {offset} {unit}: it follows {} by a factor of {factor} and carries no axis.",
            e.name, mimic.joint
        );
        Ok((b_from_link * pose(&e.origin) * motion, said))
    }

    fn stage(
        &self,
        joint: &Placed<urdf_rs::Joint>,
        b_from_joint: Isometry3<f64>,
        group: &Group<'_>,
    ) -> Result<Stage, InputError> {
        let e = &joint.element;
        let Some(axis) = Vector3::from(e.axis.xyz.0).try_normalize(1e-9) else {
            let message = format!("the axis of joint `{}` is 0 0 0; expected a direction", e.name);
            return Err(self.source.error(
                joint.span.clone(),
                message,
                "no axis",
                "Write its axis, for example 0 0 1.",
            ));
        };
        let mut bodies = Vec::new();
        let mut frames = Vec::new();
        for (i, b_from_link) in &group.links {
            let link = &self.urdf.links[*i];
            frames.push(Frame {
                name: link.element.name.clone(),
                b_from_frame: *b_from_link,
                is_bare_leaf: !link.stated && self.joints_of[*i].is_empty(),
            });
            if link.stated {
                bodies.push(self.body(link, b_from_link)?);
            }
        }
        let limits = (joint.stated && e.joint_type == JointType::Revolute)
            .then_some([e.limit.lower, e.limit.upper])
            .filter(|[low, high]| low.is_finite() && high.is_finite() && low != high);
        let rating = |x: f64| Some(x).filter(|x| joint.stated && x.is_finite() && *x > 0.0);
        let origin = b_from_joint.translation.vector;
        Ok(Stage {
            name: e.name.clone(),
            origin,
            axis: b_from_joint.rotation * axis,
            limits,
            max_rate: rating(e.limit.velocity),
            max_torque: rating(e.limit.effort),
            body: (!bodies.is_empty()).then(|| Body::merged(&bodies, origin)),
            frames,
        })
    }

    fn body(
        &self,
        link: &Placed<urdf_rs::Link>,
        b_from_link: &Isometry3<f64>,
    ) -> Result<Body, InputError> {
        let inertial = &link.element.inertial;
        let mass = inertial.mass.value;
        if mass < 0.0 {
            let message = format!(
                "the mass of link `{}` is {mass} kg; expected a mass not below 0",
                link.element.name
            );
            return Err(self.source.error(
                link.span.clone(),
                message,
                "negative mass",
                "Check its sign.",
            ));
        }
        let b_from_com = b_from_link * pose(&inertial.origin);
        let i = &inertial.inertia;
        let own = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
        let turn = b_from_com.rotation.to_rotation_matrix();
        let inertia = turn * own * turn.inverse();
        Ok(Body { mass, center_of_mass: b_from_com.translation.vector, inertia })
    }
}

impl Arm {
    /// The text of the robot file.
    fn write(&self, name: &str, file: &str) -> String {
        let mut out = String::new();
        let mimics: String =
            self.mimics.iter().map(|said| format!("# {}\n", said.escape_debug())).collect();
        let name = if name.trim().is_empty() {
            marker("the URDF has no name for the robot")
        } else {
            text(name)
        };
        // Writing to a String cannot fail, so the results are dropped.
        let _ = writeln!(
            out,
            "# Imported from {}: geometry, masses, inertias, limits and ratings are the URDF's, in its root link's axes.\n\
             # Base B: the root link's frame. At zero every link frame is parallel to B. Units are in the names.\n\
             # What a URDF cannot say is marked {FILL_IN} and must be written before the file can be used.\n\
             {mimics}schema = \"robot/1\"\n\
             name = {name}\n\
             # With the root link upright on the floor: [0.0, 0.0, -9.80665].\n\
             gravity_m_s2 = {}",
            file.escape_debug(),
            marker("the mounting is not in a URDF"),
        );
        let mut before = Vector3::zeros();
        for stage in &self.stages {
            stage.write(&mut out, &before);
            before = stage.origin;
        }
        let unknown = marker("not in a URDF");
        let _ = writeln!(
            out,
            "\n[friction]\nviscous_nms_rad = {unknown}\ncoulomb_nm = {unknown}\nsmoothing_rad_s = {unknown}\n\
             \n# An arm without a counterbalance on A2: cos_nm = []; measured: angle_deg and torque_nm.\n[counterbalance]\ncos_nm = {unknown}",
        );
        if let Some(last) = self.stages.last() {
            last.write_tool(&mut out);
        }
        out
    }
}

impl Stage {
    fn write(&self, out: &mut String, before: &Vector3<f64>) {
        let unknown = marker("not in a URDF");
        let or_marker = |x: Option<f64>| x.map_or_else(|| marker("not stated in the URDF"), number);
        let or_no_inertial = |write: &dyn Fn(&Body) -> String| {
            self.body.as_ref().map_or_else(|| marker("no <inertial> in the URDF"), write)
        };
        let limits = match self.limits {
            Some([low, high]) => {
                format!("[{}, {}]", number(low.to_degrees()), number(high.to_degrees()))
            }
            None => marker("not stated in the URDF"),
        };
        let _ = writeln!(
            out,
            "\n[[joint]]\nname = {}\norigin_m = {}\naxis = {}\nlimits_deg = {limits}\nmax_speed_deg_s = {}\n\
             max_torque_nm = {}\nstiffness_nm_rad = {unknown}\ndamping_nms_rad = {unknown}\n\
             rotor_inertia_kg_m2 = {unknown}\nmass_kg = {}\ncom_m = {}\ninertia_kg_m2 = {}",
            if self.name.trim().is_empty() {
                marker("the URDF has no name for the joint")
            } else {
                text(&self.name)
            },
            vector(&(self.origin - before)),
            vector(&self.axis),
            or_marker(self.max_rate.map(f64::to_degrees)),
            or_marker(self.max_torque),
            or_no_inertial(&|body| number(body.mass)),
            or_no_inertial(&|body| vector(&(body.center_of_mass - self.origin))),
            or_no_inertial(&|body| inertia(&body.inertia)),
        );
    }

    /// The first frame behind this joint with one of these words in its name, by the order of the
    /// words.
    fn frame(
        &self,
        words: &[&'static str],
        fits: impl Fn(&Frame) -> bool,
    ) -> Option<(&'static str, &Frame)> {
        // The link that carries the joint itself is no frame on it.
        let frames = self.frames.get(1..).unwrap_or_default();
        let has = |frame: &&Frame, word: &str| {
            fits(frame)
                && frame
                    .name
                    .to_lowercase()
                    .split(|c: char| !c.is_alphanumeric())
                    .any(|part| part == word)
        };
        words.iter().find_map(|word| frames.iter().find(|f| has(f, word)).map(|f| (*word, f)))
    }

    fn write_tool(&self, out: &mut String) {
        let tcp = self.frame(TCP_WORDS, |f| f.is_bare_leaf);
        let flange = self
            .frame(FLANGE_WORDS, |_| true)
            .map(|(_, f)| f.b_from_frame.translation.vector - self.origin);
        let missing = || marker("no fixed leaf frame named tcp, tool0, ee or flange in the URDF");
        let (tcp_from_flange, z_axis, y_axis) = match tcp {
            None => (missing(), missing(), missing()),
            Some((word, frame)) => {
                let at = frame.b_from_frame.translation.vector
                    - self.origin
                    - flange.unwrap_or_default();
                let axis = |a: Vector3<f64>| vector(&(frame.b_from_frame.rotation * a));
                // Makers differ in whether x or z of a frame called flange points out of it.
                let unclear =
                    || marker("a frame named flange does not say which of its axes points out");
                let is_flange = word == "flange";
                let z = if is_flange { unclear() } else { axis(Vector3::z()) };
                (vector(&at), z, if is_flange { unclear() } else { axis(Vector3::y()) })
            }
        };
        let origin = match (flange, tcp) {
            (Some(_), _) => "the URDF's flange",
            (None, Some(_)) => {
                "the URDF names no flange, so that the last joint's origin stands in"
            }
            (None, None) => "to be filled in with the tool centre point",
        };
        let offset = match (flange, tcp) {
            (None, None) => missing(),
            _ => vector(&flange.unwrap_or_default()),
        };
        let zero = Vector3::zeros();
        let _ = writeln!(
            out,
            "\n# Flange: {origin}.\n# The URDF's bodies behind the last joint are all in its link above, hence a tool\n\
             # without mass: add what the URDF leaves out.\n\
             [tool]\nflange_offset_m = {offset}\nmass_kg = 0.0\ncom_from_flange_m = {}\ninertia_kg_m2 = {}\n\
             tcp_from_flange_m = {tcp_from_flange}\nz_axis = {z_axis}\ny_axis = {y_axis}",
            vector(&zero),
            inertia(&Matrix3::zeros()),
        );
    }
}

/// A value that the robot reader refuses, with its reason.
fn marker(why: &str) -> String {
    text(&format!("{FILL_IN}: {why}"))
}

fn text(value: &str) -> String {
    toml::Value::String(value.to_owned()).to_string()
}

/// A number without the noise that turning by π/2 leaves in the last digits.
fn number(x: f64) -> String {
    let rounded = if x.abs() < 1e3 { (x * 1e12).round() / 1e12 } else { x };
    // Adding zero turns −0 into 0.
    format!("{:?}", rounded + 0.0)
}

fn vector(v: &Vector3<f64>) -> String {
    format!("[{}, {}, {}]", number(v.x), number(v.y), number(v.z))
}

fn inertia(m: &Matrix3<f64>) -> String {
    let [xx, yy, zz] = [m.m11, m.m22, m.m33].map(number);
    let [xy, xz, yz] = [m.m12, m.m13, m.m23].map(number);
    format!("{{ xx = {xx}, yy = {yy}, zz = {zz}, xy = {xy}, xz = {xz}, yz = {yz} }}")
}
