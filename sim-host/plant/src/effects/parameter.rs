//! Parameters of effects.

/// What a fit makes of a parameter: whether the effect grows with it from nothing, or takes its
/// shape from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Role {
    /// The effect is in proportion to the parameter's distance from `neutral`, nearly, where that
    /// is small.
    Size {
        /// A small value, at which the slope is taken.
        step: f64,
        /// The value at which there is no effect.
        neutral: f64,
    },
    /// The effect is in proportion to 1/value, nearly, where that is small.
    Reciprocal {
        /// A small 1/value, at which the slope is taken.
        step: f64,
    },
    /// Shapes the effect; values a fit may start from.
    Shape(&'static [f64]),
    /// Where along its variable the effect changes: it may pass through zero.
    Position {
        /// A small change, over which the slope is taken.
        step: f64,
        /// Values a fit may start from.
        starts: &'static [f64],
    },
    /// Periods per turn of the joint it is at.
    Order,
    /// Periods per turn of the spindle.
    SpindleOrder,
    /// Wavelength along the weld, m.
    Wavelength,
    /// Where along the weld, m.
    PathPosition,
    /// Phase of a sine whose amplitude is the parameter of role `Size`, rad.
    Phase,
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name, with its unit as the last part.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Meaning.
    pub meaning: &'static str,
    /// What a fit makes of it.
    pub role: Role,
    /// Smallest plausible value.
    pub low: f64,
    /// Largest plausible value.
    pub high: f64,
}

impl Parameter {
    /// True for a value that the effect may have. A phase may have any: it comes round.
    pub fn holds(&self, value: f64) -> bool {
        value.is_finite() && (self.role == Role::Phase || (self.low..=self.high).contains(&value))
    }

    /// True for a value at an end of its plausible range. A phase has none: it comes round.
    pub fn is_at_bound(&self, value: f64) -> bool {
        self.role != Role::Phase && (value == self.low || value == self.high)
    }

    /// A parameter, plausible within `range`.
    pub const fn new(
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
        role: Role,
        range: [f64; 2],
    ) -> Self {
        Self { name, unit, meaning, role, low: range[0], high: range[1] }
    }

    /// A size that is zero where there is no effect; its slope is taken at `step`.
    pub const fn size(
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
        step: f64,
        range: [f64; 2],
    ) -> Self {
        Self::new(name, unit, meaning, Role::Size { step, neutral: 0.0 }, range)
    }

    /// Periods n per turn of the joint, up to `most`.
    pub(super) const fn order(most: f64) -> Self {
        let meaning = "periods n per turn of the joint";
        Self::new("order", "1/turn", meaning, Role::Order, [0.5, most])
    }

    /// The value without effect, or nearest to it; of a parameter that only shapes the effect one
    /// that a fit may start from.
    pub fn neutral(&self) -> f64 {
        match self.role {
            Role::Size { neutral, .. } => neutral,
            Role::Reciprocal { .. } => self.high,
            Role::Shape(starts) | Role::Position { starts, .. } => {
                starts.first().copied().unwrap_or(self.low)
            }
            Role::Order | Role::SpindleOrder => self.low.max(1.0),
            Role::Wavelength | Role::PathPosition => 0.5 * (self.low + self.high),
            Role::Phase => 0.0,
        }
    }

    /// The value at which the effect is not there; `value` itself of a parameter that only shapes it.
    pub fn without_effect(&self, value: f64) -> f64 {
        match self.role {
            Role::Size { neutral, .. } => neutral,
            Role::Reciprocal { .. } => f64::INFINITY,
            _ => value,
        }
    }

    /// True for a parameter that an effect grows with from nothing.
    pub fn is_size(&self) -> bool {
        matches!(self.role, Role::Size { .. } | Role::Reciprocal { .. })
    }
}
