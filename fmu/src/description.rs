//! `modelDescription.xml`, from the table of variables.

use crate::model::Model;
use crate::variable::{Causality, FmuVariable, PhysicalQuantity, ValueKind};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesStart, Event};
use std::io;

/// Version of FMI.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FmiVersion {
    /// 2.0: scalars; read by every tool.
    Fmi2,
    /// 3.0: arrays.
    Fmi3,
}

/// What a model description says besides its variables.
#[derive(Debug, Clone)]
pub(crate) struct Heading<'a> {
    pub version: FmiVersion,
    /// Name of the shared library, without its ending.
    pub identifier: &'a str,
    pub name: &'a str,
    pub text: &'a str,
    /// The instantiation token, GUID in FMI 2.0.
    pub token: &'a str,
    pub tool: &'a str,
}

type Attributes<'a> = Vec<(&'a str, String)>;

struct Xml(Writer<Vec<u8>>);

impl Xml {
    fn start(&mut self, name: &str, attributes: &Attributes<'_>) -> io::Result<()> {
        self.0.write_event(Event::Start(element(name, attributes)))
    }

    fn end(&mut self, name: &str) -> io::Result<()> {
        self.0.write_event(Event::End(BytesStart::new(name).to_end()))
    }

    fn empty(&mut self, name: &str, attributes: &Attributes<'_>) -> io::Result<()> {
        self.0.write_event(Event::Empty(element(name, attributes)))
    }
}

fn element<'a>(name: &'a str, attributes: &'a Attributes<'_>) -> BytesStart<'a> {
    let mut element = BytesStart::new(name);
    for (key, value) in attributes {
        element.push_attribute((*key, value.as_str()));
    }
    element
}

/// The model description of a model.
///
/// # Errors
/// None in practice: memory takes whatever is written.
pub(crate) fn describe(model: &dyn Model, heading: &Heading<'_>) -> io::Result<Vec<u8>> {
    let mut xml = Xml(Writer::new_with_indent(Vec::new(), b' ', 2));
    xml.0.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let is_third = heading.version == FmiVersion::Fmi3;
    let token = if is_third { "instantiationToken" } else { "guid" };
    let version = if is_third { "3.0" } else { "2.0" };
    xml.start(
        "fmiModelDescription",
        &vec![
            ("fmiVersion", version.to_owned()),
            ("modelName", heading.name.to_owned()),
            (token, heading.token.to_owned()),
            ("description", heading.text.to_owned()),
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("generationTool", heading.tool.to_owned()),
            ("variableNamingConvention", "structured".to_owned()),
        ],
    )?;
    let flag = |name, is: bool| (name, is.to_string());
    let state = if is_third {
        ["canGetAndSetFMUState", "canSerializeFMUState"]
    } else {
        ["canGetAndSetFMUstate", "canSerializeFMUstate"]
    };
    let mut able = vec![
        ("modelIdentifier", heading.identifier.to_owned()),
        flag("canHandleVariableCommunicationStepSize", false),
        flag("canBeInstantiatedOnlyOncePerProcess", false),
        flag(state[0], true),
        flag(state[1], true),
    ];
    if is_third {
        able.push(("fixedInternalStepSize", model.period().to_string()));
        able.push(flag("hasEventMode", false));
    } else {
        able.push(flag("canNotUseMemoryManagementFunctions", true));
    }
    xml.empty("CoSimulation", &able)?;
    units(&mut xml)?;
    types(&mut xml, is_third)?;
    xml.start("LogCategories", &vec![])?;
    for (name, text) in LOG_CATEGORIES {
        let attributes = vec![("name", name.to_owned()), ("description", text.to_owned())];
        xml.empty("Category", &attributes)?;
    }
    xml.end("LogCategories")?;
    xml.empty(
        "DefaultExperiment",
        &vec![
            ("startTime", "0".to_owned()),
            ("stopTime", model.duration().to_string()),
            ("stepSize", model.period().to_string()),
        ],
    )?;
    xml.start("ModelVariables", &vec![])?;
    let table = model.table();
    for variable in &table.variables {
        let start = &table.start[variable.places.clone()];
        if is_third {
            array(&mut xml, variable, start)?;
        } else {
            scalars(&mut xml, variable, start)?;
        }
    }
    xml.end("ModelVariables")?;
    structure(&mut xml, &table.variables, is_third)?;
    xml.end("fmiModelDescription")?;
    Ok(xml.0.into_inner())
}

/// Categories of what is logged: name and description.
pub(crate) const LOG_CATEGORIES: [(&str, &str); 2] = [
    ("logStatusWarning", "Faults of a controller, drives at their limit"),
    ("logStatusError", "Calls that were refused, steps that failed"),
];

fn units(xml: &mut Xml) -> io::Result<()> {
    xml.start("UnitDefinitions", &vec![])?;
    for (_, unit, exponents) in
        PhysicalQuantity::WITH_UNIT.iter().filter_map(|quantity| quantity.unit())
    {
        xml.start("Unit", &vec![("name", unit.to_owned())])?;
        let base = exponents.iter().filter(|(_, exponent)| *exponent != 0);
        xml.empty("BaseUnit", &base.map(|(name, of)| (*name, of.to_string())).collect())?;
        xml.end("Unit")?;
    }
    xml.end("UnitDefinitions")
}

fn types(xml: &mut Xml, is_third: bool) -> io::Result<()> {
    xml.start("TypeDefinitions", &vec![])?;
    for (name, unit, _) in PhysicalQuantity::WITH_UNIT.iter().filter_map(|quantity| quantity.unit())
    {
        let of = vec![("quantity", name.to_owned()), ("unit", unit.to_owned())];
        let named = ("name", name.to_owned());
        if is_third {
            xml.empty("Float64Type", &[vec![named], of].concat())?;
        } else {
            xml.start("SimpleType", &vec![named])?;
            xml.empty("Real", &of)?;
            xml.end("SimpleType")?;
        }
    }
    xml.end("TypeDefinitions")
}

fn number(value: f64, kind: ValueKind) -> String {
    match kind {
        // Shortest digits that are read back to the same number.
        ValueKind::Real(_) => format!("{value:?}"),
        ValueKind::Integer => format!("{}", value as i64),
        ValueKind::Boolean => (value != 0.0).to_string(),
    }
}

/// Causality, variability and initial value as attributes.
fn roles(variable: &FmuVariable) -> Attributes<'static> {
    let is_real = matches!(variable.kind, ValueKind::Real(_));
    let varies = if is_real { "continuous" } else { "discrete" };
    let of = |causality: &str, variability: &str| {
        vec![("causality", causality.to_owned()), ("variability", variability.to_owned())]
    };
    match variable.causality {
        Causality::Independent => of("independent", "continuous"),
        Causality::Parameter => of("parameter", "fixed"),
        Causality::Input => of("input", varies),
        Causality::Output => {
            [of("output", varies), vec![("initial", "calculated".to_owned())]].concat()
        }
    }
}

/// Type and unit of a variable, and its start value where it has one.
fn typed(variable: &FmuVariable, start: &[f64]) -> Attributes<'static> {
    let mut attributes = Vec::new();
    if let ValueKind::Real(quantity) = variable.kind
        && let Some((name, unit, _)) = quantity.unit()
    {
        attributes.push(("declaredType", name.to_owned()));
        attributes.push(("unit", unit.to_owned()));
    }
    if matches!(variable.causality, Causality::Parameter | Causality::Input) {
        let numbers: Vec<String> =
            start.iter().map(|value| number(*value, variable.kind)).collect();
        attributes.push(("start", numbers.join(" ")));
    }
    attributes
}

/// The scalars of a variable, as FMI 2.0 has them.
fn scalars(xml: &mut Xml, variable: &FmuVariable, start: &[f64]) -> io::Result<()> {
    let element = match variable.kind {
        ValueKind::Real(_) => "Real",
        ValueKind::Integer => "Integer",
        ValueKind::Boolean => "Boolean",
    };
    for (k, place) in variable.places.clone().enumerate() {
        let named = vec![
            ("name", scalar_name(variable, k)),
            ("valueReference", place.to_string()),
            ("description", variable.text.clone()),
        ];
        xml.start("ScalarVariable", &[named, roles(variable)].concat())?;
        xml.empty(element, &typed(variable, &start[k..=k]))?;
        xml.end("ScalarVariable")?;
    }
    Ok(())
}

/// Name of a variable's scalar `k`: `encoder[2]`, `weld_axes[1,3]`.
fn scalar_name(variable: &FmuVariable, k: usize) -> String {
    let mut rest = k;
    let mut indices: Vec<String> = Vec::new();
    for length in variable.dimensions.iter().rev() {
        indices.insert(0, (rest % length + 1).to_string());
        rest /= length;
    }
    match &indices[..] {
        [] => variable.name.clone(),
        indices => format!("{}[{}]", variable.name, indices.join(",")),
    }
}

/// A variable as FMI 3.0 has it.
fn array(xml: &mut Xml, variable: &FmuVariable, start: &[f64]) -> io::Result<()> {
    let element = match variable.kind {
        ValueKind::Real(_) => "Float64",
        ValueKind::Integer => "Int32",
        ValueKind::Boolean => "Boolean",
    };
    let named = vec![
        ("name", variable.name.clone()),
        ("valueReference", variable.places.start.to_string()),
        ("description", variable.text.clone()),
    ];
    let attributes = [named, roles(variable), typed(variable, start)].concat();
    if variable.dimensions.is_empty() {
        return xml.empty(element, &attributes);
    }
    xml.start(element, &attributes)?;
    for length in &variable.dimensions {
        xml.empty("Dimension", &vec![("start", length.to_string())])?;
    }
    xml.end(element)
}

/// Outputs and what is known once initialised. An output is of the last step: it depends on no
/// input of the same instant, and a loop through the FMU is none of algebra.
fn structure(xml: &mut Xml, variables: &[FmuVariable], is_third: bool) -> io::Result<()> {
    let outputs = variables.iter().filter(|variable| variable.causality == Causality::Output);
    // Of scalars the index in the file, which counts from 1; of arrays the reference.
    let named: Vec<Attributes<'_>> = if is_third {
        outputs.map(|of| vec![("valueReference", of.places.start.to_string())]).collect()
    } else {
        let scalars = outputs.flat_map(|of| of.places.clone());
        scalars.map(|place| vec![("index", (place + 1).to_string())]).collect()
    };
    let outputs = named.iter().map(|of| {
        let mut output = of.clone();
        output.push(("dependencies", String::new()));
        output
    });
    xml.start("ModelStructure", &vec![])?;
    if is_third {
        for output in outputs {
            xml.empty("Output", &output)?;
        }
        for output in &named {
            xml.empty("InitialUnknown", output)?;
        }
    } else {
        xml.start("Outputs", &vec![])?;
        for output in outputs {
            xml.empty("Unknown", &output)?;
        }
        xml.end("Outputs")?;
        xml.start("InitialUnknowns", &vec![])?;
        for output in &named {
            xml.empty("Unknown", output)?;
        }
        xml.end("InitialUnknowns")?;
    }
    xml.end("ModelStructure")
}
