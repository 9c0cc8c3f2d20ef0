//! What is done with the law that lies in the caller's memory, whichever it is.
//!
//! The table of laws is walked until the law is found: by its name when a core is built, by its
//! place afterwards. A new law of the table is known here without a line.

use crate::memory::{self, Block};
use crate::types::{Inputs, MEASUREMENTS, Outputs, Pose, Status, check};
use core::ffi::c_void;
use trueweld_compensators::{Configuration, Law, RunningCore, Visitor, for_each};
use trueweld_core::compensation::Observation;
use trueweld_core::{JointVector, Real, Robot, Wrench, scalar};

type Done = Result<Status, Status>;

/// Something that is done with one law.
trait Operation<T: Real> {
    /// True for the law that it is to be done with: `place` in the table.
    fn is_for<L: Law<T>>(&self, place: u32) -> bool;

    /// Does it.
    fn run<L: Law<T>>(&mut self, place: u32) -> Done;
}

/// Walks the table. What is done with a law is a function of its own (`#[inline(never)]`): in one
/// function with those of the other laws it would take the stack of all of them together.
struct Walk<'a, O> {
    operation: &'a mut O,
    place: u32,
    done: Option<Done>,
}

impl<T: Real, O: Operation<T>> Visitor<T> for Walk<'_, O> {
    fn visit<L: Law<T>>(&mut self) {
        if self.done.is_none() && self.operation.is_for::<L>(self.place) {
            self.done = Some(self.operation.run::<L>(self.place));
        }
        self.place += 1;
    }
}

fn with_law<T: Real>(mut operation: impl Operation<T>, unknown: Status) -> Done {
    let mut walk = Walk { operation: &mut operation, place: 0, done: None };
    for_each::<T>(&mut walk);
    walk.done.unwrap_or(Err(unknown))
}

/// Six numbers of the caller's.
///
/// # Safety
/// `pointer` is null or has six numbers.
unsafe fn six<T: Real>(pointer: *const T) -> Result<JointVector<T>, Status> {
    // SAFETY: the caller's promise; any bytes are numbers.
    unsafe { memory::read(pointer.cast::<[T; 6]>()) }.map(JointVector::from)
}

/// The configuration of the caller's, where it lies: it is too large for the stack.
///
/// # Safety
/// `pointer` is null or points to a configuration, of this version or another, of no less than a
/// configuration's bytes, which nothing writes to while the reference lives.
unsafe fn configuration<'a>(pointer: *const Configuration) -> Result<&'a Configuration, Status> {
    // SAFETY: the caller's promise; any bytes are a configuration.
    let configuration = unsafe { memory::refer(pointer) }?;
    configuration.check()?;
    Ok(configuration)
}

/// How many bytes a law needs.
struct Bytes<'a>(&'a Configuration, usize);

impl<T: Real> Operation<T> for &mut Bytes<'_> {
    fn is_for<L: Law<T>>(&self, _: u32) -> bool {
        self.0.law.name.as_str() == L::NAME
    }

    fn run<L: Law<T>>(&mut self, _: u32) -> Done {
        self.1 = size_of::<Block<T, L::Built>>();
        Ok(Status::Ok)
    }
}

/// # Safety
/// The pointers are null or point to what their types say.
pub unsafe fn bytes<T: Real>(from: *const Configuration, bytes: *mut usize) -> Done {
    // SAFETY: the caller's promise.
    let configuration = unsafe { configuration(from) }?;
    let mut operation = Bytes(configuration, 0);
    with_law::<T>(&mut operation, Status::Law)?;
    // SAFETY: the caller's promise.
    unsafe { memory::write(bytes, operation.1) }?;
    Ok(Status::Ok)
}

/// Builds a core in memory.
struct Initialise<'a> {
    memory: *mut c_void,
    bytes: usize,
    configuration: &'a Configuration,
}

impl<T: Real> Operation<T> for Initialise<'_> {
    fn is_for<L: Law<T>>(&self, _: u32) -> bool {
        self.configuration.law.name.as_str() == L::NAME
    }

    #[inline(never)]
    fn run<L: Law<T>>(&mut self, place: u32) -> Done {
        let core = RunningCore::<T, L::Built>::new::<L>(self.configuration)?;
        // SAFETY: the promise of who made the operation.
        unsafe { memory::place(self.memory, self.bytes, place, core) }?;
        Ok(Status::Ok)
    }
}

/// # Safety
/// `memory` is null or has `bytes` bytes that nothing else uses; `from` is null or points to a
/// configuration.
pub unsafe fn initialise<T: Real>(
    memory: *mut c_void,
    bytes: usize,
    from: *const Configuration,
) -> Done {
    if memory.is_null() {
        return Err(Status::Null);
    }
    // SAFETY: the caller's promise.
    let configuration = unsafe { configuration(from) }?;
    with_law::<T>(Initialise { memory, bytes, configuration }, Status::Law)
}

/// Starts a weld.
struct Start<T: Real> {
    memory: *mut c_void,
    law: u32,
    encoder: JointVector<T>,
    torque: JointVector<T>,
}

impl<T: Real> Operation<T> for Start<T> {
    fn is_for<L: Law<T>>(&self, place: u32) -> bool {
        place == self.law
    }

    #[inline(never)]
    fn run<L: Law<T>>(&mut self, _: u32) -> Done {
        // SAFETY: the header says that a core of this law lies there; the reference ends here.
        let block = unsafe { memory::block::<T, L::Built>(self.memory) };
        block.core.start(&self.encoder, &self.torque);
        block.header.started = 1;
        Ok(Status::Ok)
    }
}

/// # Safety
/// `memory` is null or was initialised for this scalar; the others are null or have six numbers.
pub unsafe fn start<T: Real>(memory: *mut c_void, encoder: *const T, torque: *const T) -> Done {
    // SAFETY: the caller's promise.
    let header = unsafe { memory::header::<T>(memory) }?;
    // SAFETY: the caller's promise.
    let (encoder, torque) = unsafe { (six(encoder)?, six(torque)?) };
    if !scalar::all_finite(encoder.iter().chain(torque.iter())) {
        return Err(Status::NotFinite);
    }
    with_law(Start { memory, law: header.law, encoder, torque }, Status::NotInitialised)
}

/// One control period.
struct Cycle<'a, T: Real> {
    memory: *mut c_void,
    law: u32,
    inputs: &'a Inputs<T>,
    outputs: *mut Outputs<T>,
}

impl<T: Real> Operation<T> for Cycle<'_, T> {
    fn is_for<L: Law<T>>(&self, place: u32) -> bool {
        place == self.law
    }

    #[inline(never)]
    fn run<L: Law<T>>(&mut self, _: u32) -> Done {
        // SAFETY: the header says that a core of this law lies there; the reference ends here.
        let block = unsafe { memory::block::<T, L::Built>(self.memory) };
        let inputs = self.inputs;
        let measurements = inputs.measurements();
        let count = inputs.measurement_count as usize;
        let observation = Observation {
            setpoint: &inputs.setpoint(),
            nominal: &inputs.nominal.to_core(),
            sensed: &inputs.sensed(),
            path: inputs.path,
            planned: inputs.planned(),
            measurements: measurements.get(..count).ok_or(Status::Count)?,
            taught: None,
        };
        let command = block.core.cycle(&observation);
        let (outputs, status) = Outputs::of(&command, &block.core.correction());
        // SAFETY: the promise of who made the operation.
        unsafe { memory::write(self.outputs, outputs) }?;
        Ok(status)
    }
}

/// # Safety
/// `memory` is null or was initialised for this scalar and is used by no other call; the others are
/// null or point to what their types say.
pub unsafe fn cycle<T: Real>(
    memory: *mut c_void,
    inputs: *const Inputs<T>,
    outputs: *mut Outputs<T>,
) -> Done {
    // SAFETY: the caller's promise.
    let header = unsafe { memory::header::<T>(memory) }?;
    if header.started != 1 {
        return Err(Status::NotStarted);
    }
    // SAFETY: the caller's promise; any bytes are inputs and outputs.
    let (inputs, before) = unsafe { (&memory::read(inputs)?, memory::read(outputs.cast_const())?) };
    check(inputs)?;
    check(&before)?;
    if inputs.force_closed > 1 || inputs.measurement_count as usize > MEASUREMENTS {
        return Err(Status::Count);
    }
    with_law(Cycle { memory, law: header.law, inputs, outputs }, Status::NotInitialised)
}

/// Something asked of the model.
struct Ask<'a, T: Real> {
    memory: *const c_void,
    law: u32,
    question: &'a mut dyn FnMut(&Robot<T>) -> Done,
}

impl<T: Real> Operation<T> for Ask<'_, T> {
    fn is_for<L: Law<T>>(&self, place: u32) -> bool {
        place == self.law
    }

    fn run<L: Law<T>>(&mut self, _: u32) -> Done {
        // SAFETY: the header says that a core of this law lies there; the reference ends here.
        let block = unsafe { memory::block_to_read::<T, L::Built>(self.memory) };
        (self.question)(block.core.robot())
    }
}

/// Joint angles at a pose.
fn angles<T: Real>(
    robot: &Robot<T>,
    pose: &Pose<T>,
    near: &JointVector<T>,
) -> Result<JointVector<T>, Status> {
    robot.inverse_near(&pose.to_core(), near).map_err(|_| Status::Unreachable)
}

/// # Safety
/// `memory` is null or was initialised for this scalar; the others are null or point to what their
/// types say, to six numbers.
pub unsafe fn inverse<T: Real>(
    memory: *const c_void,
    pose: *const Pose<T>,
    near: *const T,
    to: *mut T,
) -> Done {
    // SAFETY: the caller's promise; any bytes are a pose.
    let (header, pose, near) =
        unsafe { (memory::header::<T>(memory)?, memory::read(pose)?, six(near)?) };
    let question = &mut |robot: &Robot<T>| {
        let angles: [T; 6] = angles(robot, &pose, &near)?.into();
        // SAFETY: the caller's promise.
        unsafe { memory::write(to.cast(), angles) }?;
        Ok(Status::Ok)
    };
    with_law(Ask { memory, law: header.law, question }, Status::NotInitialised)
}

/// # Safety
/// As of [`inverse`].
pub unsafe fn taught<T: Real>(
    memory: *const c_void,
    nominal: *const Pose<T>,
    near: *const T,
    to: *mut Pose<T>,
) -> Done {
    // SAFETY: the caller's promise; any bytes are a pose.
    let (header, nominal, near) =
        unsafe { (memory::header::<T>(memory)?, memory::read(nominal)?, six(near)?) };
    let question = &mut |robot: &Robot<T>| {
        let link = angles(robot, &nominal, &near)?;
        let motor = robot.fake_target(&link, &Wrench::zero());
        let pose = Pose::of(&robot.forward_kinematics(&motor));
        // SAFETY: the caller's promise.
        unsafe { memory::write(to, pose) }?;
        Ok(Status::Ok)
    };
    with_law(Ask { memory, law: header.law, question }, Status::NotInitialised)
}
