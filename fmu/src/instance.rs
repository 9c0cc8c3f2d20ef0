//! One instance of a model as an importer sees it: what may be called when, values by reference,
//! steps, and the state as bytes. Both versions of FMI call this; nothing here takes a pointer.

use crate::model::{Model, Stepped};
use crate::variable::{Causality, FmuVariable, TIME_PLACE, ValueKind};
use sha2::{Digest, Sha256};
use std::ops::Range;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};
use trueweld_plant::simulate::{restore_state, state_of};

/// First bytes of a state.
const STATE_MAGIC: &[u8; 8] = b"TWSTATE\x01";

/// Bytes of a digest.
const DIGEST: usize = 32;

/// Periods after which steps are counted no more.
const STEPS_MAX: usize = 1 << 48;

/// Share of a step by which a communication point or a step may be off: what adding steps up
/// rounds.
const STEP_TOLERANCE: f64 = 1e-3;

/// What may be called next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum InstanceMode {
    /// Parameters and inputs may be set.
    Instantiated,
    /// Likewise; the start time is known.
    Initialising,
    /// Steps may be taken.
    Stepping,
    /// Values may be read.
    Terminated,
    /// A step failed: values may be read, a state put back, the instance reset.
    Failed,
}

const INSTANCE_MODES: [InstanceMode; 5] = [
    InstanceMode::Instantiated,
    InstanceMode::Initialising,
    InstanceMode::Stepping,
    InstanceMode::Terminated,
    InstanceMode::Failed,
];

/// An instance.
pub(crate) struct Instance {
    model: Box<dyn Model>,
    /// SHA-256 that program, files and options have in common with the model description.
    token: [u8; DIGEST],
    mode: InstanceMode,
    values: Vec<f64>,
    /// Parameters that the model was initialised with.
    initialised: Option<Vec<f64>>,
    start_time: f64,
    steps: usize,
}

/// What an importer asks values of: the type of the variables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Asked {
    Real,
    Integer,
    Boolean,
}

impl Asked {
    fn is(self, kind: ValueKind) -> bool {
        matches!(
            (self, kind),
            (Self::Real, ValueKind::Real(_))
                | (Self::Integer, ValueKind::Integer)
                | (Self::Boolean, ValueKind::Boolean)
        )
    }
}

/// How references name values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Numbering {
    /// FMI 2.0: one a scalar.
    Scalars,
    /// FMI 3.0: one a variable, that of its first value.
    Variables,
}

impl Instance {
    /// A model before its run.
    pub(crate) fn new(model: Box<dyn Model>, token: [u8; DIGEST]) -> Self {
        let values = model.table().start.clone();
        Self {
            model,
            token,
            mode: InstanceMode::Instantiated,
            values,
            initialised: None,
            start_time: 0.0,
            steps: 0,
        }
    }

    fn must_be(&self, modes: &[InstanceMode], what: &str) -> Result<(), String> {
        if modes.contains(&self.mode) {
            return Ok(());
        }
        Err(format!("{what} cannot be called now: the instance is {:?}", self.mode))
    }

    /// The variable that a reference names, with its places in the row.
    fn variable(
        &self,
        reference: u32,
        numbering: Numbering,
        asked: Asked,
    ) -> Result<(&FmuVariable, Range<usize>), String> {
        let place = reference as usize;
        let known = self.model.table().at(place).filter(|variable| match numbering {
            Numbering::Scalars => true,
            Numbering::Variables => variable.places.start == place,
        });
        let variable = known.ok_or_else(|| format!("no variable has the reference {reference}"))?;
        if !asked.is(variable.kind) {
            let (name, kind) = (&variable.name, variable.kind);
            return Err(format!("{name} is {kind:?} and is asked for as {asked:?}"));
        }
        let places = match numbering {
            Numbering::Scalars => place..place + 1,
            Numbering::Variables => variable.places.clone(),
        };
        Ok((variable, places))
    }

    /// Values of variables, in the order of the references. `each` is called with every one of
    /// them.
    ///
    /// # Errors
    /// A reference that is unknown or of another type.
    pub(crate) fn get(
        &self,
        references: &[u32],
        (numbering, asked): (Numbering, Asked),
        mut each: impl FnMut(f64),
    ) -> Result<(), String> {
        for reference in references {
            let (_, places) = self.variable(*reference, numbering, asked)?;
            self.values[places].iter().for_each(|value| each(*value));
        }
        Ok(())
    }

    /// Values that variables have together.
    ///
    /// # Errors
    /// A reference that is unknown or of another type.
    pub(crate) fn count(
        &self,
        references: &[u32],
        (numbering, asked): (Numbering, Asked),
    ) -> Result<usize, String> {
        let each = |reference: &u32| Ok(self.variable(*reference, numbering, asked)?.1.len());
        references.iter().map(each).sum()
    }

    /// Sets variables; nothing is set where one of them cannot be.
    ///
    /// # Errors
    /// A reference that is unknown, of another type, or of a variable that cannot be set now; another
    /// count of values; a parameter that is NaN or infinite.
    pub(crate) fn set(
        &mut self,
        references: &[u32],
        (numbering, asked): (Numbering, Asked),
        given: &[f64],
    ) -> Result<(), String> {
        self.must_be(
            &[InstanceMode::Instantiated, InstanceMode::Initialising, InstanceMode::Stepping],
            "setting",
        )?;
        let count = self.count(references, (numbering, asked))?;
        if count != given.len() {
            return Err(format!("{} values were given for {count}", given.len()));
        }
        let mut next = self.values.clone();
        let mut rest = given;
        for reference in references {
            let (variable, places) = self.variable(*reference, numbering, asked)?;
            let (own, others) = rest.split_at(places.len());
            let name = &variable.name;
            match variable.causality {
                Causality::Input => {}
                Causality::Parameter if self.mode == InstanceMode::Stepping => {
                    return Err(format!("the parameter {name} is fixed once the run has begun"));
                }
                Causality::Parameter if own.iter().any(|value| !value.is_finite()) => {
                    return Err(format!("the parameter {name} is set to NaN or infinity"));
                }
                Causality::Parameter => {}
                Causality::Output | Causality::Independent => {
                    return Err(format!("{name} is no input and cannot be set"));
                }
            }
            next[places].copy_from_slice(own);
            rest = others;
        }
        self.values = next;
        Ok(())
    }

    /// Sets when the run starts, s.
    ///
    /// # Errors
    /// Not the time for it, or no time.
    pub(crate) fn set_start_time(&mut self, start_time: f64) -> Result<(), String> {
        self.must_be(&[InstanceMode::Instantiated], "setting up the experiment")?;
        if !start_time.is_finite() {
            return Err(format!("the start time is {start_time}"));
        }
        (self.start_time, self.values[TIME_PLACE]) = (start_time, start_time);
        Ok(())
    }

    /// Begins to initialise.
    ///
    /// # Errors
    /// Not the time for it.
    pub(crate) fn enter_initialisation(&mut self) -> Result<(), String> {
        self.must_be(&[InstanceMode::Instantiated], "entering initialisation")?;
        self.mode = InstanceMode::Initialising;
        Ok(())
    }

    /// Begins the run, with the parameters as they are set.
    ///
    /// # Errors
    /// A parameter that cannot be.
    pub(crate) fn exit_initialisation(&mut self) -> Result<(), String> {
        self.must_be(&[InstanceMode::Initialising], "leaving initialisation")?;
        self.initialise().inspect_err(|_| self.mode = InstanceMode::Failed)?;
        (self.steps, self.mode) = (0, InstanceMode::Stepping);
        Ok(())
    }

    fn initialise(&mut self) -> Result<(), String> {
        self.initialised = None;
        self.model.initialise(&mut self.values)?;
        self.initialised = Some(self.parameters());
        Ok(())
    }

    fn parameters(&self) -> Vec<f64> {
        let variables = self.model.table().variables.iter();
        let parameters = variables.filter(|of| of.causality == Causality::Parameter);
        parameters.flat_map(|of| self.values[of.places.clone()].iter().copied()).collect()
    }

    /// Time up to which steps were taken, s.
    pub(crate) fn time(&self) -> f64 {
        self.start_time + self.steps as f64 * self.model.period()
    }

    /// One step of the model from a communication point, s, of a size, s.
    ///
    /// # Errors
    /// Not the time for it; another point or size than the model's; a step that fails, after which
    /// there are no more.
    pub(crate) fn step(&mut self, from: f64, size: f64) -> Result<Stepped, String> {
        self.must_be(&[InstanceMode::Stepping], "a step")?;
        let (period, time) = (self.model.period(), self.time());
        let tolerance = STEP_TOLERANCE * period;
        // Also false where there is no number.
        let is_near = |given: f64, expected: f64| (given - expected).abs() <= tolerance;
        if !is_near(size, period) {
            return Err(format!("the step is {size} s; expected {period} s, the control period"));
        }
        if !is_near(from, time) {
            return Err(format!("the step begins at {from} s; expected {time} s"));
        }
        let stepped = self.model.step(&mut self.values);
        let stepped = stepped.inspect_err(|_| self.mode = InstanceMode::Failed)?;
        self.steps += 1;
        self.values[TIME_PLACE] = self.time();
        Ok(stepped)
    }

    /// Ends the run.
    ///
    /// # Errors
    /// Not the time for it.
    pub(crate) fn terminate(&mut self) -> Result<(), String> {
        self.must_be(&[InstanceMode::Stepping, InstanceMode::Failed], "terminating")?;
        self.mode = InstanceMode::Terminated;
        Ok(())
    }

    /// As it was instantiated.
    pub(crate) fn reset(&mut self) {
        self.values.clone_from(&self.model.table().start);
        (self.mode, self.initialised) = (InstanceMode::Instantiated, None);
        (self.start_time, self.steps) = (0.0, 0);
    }

    /// Holds no more steps: after a panic nothing that it holds can be trusted.
    pub(crate) fn fail(&mut self) {
        self.mode = InstanceMode::Failed;
    }

    /// Its whole state, which an instance of the same FMU takes in any process:
    ///
    /// ```text
    /// 8 bytes   "TWSTATE" and the version of this layout
    /// 32 bytes  digest of program, files and options, the instantiation token
    /// 8 bytes   count of numbers, little-endian, then the numbers as f64, little-endian
    /// 32 bytes  SHA-256 of all before
    /// ```
    ///
    /// # Errors
    /// A law that does not give its state.
    pub(crate) fn state(&mut self) -> Result<Vec<u8>, String> {
        let mut numbers = vec![f64::from(self.initialised.is_some())];
        numbers.extend(&self.values);
        numbers.extend(state_of(self).map_err(|error| error.to_string())?);
        let mut bytes = STATE_MAGIC.to_vec();
        bytes.extend(self.token);
        bytes.extend((numbers.len() as u64).to_le_bytes());
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        let digest = Sha256::digest(&bytes);
        bytes.extend(digest);
        Ok(bytes)
    }

    /// That bytes are a state of this FMU, and whole.
    ///
    /// # Errors
    /// What is wrong with them.
    pub(crate) fn check_state(&self, state: &[u8]) -> Result<(), String> {
        self.numbers_of(state).map(drop)
    }

    /// Goes on from a state.
    ///
    /// # Errors
    /// A state that is cut, damaged, or of another FMU: then the instance is as it was.
    pub(crate) fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        let numbers = self.numbers_of(state)?;
        let (head, rest) = numbers.split_at(1 + self.values.len());
        self.values.copy_from_slice(&head[1..]);
        let parameters = self.parameters();
        if head[0] == 1.0 && self.initialised.as_ref() != Some(&parameters) {
            // The model writes its first outputs, which are not those of the state.
            self.initialise()?;
            self.values.copy_from_slice(&head[1..]);
        } else if head[0] == 0.0 {
            self.initialised = None;
        }
        restore_state(self, rest).map_err(|error| {
            self.mode = InstanceMode::Failed;
            error.to_string()
        })?;
        if self.initialised.is_some() {
            self.model.restored();
        }
        Ok(())
    }

    /// The numbers of a state of this FMU.
    fn numbers_of(&self, state: &[u8]) -> Result<Vec<f64>, String> {
        let foreign = "the state is of another FMU or another version of it";
        let cut = "the state is cut or damaged";
        let rest = state.strip_prefix(STATE_MAGIC).ok_or("the bytes are no state of this FMU")?;
        let (token, rest) = rest.split_at_checked(DIGEST).ok_or(cut)?;
        if token != self.token {
            return Err(foreign.to_owned());
        }
        let (sealed, digest) =
            state.split_at_checked(state.len().saturating_sub(DIGEST)).ok_or(cut)?;
        if *Sha256::digest(sealed) != *digest {
            return Err(cut.to_owned());
        }
        let (count, numbers) = rest.split_first_chunk::<8>().ok_or(cut)?;
        let numbers = &numbers[..numbers.len().saturating_sub(DIGEST)];
        let (numbers, odd) = numbers.as_chunks::<8>();
        if !odd.is_empty()
            || u64::from_le_bytes(*count) != numbers.len() as u64
            || numbers.len() <= self.values.len()
        {
            return Err(cut.to_owned());
        }
        Ok(numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
    }
}

/// All but values and parameters.
impl Stateful for Instance {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        let mut mode =
            INSTANCE_MODES.iter().position(|mode| *mode == self.mode).unwrap_or_default();
        visitor.count(&mut mode, INSTANCE_MODES.len() - 1)?;
        visitor.scalar(&mut self.start_time)?;
        visitor.count(&mut self.steps, STEPS_MAX)?;
        if self.initialised.is_some() {
            self.model.visit_state(visitor)?;
        }
        self.mode = INSTANCE_MODES[mode];
        Ok(())
    }
}
