//! A configuration read back from the header of C that it was written to.
//!
//! The header holds the numbers in the order of the fields, with the fields' names as comments.

use crate::configuration::{
    Configuration, ControlNumbers, JointNumbers, LawNumbers, LimitNumbers, RobotNumbers,
};
use crate::gain_numbers::{GAINS, GainNumbers, Name};
use std::str::FromStr;
use trueweld_core::JOINTS;

/// Why a header is not that of a configuration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum HeaderError {
    /// It does not define this.
    Missing(&'static str),
    /// It ends before the last number, or goes on after it.
    Length,
    /// This stands where a number or a name is expected.
    Value(String),
    /// Its numbers are not those of its digest.
    Digest,
}

impl Configuration {
    /// The configuration that [`c_header`](Self::c_header) wrote.
    ///
    /// # Errors
    /// [`HeaderError`].
    pub fn from_c_header(header: &str) -> Result<Self, HeaderError> {
        let mut digest = HeaderValues::of(header, "trueweld_cell_digest[32]")?;
        let mut stated = [0_u8; 32];
        for byte in &mut stated {
            *byte = digest.parse()?;
        }
        let mut values = HeaderValues::of(header, "TrueweldConfiguration trueweld_cell")?;
        let read = values.configuration()?;
        if values.0.next().is_some() {
            return Err(HeaderError::Length);
        }
        if read.digest() == stated { Ok(read) } else { Err(HeaderError::Digest) }
    }
}

/// The values of an initialiser of C, in their order.
struct HeaderValues(std::vec::IntoIter<String>);

impl HeaderValues {
    /// Those of a variable. `name`: with what stands before it, for none other to be found.
    fn of(header: &str, name: &'static str) -> Result<Self, HeaderError> {
        let (_, after) = header.split_once(name).ok_or(HeaderError::Missing(name))?;
        let (_, value) = after.split_once('=').ok_or(HeaderError::Missing(name))?;
        let value = value.split(';').next().unwrap_or_default();
        let code =
            value.split("/*").map(|part| part.split_once("*/").map_or(part, |(_, code)| code));
        let code = code.collect::<String>();
        let values = code.split(|c: char| c.is_whitespace() || "{},".contains(c));
        let values: Vec<String> =
            values.filter(|value| !value.is_empty()).map(str::to_owned).collect();
        Ok(Self(values.into_iter()))
    }

    fn parse<T: FromStr>(&mut self) -> Result<T, HeaderError> {
        let value = self.0.next().ok_or(HeaderError::Length)?;
        value.parse().map_err(|_| HeaderError::Value(value))
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], HeaderError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.parse()?;
        }
        Ok(numbers)
    }

    fn name(&mut self) -> Result<Name, HeaderError> {
        let value = self.0.next().ok_or(HeaderError::Length)?;
        let name = value.strip_prefix('"').and_then(|name| name.strip_suffix('"'));
        name.map(Name::new).ok_or_else(|| HeaderError::Value(value.clone()))
    }

    // The fields in their order.
    fn configuration(&mut self) -> Result<Configuration, HeaderError> {
        Ok(Configuration {
            version: self.parse()?,
            bytes: self.parse()?,
            robot: self.robot()?,
            control: self.control()?,
            law: self.law()?,
        })
    }

    fn robot(&mut self) -> Result<RobotNumbers, HeaderError> {
        let gravity = self.numbers()?;
        let mut joints = [self.joint()?; JOINTS];
        for joint in &mut joints[1..] {
            *joint = self.joint()?;
        }
        Ok(RobotNumbers {
            gravity,
            joints,
            viscous: self.numbers()?,
            coulomb: self.numbers()?,
            smoothing: self.parse()?,
            cosine_terms: self.parse()?,
            table_points: self.parse()?,
            cosine: self.numbers()?,
            phase: self.parse()?,
            table: self.points()?,
            flange_offset: self.numbers()?,
            tool_mass: self.parse()?,
            tool_center_of_mass: self.numbers()?,
            tool_inertia: self.numbers()?,
            tcp_from_flange: self.numbers()?,
            tool_z_axis: self.numbers()?,
            tool_y_axis: self.numbers()?,
        })
    }

    fn points<const N: usize>(&mut self) -> Result<[[f64; 2]; N], HeaderError> {
        let mut points = [[0.0; 2]; N];
        for point in &mut points {
            *point = self.numbers()?;
        }
        Ok(points)
    }

    fn joint(&mut self) -> Result<JointNumbers, HeaderError> {
        Ok(JointNumbers {
            origin: self.numbers()?,
            axis: self.numbers()?,
            limits: self.numbers()?,
            max_rate: self.parse()?,
            max_torque: self.parse()?,
            stiffness: self.parse()?,
            damping: self.parse()?,
            rotor_inertia: self.parse()?,
            mass: self.parse()?,
            center_of_mass: self.numbers()?,
            inertia: self.numbers()?,
        })
    }

    fn control(&mut self) -> Result<ControlNumbers, HeaderError> {
        Ok(ControlNumbers {
            scheme: self.parse()?,
            reserved: self.parse()?,
            period: self.parse()?,
            position_kp: self.numbers()?,
            position_ki: self.numbers()?,
            position_kd: self.numbers()?,
            force_kp: self.parse()?,
            force_ki: self.parse()?,
            force_kd: self.parse()?,
            force_max_correction: self.parse()?,
            force_max_rate: self.parse()?,
            material_stiffness: self.parse()?,
            tuned_stiffness: self.parse()?,
            lateral: self.limits()?,
            orientation: self.limits()?,
            force_sensor_moment: self.parse()?,
            force_sensor_force: self.parse()?,
            force_sensor_disagreement: self.parse()?,
        })
    }

    fn limits(&mut self) -> Result<LimitNumbers, HeaderError> {
        Ok(LimitNumbers { bandwidth: self.parse()?, size: self.parse()?, rate: self.parse()? })
    }

    fn law(&mut self) -> Result<LawNumbers, HeaderError> {
        Ok(LawNumbers {
            name: self.name()?,
            length: self.parse()?,
            following_rate: self.parse()?,
            following_along: self.parse()?,
            following_size: self.parse()?,
            gain_count: self.parse()?,
            reserved: self.parse()?,
            gains: self.gains()?,
        })
    }

    fn gains(&mut self) -> Result<[GainNumbers; GAINS], HeaderError> {
        let mut gains = [GainNumbers::NONE; GAINS];
        for gain in &mut gains {
            *gain = GainNumbers {
                key: self.name()?,
                count: self.parse()?,
                reserved: self.parse()?,
                values: self.numbers()?,
            };
        }
        Ok(gains)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = include_str!("../../c-interface/examples/cell.h");

    #[test]
    fn a_header_is_read_back_to_the_numbers_that_it_was_written_from() {
        let read = Configuration::from_c_header(HEADER).expect("the header of the repository");
        assert_eq!(read.law.name.as_str(), "elastostatic");
        let again = Configuration::from_c_header(&read.c_header("again", [0, 0]));
        assert_eq!(again, Ok(read));
    }

    #[test]
    fn a_header_that_was_changed_is_refused() {
        let read = Configuration::from_c_header;
        let mass = HEADER.replacen("/* mass */ 558.0", "/* mass */ 559.0", 1);
        assert_eq!(read(&mass), Err(HeaderError::Digest));
        let word = HEADER.replacen("/* mass */ 558.0", "/* mass */ heavy", 1);
        assert_eq!(read(&word), Err(HeaderError::Value("heavy".to_owned())));
        let shorter = HEADER.replacen("/* mass */ 558.0", "", 1);
        assert!(matches!(read(&shorter), Err(HeaderError::Value(_))));
        assert!(matches!(read(""), Err(HeaderError::Missing(_))));
    }
}
