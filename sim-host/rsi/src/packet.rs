//! The two packets, byte for byte.
//!
//! `<Rob>` has the elements of a list, as the context of a real controller has, in the list's order:
//! some clients read by position, with no blank before `/>` and IPOC last. Both packets are read as
//! XML: elements in any order, unknown ones passed over, each known one once.

use crate::frame::Frame;
use roxmltree::{Document, Node, ParsingOptions};
use std::fmt::{self, Write};

/// Most bytes of a packet.
pub(crate) const PACKET_BYTES: usize = 4096;

/// Most readings of a seam sensor in a packet.
pub(crate) const READINGS: usize = 4;

const AXIS_ATTRIBUTES: [&str; 6] = ["A1", "A2", "A3", "A4", "A5", "A6"];
const EXTERNAL_AXIS_ATTRIBUTES: [&str; 6] = ["E1", "E2", "E3", "E4", "E5", "E6"];
const FRAME_ATTRIBUTES: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];
const TORQUE_ATTRIBUTES: [&str; 6] = ["T1", "T2", "T3", "T4", "T5", "T6"];
const WRENCH_ATTRIBUTES: [&str; 6] = ["FX", "FY", "FZ", "MX", "MY", "MZ"];
const WELD_ATTRIBUTES: [&str; 3] = ["Path", "Feed", "Push"];
const VALUE_ATTRIBUTES: [&str; READINGS] = ["V1", "V2", "V3", "V4"];
const AGE_ATTRIBUTES: [&str; READINGS] = ["T1", "T2", "T3", "T4"];
const KIND_ATTRIBUTES: [&str; READINGS] = ["K1", "K2", "K3", "K4"];

/// An element of the controller's packet, by its name in a context.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Element {
    /// Pose of the tool by the encoders.
    RIst,
    /// Pose of the tool as commanded, before correction.
    RSol,
    /// Axis angles by the encoders.
    AIPos,
    /// Axis angles as commanded, before correction.
    ASPos,
    /// External axes.
    EIPos,
    /// Late packets in a row.
    Delay,
    /// Motor torques.
    Torque,
    /// Force sensor.
    Wrench,
    /// Where the program is.
    Weld,
    /// Seam sensor.
    Seam,
}

impl Element {
    /// What kuka-external-control-sdk reads, by position.
    pub const PLAIN: [Self; 4] = [Self::RIst, Self::AIPos, Self::EIPos, Self::Delay];

    /// What a law needs, behind the plain packet.
    pub const WELD: [Self; 9] = [
        Self::RIst,
        Self::AIPos,
        Self::EIPos,
        Self::Delay,
        Self::RSol,
        Self::Torque,
        Self::Wrench,
        Self::Weld,
        Self::Seam,
    ];

    /// Those of a controller without a weld's channels, by name.
    pub const NAMED: [(&'static str, Self); 6] = [
        ("RIst", Self::RIst),
        ("RSol", Self::RSol),
        ("AIPos", Self::AIPos),
        ("ASPos", Self::ASPos),
        ("EIPos", Self::EIPos),
        ("Delay", Self::Delay),
    ];
}

/// What is wrong with a packet.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PacketError {
    /// No UTF-8, no XML, or too long; and why.
    #[error("it is no XML: {0}")]
    Xml(String),
    /// Another root element.
    #[error("its root is not <{0}>")]
    Root(&'static str),
    /// An element, or an attribute of one, is missing.
    #[error("{0} is missing")]
    Missing(String),
    /// An element stands twice.
    #[error("{0} stands twice")]
    Twice(&'static str),
    /// An attribute that the element does not have.
    #[error("{0} is not known")]
    Unknown(String),
    /// A value is no finite number of its range.
    #[error("{place} is {text:?}, no number that it can be")]
    Number {
        /// Its element and attribute.
        place: String,
        /// How it begins.
        text: String,
    },
}

impl PacketError {
    fn number(place: impl Into<String>, text: &str) -> Self {
        Self::Number {
            place: place.into(),
            text: text.chars().take(SHOWN_VALUE_CHARACTERS).collect(),
        }
    }
}

/// Most characters of a wrong value that are told.
const SHOWN_VALUE_CHARACTERS: usize = 20;

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
    /// Pose of the tool as commanded, before correction, `RSol`, likewise.
    pub commanded: Option<Frame>,
    /// Axis angles by the encoders, degrees.
    pub axes: [f64; 6],
    /// Axis angles as commanded, before correction, `ASPos`, degrees.
    pub commanded_axes: Option<[f64; 6]>,
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
    /// Its bytes: those of the elements whose values it has.
    pub fn to_bytes(&self, elements: &[Element]) -> Vec<u8> {
        let mut text = String::with_capacity(1200);
        text.push_str("<Rob Type=\"KUKA\">");
        for of in elements {
            self.write(&mut text, *of);
        }
        let _ = write!(text, "<IPOC>{}</IPOC></Rob>", self.ipoc);
        text.into_bytes()
    }

    fn write(&self, text: &mut String, of: Element) {
        match (of, &self.weld) {
            (Element::RIst, _) => element(text, "RIst", &FRAME_ATTRIBUTES, &self.actual),
            (Element::RSol, _) => {
                self.commanded
                    .iter()
                    .for_each(|frame| element(text, "RSol", &FRAME_ATTRIBUTES, frame));
            }
            (Element::AIPos, _) => element(text, "AIPos", &AXIS_ATTRIBUTES, &self.axes),
            (Element::ASPos, _) => {
                self.commanded_axes
                    .iter()
                    .for_each(|axes| element(text, "ASPos", &AXIS_ATTRIBUTES, axes));
            }
            (Element::EIPos, _) => {
                element(text, "EIPos", &EXTERNAL_AXIS_ATTRIBUTES, &self.external)
            }
            (Element::Delay, _) => {
                let _ = write!(text, "<Delay D=\"{}\"/>", self.delay);
            }
            (Element::Torque, Some(weld)) => {
                element(text, "Torque", &TORQUE_ATTRIBUTES, &weld.torque)
            }
            (Element::Wrench, Some(weld)) => {
                element(text, "Wrench", &WRENCH_ATTRIBUTES, &weld.wrench)
            }
            (Element::Weld, Some(weld)) => {
                element(text, "Weld", &WELD_ATTRIBUTES, &[weld.path, weld.feed, weld.push]);
            }
            (Element::Seam, Some(weld)) => seam(text, &weld.seam),
            (Element::Torque | Element::Wrench | Element::Weld | Element::Seam, None) => {}
        }
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
                actual: numbers(needed(root, "RIst")?, &FRAME_ATTRIBUTES)?,
                commanded: optional(root, "RSol", &FRAME_ATTRIBUTES)?,
                axes: numbers(needed(root, "AIPos")?, &AXIS_ATTRIBUTES)?,
                commanded_axes: optional(root, "ASPos", &AXIS_ATTRIBUTES)?,
                external: optional(root, "EIPos", &EXTERNAL_AXIS_ATTRIBUTES)?.unwrap_or_default(),
                delay: whole(needed(root, "Delay")?.attribute("D"), "Delay D")?,
                weld,
                ipoc: ipoc(root)?,
            })
        })
    }
}

/// `<Seam N="…" K1="…" V1="…" T1="…" …/>`.
fn seam(text: &mut String, readings: &[SeamReading]) {
    let _ = write!(text, "<Seam N=\"{}\"", readings.len().min(READINGS));
    for (k, reading) in readings.iter().take(READINGS).enumerate() {
        let [kind, value, age] = [KIND_ATTRIBUTES[k], VALUE_ATTRIBUTES[k], AGE_ATTRIBUTES[k]];
        let across = u8::from(!reading.across);
        let _ = write!(
            text,
            " {kind}=\"{across}\" {value}=\"{:.6}\" {age}=\"{:.3}\"",
            reading.value, reading.age
        );
    }
    text.push_str("/>");
}

fn weld_channels(root: Node<'_, '_>, weld: Node<'_, '_>) -> Result<WeldChannels, PacketError> {
    let [path, feed, push] = numbers(weld, &WELD_ATTRIBUTES)?;
    let mut readings = Vec::new();
    if let Some(seam) = find(root, "Seam")? {
        let count: u32 = whole(seam.attribute("N"), "Seam N")?;
        for k in 0..count as usize {
            let (Some(kind), Some(value), Some(age)) =
                (KIND_ATTRIBUTES.get(k), VALUE_ATTRIBUTES.get(k), AGE_ATTRIBUTES.get(k))
            else {
                return Err(PacketError::number("Seam N", &count.to_string()));
            };
            let [kind, value, age] = numbers(seam, &[kind, value, age])?;
            readings.push(SeamReading { across: kind == 0.0, value, age });
        }
    }
    Ok(WeldChannels {
        torque: numbers(needed(root, "Torque")?, &TORQUE_ATTRIBUTES)?,
        wrench: numbers(needed(root, "Wrench")?, &WRENCH_ATTRIBUTES)?,
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
        element(&mut text, "RKorr", &FRAME_ATTRIBUTES, &self.correction);
        if self.axes != [0.0; 6] {
            element(&mut text, "AKorr", &AXIS_ATTRIBUTES, &self.axes);
        }
        let _ =
            write!(text, "<Stop>{}</Stop><IPOC>{}</IPOC></Sen>", u8::from(self.stop), self.ipoc);
        text.into_bytes()
    }

    /// Reads a packet. What it does not correct is not corrected: a context may have X, Y and Z alone.
    ///
    /// # Errors
    /// [`PacketError`].
    pub fn read(bytes: &[u8]) -> Result<Self, PacketError> {
        document(bytes, "Sen", |root| {
            let correction = components(find(root, "RKorr")?, &FRAME_ATTRIBUTES)?;
            let axes = match (find(root, "AKorr")?, find(root, "AK")?) {
                (Some(_), Some(_)) => return Err(PacketError::Twice("AKorr")),
                (axes, None) | (None, axes) => components(axes, &AXIS_ATTRIBUTES)?,
            };
            let stop = match find(root, "Stop")?.map(|e| e.text().unwrap_or_default().trim()) {
                None | Some("0") => false,
                Some("1") => true,
                Some(text) => return Err(PacketError::number("Stop", text)),
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
    let xml = |why: &dyn fmt::Display| PacketError::Xml(why.to_string());
    if bytes.len() > PACKET_BYTES {
        return Err(xml(&format!("longer than {PACKET_BYTES} bytes")));
    }
    let text = std::str::from_utf8(bytes).map_err(|error| xml(&error))?;
    let options =
        ParsingOptions { allow_dtd: false, nodes_limit: 256, ..ParsingOptions::default() };
    // Some clients end the packet with a zero.
    let document = Document::parse_with_options(text.trim_end_matches('\0'), options)
        .map_err(|error| xml(&error))?;
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
    find(root, name)?.ok_or_else(|| PacketError::Missing(name.to_owned()))
}

/// The values of a child that may not be there.
fn optional(
    root: Node<'_, '_>,
    name: &'static str,
    names: &[&'static str; 6],
) -> Result<Option<[f64; 6]>, PacketError> {
    find(root, name)?.map(|element| numbers(element, names)).transpose()
}

/// Where an attribute stands.
fn place(element: Node<'_, '_>, name: &str) -> String {
    format!("{} {name}", element.tag_name().name())
}

fn number(element: Node<'_, '_>, name: &str) -> Result<Option<f64>, PacketError> {
    let Some(text) = element.attribute(name) else { return Ok(None) };
    // Some clients pad their numbers with blanks.
    match text.trim().parse() {
        Ok(number) if f64::is_finite(number) => Ok(Some(number)),
        _ => Err(PacketError::number(place(element, name), text)),
    }
}

fn numbers<const N: usize>(
    element: Node<'_, '_>,
    names: &[&'static str; N],
) -> Result<[f64; N], PacketError> {
    let mut values = [0.0; N];
    for (value, name) in values.iter_mut().zip(names) {
        *value =
            number(element, name)?.ok_or_else(|| PacketError::Missing(place(element, name)))?;
    }
    Ok(values)
}

/// The components of a correction; those that a context lacks are 0.
fn components(
    element: Option<Node<'_, '_>>,
    names: &[&'static str; 6],
) -> Result<[f64; 6], PacketError> {
    let mut values = [0.0; 6];
    let Some(element) = element else { return Ok(values) };
    // A component by a wrong name would pass for one that is not corrected.
    if let Some(other) = element.attributes().find(|a| !names.contains(&a.name())) {
        return Err(PacketError::Unknown(place(element, other.name())));
    }
    for (value, name) in values.iter_mut().zip(names) {
        *value = number(element, name)?.unwrap_or(0.0);
    }
    Ok(values)
}

fn whole<W: std::str::FromStr>(text: Option<&str>, name: &'static str) -> Result<W, PacketError> {
    let text = text.ok_or_else(|| PacketError::Missing(name.to_owned()))?;
    text.trim().parse().map_err(|_| PacketError::number(name, text))
}

fn ipoc(root: Node<'_, '_>) -> Result<u64, PacketError> {
    whole(needed(root, "IPOC")?.text(), "IPOC")
}
