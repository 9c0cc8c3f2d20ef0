//! A file of sensors: `sensors/1`. Each sensor of the table reads its own.

use super::sensors::Sensors;
use super::{FileKind, InputError, InputFile, TomlTable};
use crate::sensors::{ideal, sensors};

impl InputFile for Sensors {
    const KIND: FileKind = FileKind::Sensors;

    fn from_root(root: &TomlTable<'_>) -> Result<Self, InputError> {
        let names = sensors().iter().map(|sensor| sensor.name);
        root.only(&["schema", "seed"].into_iter().chain(names).collect::<Vec<_>>())?;
        let mut values = ideal(root.integer("seed")?);
        for sensor in sensors() {
            if !sensor.optional || root.has(sensor.name) {
                (sensor.read)(&root.table(sensor.name)?, &mut values)?;
            }
        }
        Ok(values)
    }
}
