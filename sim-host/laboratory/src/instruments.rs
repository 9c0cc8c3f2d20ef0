//! The instruments of the laboratory: their columns, their noise, and the logs that they are in.

use trueweld_plant::input::{Bounds, InputError, TomlTable};
use trueweld_plant::named;

named! {
    /// What was done in a log.
    pub(crate) enum SimulatedLogKind {
        Static = "static-load",
        Ring = "ring-down",
        Free = "free-motion",
        Weld = "weld",
    }
}

impl SimulatedLogKind {
    /// Time between rows, s, where it is even.
    pub(crate) fn period(self) -> Option<f64> {
        match self {
            Self::Static => None,
            Self::Ring => Some(0.001),
            Self::Free => Some(0.004),
            Self::Weld => Some(0.012),
        }
    }

    /// Columns that are set rather than read by an instrument, and their digits: the payload and
    /// its centre; the spindle speed.
    pub(crate) fn given(self) -> (&'static [&'static str], usize) {
        match self {
            Self::Static => (&["payload_kg", "cx_m", "cy_m", "cz_m"], 4),
            Self::Weld => (&["spindle_rad_s"], 5),
            Self::Ring | Self::Free => (&[], 0),
        }
    }
}

/// What an instrument reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ReadQuantity {
    Encoder,
    LinkEncoder,
    MotorTorque,
    Force,
    Moment,
    Position,
    Rotation,
}

/// One instrument: its columns, and its noise as `log.toml` states it.
pub(crate) struct SimulatedInstrument {
    pub quantity: ReadQuantity,
    pub columns: &'static [&'static str],
    pub digits: usize,
    pub noise_key: &'static str,
    /// Standard deviation of the noise, in the unit of the columns: about that of a thousand shots
    /// of a laser tracker, and of an average of the others at rest.
    deviation: f64,
    pub logs: &'static [SimulatedLogKind],
}

/// The instruments, in the order of their columns.
pub(crate) const INSTRUMENTS: [SimulatedInstrument; 7] = {
    use SimulatedLogKind::{Free, Ring, Static, Weld};
    [
        SimulatedInstrument {
            quantity: ReadQuantity::Encoder,
            columns: &["qe1_rad", "qe2_rad", "qe3_rad", "qe4_rad", "qe5_rad", "qe6_rad"],
            digits: 8,
            noise_key: "encoder_rad",
            deviation: 2e-6,
            logs: &[Static, Ring, Free, Weld],
        },
        SimulatedInstrument {
            quantity: ReadQuantity::LinkEncoder,
            columns: &["ql1_rad", "ql2_rad", "ql3_rad"],
            digits: 8,
            noise_key: "link_encoder_rad",
            deviation: 5e-6,
            logs: &[Free],
        },
        SimulatedInstrument {
            quantity: ReadQuantity::MotorTorque,
            columns: &["tm1_nm", "tm2_nm", "tm3_nm", "tm4_nm", "tm5_nm", "tm6_nm"],
            digits: 2,
            noise_key: "motor_torque_nm",
            deviation: 40.0,
            logs: &[Free],
        },
        SimulatedInstrument {
            quantity: ReadQuantity::Force,
            columns: &["fx_n", "fy_n", "fz_n"],
            digits: 2,
            noise_key: "force_n",
            deviation: 25.0,
            logs: &[Static, Weld],
        },
        SimulatedInstrument {
            quantity: ReadQuantity::Moment,
            columns: &["mx_nm", "my_nm", "mz_nm"],
            digits: 2,
            noise_key: "moment_nm",
            deviation: 8.0,
            logs: &[Static, Weld],
        },
        SimulatedInstrument {
            quantity: ReadQuantity::Position,
            columns: &["px_m", "py_m", "pz_m"],
            digits: 7,
            noise_key: "tcp_position_m",
            deviation: 30e-6,
            logs: &[Static, Ring, Free, Weld],
        },
        SimulatedInstrument {
            quantity: ReadQuantity::Rotation,
            columns: &["rx_rad", "ry_rad", "rz_rad"],
            digits: 7,
            noise_key: "tcp_rotation_rad",
            deviation: 50e-6,
            logs: &[Static, Free, Weld],
        },
    ]
};

/// Noise of each instrument, one standard deviation in the unit of its columns.
#[derive(Debug, Clone, PartialEq)]
pub struct InstrumentNoise([f64; INSTRUMENTS.len()]);

impl Default for InstrumentNoise {
    fn default() -> Self {
        Self(INSTRUMENTS.each_ref().map(|instrument| instrument.deviation))
    }
}

impl InstrumentNoise {
    /// Reads a `[noise]` table, with the keys that it has in a `log.toml`, one number each; what is
    /// left out is as usual.
    ///
    /// # Errors
    /// A key that is none of an instrument's; a number that cannot be noise.
    pub fn read(table: &TomlTable<'_>) -> Result<Self, InputError> {
        table.only(&INSTRUMENTS.each_ref().map(|instrument| instrument.noise_key))?;
        let mut noise = Self::default();
        for (deviation, instrument) in noise.0.iter_mut().zip(&INSTRUMENTS) {
            if table.has(instrument.noise_key) {
                let most = NOISE_RATIO_MAX * instrument.deviation;
                *deviation = table.number(instrument.noise_key, Bounds::PositiveUpTo(most))?;
            }
        }
        Ok(noise)
    }

    /// Deviation of one instrument.
    pub(crate) fn of(&self, instrument: &SimulatedInstrument) -> f64 {
        self.of_quantity(instrument.quantity)
    }

    /// Deviation of the instrument of a quantity; of the tracker's position also that of a reflector.
    pub(crate) fn of_quantity(&self, quantity: ReadQuantity) -> f64 {
        let index = INSTRUMENTS.iter().position(|known| known.quantity == quantity);
        index.map_or(0.0, |index| self.0[index])
    }
}

/// Most noise over what is usual: more is a number in another unit.
const NOISE_RATIO_MAX: f64 = 1e3;
