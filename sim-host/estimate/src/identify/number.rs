//! A number that was identified, with its interval.

/// Quantile of the normal distribution for 95 %.
pub(crate) const TWO_SIDED: f64 = 1.959_964;

/// One number, with its interval in its unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// Key in its file.
    pub name: String,
    /// Name of the joint it is of; empty for one of the whole cell.
    pub at: String,
    /// The value found; the one given where the logs do not tell it.
    pub value: f64,
    /// 95 % interval; `None` where the logs do not tell the number.
    pub interval: Option<[f64; 2]>,
    /// The value given; NaN where there was none, as of a drive stated to be rigid.
    pub given: f64,
    /// Unit of value, interval and the value given.
    pub unit: &'static str,
}

impl Number {
    /// True where the logs tell it.
    pub fn is_identifiable(&self) -> bool {
        self.interval.is_some()
    }
}
