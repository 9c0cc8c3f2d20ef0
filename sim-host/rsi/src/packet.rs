//! The two packets, byte for byte.
//!
//! `<Rob>` is written as known clients read it, by position: RIst, AIPos, EIPos, Delay, then what a
//! configuration adds, IPOC last, no blank before `/>`. Both packets are read as XML: elements in any
//! order, unknown ones passed over, each known one once.

use crate::frame::Frame;
use roxmltree::{Document, Node, ParsingOptions};
use std::fmt::Write;

/// Most bytes of a packet.
pub const PACKET_BYTES: usize = 4096;

/// Most readings of a seam sensor in a packet.
pub const READINGS: usize = 4;

const AXES: [&str; 6] = ["A1", "A2", "A3", "A4", "A5", "A6"];
const EXTERNAL: [&str; 6] = ["E1", "E2", "E3", "E4", "E5", "E6"];
const FRAME: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];
const TORQUES: [&str; 6] = ["T1", "T2", "T3", "T4", "T5", "T6"];
const WRENCH: [&str; 6] = ["FX", "FY", "FZ", "MX", "MY", "MZ"];
const WELD: [&str; 3] = ["Path", "Feed", "Push"];
const VALUES: [&str; READINGS] = ["V1", "V2", "V3", "V4"];
const AGES: [&str; READINGS] = ["T1", "T2", "T3", "T4"];
const KINDS: [&str; READINGS] = ["K1", "K2", "K3", "K4"];

/// What is wrong with a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PacketError {
    /// No UTF-8, no XML, or too long.
    #[error("it is no XML")]
    Xml,
    /// Another root element.
    #[error("its root is not <{0}>")]
    Root(&'static str),
    /// An element or attribute is missing.
    #[error("{0} is missing")]
    Missing(&'static str),
    /// An element stands twice.
    #[error("{0} stands twice")]
    Twice(&'static str),
    /// A value is no finite number of its range.
    #[error("{0} is no number")]
    Number(&'static str),
}

/// One reading of a seam sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeamReading {
    /// True for a displacement across the seam, mm; false for a tilt about it, degrees.
    pub across: bool,
    /// mm or degrees.
    pub value: f64,
    /// How long ago it was seen, ms.
    pub age: f64,
}

/// What a configuration for welding adds to the controller's packet.
#[derive(Debug, Clone, PartialEq)]
pub struct WeldChannels {
    /// The path before correction, `RSol`.
    pub commanded: Frame,
    /// Motor torques seen from the joint, N·m.
    pub torque: [f64; 6],
    /// What the environment applies to the tool, axes of T: forces N, moments N·m.
    pub wrench: [f64; 6],
    /// Where the program is along the seam, mm.
    pub path: f64,
    /// Speed along the seam, mm/s.
    pub feed: f64,
    /// Push that the program asks for, N.
    pub push: f64,
    /// Readings of the seam sensor since the last packet.
    pub seam: Vec<SeamReading>,
}

/// The controller's packet.
#[derive(Debug, Clone, PartialEq)]
pub struct Rob {
    /// Pose of the tool by the encoders, `RIst`, in $BASE, the weld frame at the seam's start.
    pub actual: Frame,
    /// Axis angles by the encoders, degrees.
    pub axes: [f64; 6],
    /// External axes, mm or degrees.
    pub external: [f64; 6],
    /// Late packets in a row.
    pub delay: u32,
    /// What a configuration for welding adds.
    pub weld: Option<WeldChannels>,
    /// Time stamp, ms.
    pub ipoc: u64,
}

/// The client's packet.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sen {
    /// Correction of the pose, `RKorr`, axes of $BASE.
    pub correction: Frame,
    /// Correction of the axes, `AKorr` or `AK`, degrees.
    pub axes: [f64; 6],
    /// True where the client asks the controller to stop.
    pub stop: bool,
    /// Time stamp of the packet that this one answers, ms.
    pub ipoc: u64,
}

/// `<TAG N1="…" N2="…"/>` with five digits behind the point: 10 nm, and 0.2 µrad.
fn element(text: &mut String, tag: &str, names: &[&str], values: &[f64]) {
    let _ = write!(text, "<{tag}");
    for (name, value) in names.iter().zip(values) {
        let _ = write!(text, " {name}=\"{value:.5}\"");
    }
    text.push_str("/>");
}

impl Rob {
    /// Its bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut text = String::with_capacity(1200);
        text.push_str("<Rob Type=\"KUKA\">");
        element(&mut text, "RIst", &FRAME, &self.actual);
        element(&mut text, "AIPos", &AXES, &self.axes);
        element(&mut text, "EIPos", &EXTERNAL, &self.external);
        let _ = write!(text, "<Delay D=\"{}\"/>", self.delay);
        if let Some(weld) = &self.weld {
            element(&mut text, "RSol", &FRAME, &weld.commanded);
            element(&mut text, "Torque", &TORQUES, &weld.torque);
            element(&mut text, "Wrench", &WRENCH, &weld.wrench);
            element(&mut text, "Weld", &WELD, &[weld.path, weld.feed, weld.push]);
            let _ = write!(text, "<Seam N=\"{}\"", weld.seam.len().min(READINGS));
            for (k, reading) in weld.seam.iter().take(READINGS).enumerate() {
                let [kind, value, age] = [KINDS[k], VALUES[k], AGES[k]];
                let across = u8::from(!reading.across);
                let _ = write!(
                    text,
                    " {kind}=\"{across}\" {value}=\"{:.6}\" {age}=\"{:.3}\"",
                    reading.value, reading.age
                );
            }
            text.push_str("/>");
        }
        let _ = write!(text, "<IPOC>{}</IPOC></Rob>", self.ipoc);
        text.into_bytes()
    }

    /// Reads a packet.
    ///
    /// # Errors
    /// [`PacketError`].
    pub fn read(bytes: &[u8]) -> Result<Self, PacketError> {
        document(bytes, "Rob", |root| {
            let weld = match find(root, "Weld")? {
                Some(weld) => Some(weld_channels(root, weld)?),
                None => None,
            };
            Ok(Self {
                actual: six(needed(root, "RIst")?, &FRAME)?,
                axes: six(needed(root, "AIPos")?, &AXES)?,
                external: find(root, "EIPos")?.map_or(Ok([0.0; 6]), |e| six(e, &EXTERNAL))?,
                delay: whole(needed(root, "Delay")?.attribute("D"), "Delay")?,
                weld,
                ipoc: ipoc(root)?,
            })
        })
    }
}

fn weld_channels(root: Node<'_, '_>, weld: Node<'_, '_>) -> Result<WeldChannels, PacketError> {
    let [path, feed, push] = numbers(weld, &WELD)?;
    let mut readings = Vec::new();
    if let Some(seam) = find(root, "Seam")? {
        let count: u32 = whole(seam.attribute("N"), "Seam")?;
        for k in 0..count as usize {
            let (Some(kind), Some(value), Some(age)) = (KINDS.get(k), VALUES.get(k), AGES.get(k))
            else {
                return Err(PacketError::Number("Seam"));
            };
            let [kind, value, age] = numbers(seam, &[kind, value, age])?;
            readings.push(SeamReading { across: kind == 0.0, value, age });
        }
    }
    Ok(WeldChannels {
        commanded: six(needed(root, "RSol")?, &FRAME)?,
        torque: six(needed(root, "Torque")?, &TORQUES)?,
        wrench: six(needed(root, "Wrench")?, &WRENCH)?,
        path,
        feed,
        push,
        seam: readings,
    })
}

impl Sen {
    /// Its bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut text = String::with_capacity(300);
        text.push_str("<Sen Type=\"ImFree\"><EStr></EStr>");
        element(&mut text, "RKorr", &FRAME, &self.correction);
        if self.axes != [0.0; 6] {
            element(&mut text, "AKorr", &AXES, &self.axes);
        }
        let _ =
            write!(text, "<Stop>{}</Stop><IPOC>{}</IPOC></Sen>", u8::from(self.stop), self.ipoc);
        text.into_bytes()
    }

    /// Reads a packet. What it does not correct is not corrected.
    ///
    /// # Errors
    /// [`PacketError`].
    pub fn read(bytes: &[u8]) -> Result<Self, PacketError> {
        document(bytes, "Sen", |root| {
            let correction = find(root, "RKorr")?.map_or(Ok([0.0; 6]), |e| six(e, &FRAME))?;
            let axes = match (find(root, "AKorr")?, find(root, "AK")?) {
                (Some(_), Some(_)) => return Err(PacketError::Twice("AKorr")),
                (Some(axes), None) | (None, Some(axes)) => six(axes, &AXES)?,
                (None, None) => [0.0; 6],
            };
            let stop = match find(root, "Stop")?.map(|e| e.text().unwrap_or_default().trim()) {
                None | Some("0") => false,
                Some("1") => true,
                Some(_) => return Err(PacketError::Number("Stop")),
            };
            Ok(Self { correction, axes, stop, ipoc: ipoc(root)? })
        })
    }
}

fn document<P>(
    bytes: &[u8],
    name: &'static str,
    read: impl FnOnce(Node<'_, '_>) -> Result<P, PacketError>,
) -> Result<P, PacketError> {
    if bytes.len() > PACKET_BYTES {
        return Err(PacketError::Xml);
    }
    let text = std::str::from_utf8(bytes).map_err(|_| PacketError::Xml)?;
    let options =
        ParsingOptions { allow_dtd: false, nodes_limit: 256, ..ParsingOptions::default() };
    // Some clients end the packet with a zero.
    let document = Document::parse_with_options(text.trim_end_matches('\0'), options)
        .map_err(|_| PacketError::Xml)?;
    let root = document.root_element();
    if root.tag_name().name() != name {
        return Err(PacketError::Root(name));
    }
    read(root)
}

/// The child of this name; none is not an error.
fn find<'a, 'i>(
    root: Node<'a, 'i>,
    name: &'static str,
) -> Result<Option<Node<'a, 'i>>, PacketError> {
    let mut found = root.children().filter(|child| child.tag_name().name() == name);
    match (found.next(), found.next()) {
        (_, Some(_)) => Err(PacketError::Twice(name)),
        (one, None) => Ok(one),
    }
}

fn needed<'a, 'i>(root: Node<'a, 'i>, name: &'static str) -> Result<Node<'a, 'i>, PacketError> {
    find(root, name)?.ok_or(PacketError::Missing(name))
}

fn six(element: Node<'_, '_>, names: &[&'static str; 6]) -> Result<[f64; 6], PacketError> {
    numbers(element, names)
}

fn numbers<const N: usize>(
    element: Node<'_, '_>,
    names: &[&'static str; N],
) -> Result<[f64; N], PacketError> {
    let mut values = [0.0; N];
    for (value, name) in values.iter_mut().zip(names) {
        let text = element.attribute(*name).ok_or(PacketError::Missing(name))?;
        let number: f64 = text.parse().map_err(|_| PacketError::Number(name))?;
        if !number.is_finite() {
            return Err(PacketError::Number(name));
        }
        *value = number;
    }
    Ok(values)
}

fn whole<W: std::str::FromStr>(text: Option<&str>, name: &'static str) -> Result<W, PacketError> {
    let text = text.ok_or(PacketError::Missing(name))?;
    text.trim().parse().map_err(|_| PacketError::Number(name))
}

fn ipoc(root: Node<'_, '_>) -> Result<u64, PacketError> {
    whole(needed(root, "IPOC")?.text(), "IPOC")
}
