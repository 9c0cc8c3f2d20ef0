//! The serial arm in a URDF: the chain of six axes, and what is fixed to one another merged.

use super::scan::{LocatedElement, Urdf};
use crate::input::{InputError, Source, nearest};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use std::collections::HashMap;
use trueweld_core::JOINTS;
use urdf_rs::JointType;

/// A rigid body, the URDF at zero, in axes of B.
pub(super) struct UrdfBody {
    pub(super) mass: f64,
    pub(super) center_of_mass: Vector3<f64>,
    /// About the centre of mass.
    pub(super) inertia: Matrix3<f64>,
}

impl UrdfBody {
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
pub(super) struct FixedLink {
    pub(super) name: String,
    pub(super) b_from_frame: Isometry3<f64>,
    /// Nothing hangs on it and it has no inertia.
    pub(super) is_bare_leaf: bool,
}

/// A joint and the link behind it, the URDF at zero, in axes of B.
pub(super) struct UrdfJoint {
    pub(super) name: String,
    pub(super) origin: Vector3<f64>,
    pub(super) axis: Vector3<f64>,
    /// None where the URDF states none.
    pub(super) limits: Option<[f64; 2]>,
    pub(super) max_rate: Option<f64>,
    pub(super) max_torque: Option<f64>,
    /// None where no link behind the joint has an `<inertial>`.
    pub(super) body: Option<UrdfBody>,
    pub(super) frames: Vec<FixedLink>,
}

/// The serial arm.
pub(super) struct Arm {
    pub(super) stages: Vec<UrdfJoint>,
    /// What became of joints that mimic others, a sentence each.
    pub(super) mimics: Vec<String>,
}

impl Arm {
    pub(super) fn from_urdf(urdf: &Urdf, source: &Source) -> Result<Self, InputError> {
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
struct LinkGroup<'u> {
    links: Vec<(usize, Isometry3<f64>)>,
    joint: Option<(&'u LocatedElement<urdf_rs::Joint>, Isometry3<f64>)>,
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

    fn link(
        &self,
        name: &str,
        joint: &LocatedElement<urdf_rs::Joint>,
    ) -> Result<usize, InputError> {
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
    fn explore(
        &self,
        link: usize,
        b_from_link: Isometry3<f64>,
    ) -> Result<LinkGroup<'u>, InputError> {
        let mut group =
            LinkGroup { links: vec![(link, b_from_link)], joint: None, mimics: Vec::new() };
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
    fn carries_axis(&self, joint: &LocatedElement<urdf_rs::Joint>) -> bool {
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
        joint: &LocatedElement<urdf_rs::Joint>,
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
        joint: &LocatedElement<urdf_rs::Joint>,
        b_from_joint: Isometry3<f64>,
        group: &LinkGroup<'_>,
    ) -> Result<UrdfJoint, InputError> {
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
            frames.push(FixedLink {
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
        Ok(UrdfJoint {
            name: e.name.clone(),
            origin,
            axis: b_from_joint.rotation * axis,
            limits,
            max_rate: rating(e.limit.velocity),
            max_torque: rating(e.limit.effort),
            body: (!bodies.is_empty()).then(|| UrdfBody::merged(&bodies, origin)),
            frames,
        })
    }

    fn body(
        &self,
        link: &LocatedElement<urdf_rs::Link>,
        b_from_link: &Isometry3<f64>,
    ) -> Result<UrdfBody, InputError> {
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
        Ok(UrdfBody { mass, center_of_mass: b_from_com.translation.vector, inertia })
    }
}
