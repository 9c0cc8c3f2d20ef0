//! A URDF's links and joints with their places: read twice, once for what errors point at.

use crate::input::{InputError, Source};
use quick_xml::Reader;
use quick_xml::escape::escape;
use quick_xml::events::{BytesStart, Event};
use std::ops::Range;

/// Children of `<link>`, `<inertial>` and `<joint>` that a robot file has use for.
const KEPT: &[(&str, &[&str])] = &[
    ("link", &["inertial"]),
    ("inertial", &["origin", "mass", "inertia"]),
    ("joint", &["origin", "parent", "child", "axis", "limit", "mimic"]),
];

/// Attributes that hold numbers: element, attribute, how many.
const NUMBER_ATTRIBUTES: &[(&str, &str, usize)] = &[
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

/// Beyond this a coordinate, mass or inertia is a mistake, and products would overflow.
const URDF_NUMBER_MAX: f64 = 1e9;

/// A URDF's links and joints with their places.
pub(super) struct Urdf {
    pub(super) name: String,
    pub(super) links: Vec<LocatedElement<urdf_rs::Link>>,
    pub(super) joints: Vec<LocatedElement<urdf_rs::Joint>>,
}

/// An element and its start tag's place.
pub(super) struct LocatedElement<E> {
    pub(super) element: E,
    pub(super) span: Range<usize>,
    /// A link's `<inertial>` or a joint's `<limit>` is there; urdf-rs puts zeros where it is not.
    pub(super) stated: bool,
}

/// The part of a `<link>` or `<joint>` that is kept, as XML again.
struct KeptElement {
    xml: String,
    is_link: bool,
    span: Range<usize>,
    stated: bool,
}

impl Urdf {
    /// Reads the XML twice: once for well-formedness, places and numbers, then each link and joint
    /// by urdf-rs, which knows the format's versions and defaults but no places.
    pub(super) fn read(source: &Source) -> Result<Self, InputError> {
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
                urdf.links.push(LocatedElement { element, span, stated });
            }
            for element in robot.joints {
                let (span, stated) = place(k.stated);
                urdf.joints.push(LocatedElement { element, span, stated });
            }
        }
        Ok(urdf)
    }
}

/// Checks the XML and keeps what a robot file needs: the robot's name, the URDF version, links and
/// joints.
fn scan(source: &Source) -> Result<(String, String, Vec<KeptElement>), InputError> {
    let text = source.text();
    let mut reader = Reader::from_str(text);
    let mut robot: Option<(String, String)> = None;
    let mut kept: Vec<KeptElement> = Vec::new();
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
                kept.push(KeptElement {
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
        let what = format!("an attribute of <{element}> cannot be read: {error}");
        let help = "Quote every value and name an attribute once.";
        source.error(span.clone(), what + "; expected name=\"value\"", "in this tag", help)
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
        let count = NUMBER_ATTRIBUTES
            .iter()
            .find(|(e, k, _)| *e == element && *k == key)
            .map(|(_, _, n)| *n);
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
        && numbers
            .iter()
            .all(|n| n.as_ref().is_ok_and(|x| x.is_finite() && x.abs() <= URDF_NUMBER_MAX))
}
