//! The table of variables: what the model description declares, and what getting and setting goes
//! by.
//!
//! A group of variables is declared once, with [`variables!`], as a struct of numbers. From that
//! follow the table and the way between the struct and the row of values that an importer gets and
//! sets, so that they cannot disagree.

use std::ops::Range;

/// The physical quantity of a variable, with its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PhysicalQuantity {
    /// Without a unit.
    Number,
    /// rad
    Angle,
    /// rad/s
    AngularVelocity,
    /// m
    Length,
    /// N
    Force,
    /// N·m
    Torque,
    /// s
    Time,
    /// Hz
    Frequency,
    /// N/m
    Stiffness,
    /// s/m
    Slowness,
}

/// Exponents of a unit in kg, m, s and rad.
pub(crate) type Exponents = [(&'static str, i32); 4];

impl PhysicalQuantity {
    /// Every quantity that has a unit.
    pub(crate) const WITH_UNIT: [Self; 9] = [
        Self::Angle,
        Self::AngularVelocity,
        Self::Length,
        Self::Force,
        Self::Torque,
        Self::Time,
        Self::Frequency,
        Self::Stiffness,
        Self::Slowness,
    ];

    /// Name of the type, its unit, and the unit's exponents; `None` without a unit.
    pub(crate) fn unit(self) -> Option<(&'static str, &'static str, Exponents)> {
        let (name, unit, [kg, m, s, rad]) = match self {
            Self::Number => return None,
            Self::Angle => ("Angle", "rad", [0, 0, 0, 1]),
            Self::AngularVelocity => ("AngularVelocity", "rad/s", [0, 0, -1, 1]),
            Self::Length => ("Length", "m", [0, 1, 0, 0]),
            Self::Force => ("Force", "N", [1, 1, -2, 0]),
            Self::Torque => ("Torque", "N.m", [1, 2, -2, 0]),
            Self::Time => ("Time", "s", [0, 0, 1, 0]),
            Self::Frequency => ("Frequency", "Hz", [0, 0, -1, 0]),
            Self::Stiffness => ("Stiffness", "N/m", [1, 0, -2, 0]),
            Self::Slowness => ("Slowness", "s/m", [0, -1, 1, 0]),
        };
        Some((name, unit, [("kg", kg), ("m", m), ("s", s), ("rad", rad)]))
    }

    /// Of a gain, whose key ends in its unit.
    pub(crate) fn of_key(key: &str) -> Self {
        const SUFFIXES: [(&str, PhysicalQuantity); 7] = [
            ("_rad_s", PhysicalQuantity::AngularVelocity),
            ("_n_m", PhysicalQuantity::Stiffness),
            ("_s_m", PhysicalQuantity::Slowness),
            ("_hz", PhysicalQuantity::Frequency),
            ("_rad", PhysicalQuantity::Angle),
            ("_m", PhysicalQuantity::Length),
            ("_s", PhysicalQuantity::Time),
        ];
        let suffix = SUFFIXES.iter().find(|(suffix, _)| key.ends_with(suffix));
        suffix.map_or(Self::Number, |(_, quantity)| *quantity)
    }
}

/// What values a variable has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ValueKind {
    /// Double precision.
    Real(PhysicalQuantity),
    /// 32 bits.
    Integer,
    /// True or false.
    Boolean,
}

/// Who sets a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Causality {
    /// Time.
    Independent,
    /// The importer, before the run begins.
    Parameter,
    /// The importer, at any time.
    Input,
    /// The FMU.
    Output,
}

/// A scalar or an array.
#[derive(Debug, Clone)]
pub(crate) struct FmuVariable {
    pub name: String,
    pub text: String,
    pub kind: ValueKind,
    pub causality: Causality,
    /// Length along each index, the last of which runs fastest; empty of a scalar.
    pub dimensions: Vec<usize>,
    /// Places of its values in the row: the first is its value reference in FMI 3.0, and in FMI 2.0
    /// each is that of one scalar.
    pub places: Range<usize>,
}

/// The variables of a model, and what they begin as.
#[derive(Debug, Clone)]
pub(crate) struct VariableTable {
    pub variables: Vec<FmuVariable>,
    pub start: Vec<f64>,
}

/// Place of the time in every row.
pub(crate) const TIME_PLACE: usize = 0;

impl VariableTable {
    /// The time alone, which is first in every table.
    pub(crate) fn new() -> Self {
        let mut table = Self { variables: Vec::new(), start: Vec::new() };
        let time = (ValueKind::Real(PhysicalQuantity::Time), Causality::Independent);
        table.add("time", "Time", time, &[], &[0.0]);
        table
    }

    /// Adds a variable.
    pub(crate) fn add(
        &mut self,
        name: impl Into<String>,
        text: impl Into<String>,
        (kind, causality): (ValueKind, Causality),
        dimensions: &[usize],
        start: &[f64],
    ) {
        let first = self.start.len();
        self.start.extend_from_slice(start);
        self.variables.push(FmuVariable {
            name: name.into(),
            text: text.into(),
            kind,
            causality,
            dimensions: dimensions.to_vec(),
            places: first..self.start.len(),
        });
    }

    /// Adds a group, whose values it begins as; where they are in the row.
    pub(crate) fn group<G: VariableGroup>(
        &mut self,
        group: &G,
        causality: Causality,
    ) -> Range<usize> {
        let first = self.start.len();
        group.declare(causality, self);
        first..self.start.len()
    }

    /// The variable that has a place in the row.
    pub(crate) fn at(&self, place: usize) -> Option<&FmuVariable> {
        let next = self.variables.partition_point(|variable| variable.places.end <= place);
        self.variables.get(next)
    }
}

/// Numbers that lie in the row one after another.
pub(crate) trait Slots {
    const DIMENSIONS: &'static [usize];
    const ZERO: Self;
    fn slots(&self) -> &[f64];
    fn slots_mut(&mut self) -> &mut [f64];
}

impl Slots for f64 {
    const DIMENSIONS: &'static [usize] = &[];
    const ZERO: Self = 0.0;

    fn slots(&self) -> &[f64] {
        std::slice::from_ref(self)
    }

    fn slots_mut(&mut self) -> &mut [f64] {
        std::slice::from_mut(self)
    }
}

impl<const N: usize> Slots for [f64; N] {
    const DIMENSIONS: &'static [usize] = &[N];
    const ZERO: Self = [0.0; N];

    fn slots(&self) -> &[f64] {
        self
    }

    fn slots_mut(&mut self) -> &mut [f64] {
        self
    }
}

impl<const N: usize, const M: usize> Slots for [[f64; N]; M] {
    const DIMENSIONS: &'static [usize] = &[M, N];
    const ZERO: Self = [[0.0; N]; M];

    fn slots(&self) -> &[f64] {
        self.as_flattened()
    }

    fn slots_mut(&mut self) -> &mut [f64] {
        self.as_flattened_mut()
    }
}

/// Variables that are declared together.
pub(crate) trait VariableGroup: Sized {
    /// All of them 0.
    const ZERO: Self;

    /// Adds them to a table.
    fn declare(&self, causality: Causality, table: &mut VariableTable);

    /// From their part of the row.
    fn load(values: &[f64]) -> Self;

    /// Into their part of the row.
    fn store(&self, values: &mut [f64]);
}

/// Declares a group of variables: `name: type = kind, "description";`.
macro_rules! variables {
    ($(#[$doc:meta])* $group:ident { $($name:ident: $type:ty = $kind:expr, $text:literal;)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub(crate) struct $group {
            $(#[doc = $text] pub $name: $type),*
        }

        impl $crate::variable::VariableGroup for $group {
            const ZERO: Self = Self { $($name: <$type as $crate::variable::Slots>::ZERO),* };

            fn declare(
                &self,
                causality: $crate::variable::Causality,
                table: &mut $crate::variable::VariableTable,
            ) {
                use $crate::variable::Slots;
                $(table.add(
                    stringify!($name),
                    $text,
                    ($kind, causality),
                    <$type>::DIMENSIONS,
                    self.$name.slots(),
                );)*
            }

            fn load(values: &[f64]) -> Self {
                use $crate::variable::Slots;
                let mut group = Self::ZERO;
                let mut rest = values;
                $({
                    let slots = group.$name.slots_mut();
                    let (own, others) = rest.split_at(slots.len());
                    slots.copy_from_slice(own);
                    rest = others;
                })*
                debug_assert!(rest.is_empty());
                group
            }

            fn store(&self, values: &mut [f64]) {
                use $crate::variable::Slots;
                let mut rest = values;
                $({
                    let slots = self.$name.slots();
                    let (own, others) = rest.split_at_mut(slots.len());
                    own.copy_from_slice(slots);
                    rest = others;
                })*
                debug_assert!(rest.is_empty());
            }
        }
    };
}
pub(crate) use variables;
