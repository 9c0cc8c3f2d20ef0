//! The caller's memory: all that believes a pointer is here.

use crate::types::{MEMORY_ALIGNMENT, Status};
use core::ffi::c_void;
use trueweld_compensators::RunningCore;
use trueweld_core::Real;
use trueweld_core::compensation::Compensator;

/// The first bytes of memory in which a core lies, before the size of its scalar.
const MAGIC: u64 = 0x7472_7565_7765_6c00;

/// What lies before a core.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Header {
    magic: u64,
    /// Place of the law in the table of laws.
    pub law: u32,
    /// 1 once started.
    pub started: u32,
    digest: [u8; 32],
}

/// A core with its header, as it lies in memory. `L`: the law as it runs.
#[repr(C)]
#[derive(Debug)]
pub struct Block<T: Real, L> {
    pub header: Header,
    pub core: RunningCore<T, L>,
}

/// The mark of a core of this scalar.
fn magic<T>() -> u64 {
    MAGIC | size_of::<T>() as u64
}

fn is_aligned<P>(pointer: *const P, alignment: usize) -> Result<(), Status> {
    if pointer.is_null() {
        return Err(Status::Null);
    }
    if !pointer.addr().is_multiple_of(alignment) {
        return Err(Status::Alignment);
    }
    Ok(())
}

/// A copy of what a pointer of the caller points to.
///
/// # Safety
/// `pointer` is null or points to a `V` in whose bytes any pattern is a value.
pub unsafe fn read<V: Copy>(pointer: *const V) -> Result<V, Status> {
    is_aligned(pointer, align_of::<V>())?;
    // SAFETY: neither null nor misaligned, and a `V` by the caller's promise.
    Ok(unsafe { pointer.read() })
}

/// What a pointer of the caller points to, where it lies.
///
/// # Safety
/// `pointer` is null or points to a `V` in whose bytes any pattern is a value, and which nothing
/// writes to while the reference lives.
pub unsafe fn refer<'a, V: Copy>(pointer: *const V) -> Result<&'a V, Status> {
    is_aligned(pointer, align_of::<V>())?;
    // SAFETY: neither null nor misaligned, and a `V` that stays by the caller's promise.
    Ok(unsafe { &*pointer })
}

/// Writes to where a pointer of the caller points to.
///
/// # Safety
/// `pointer` is null or has room for a `V`.
pub unsafe fn write<V: Copy>(pointer: *mut V, value: V) -> Result<(), Status> {
    is_aligned(pointer, align_of::<V>())?;
    // SAFETY: neither null nor misaligned, and room for a `V` by the caller's promise.
    unsafe { pointer.write(value) };
    Ok(())
}

/// The header of a core of the scalar `T`.
///
/// # Safety
/// `memory` is null or has the bytes of a header.
pub unsafe fn header<T>(memory: *const c_void) -> Result<Header, Status> {
    is_aligned(memory, MEMORY_ALIGNMENT)?;
    // SAFETY: aligned, and of a header's size by the caller's promise; any bytes are a header.
    let header = unsafe { memory.cast::<Header>().read() };
    if header.magic == magic::<T>() { Ok(header) } else { Err(Status::NotInitialised) }
}

/// SHA-256 of the configuration of a core of either scalar.
///
/// # Safety
/// `memory` is null or has the bytes of a header; `digest` is null or has 32 bytes.
pub unsafe fn digest(memory: *const c_void, digest: *mut u8) -> Result<Status, Status> {
    // SAFETY: the caller's promise.
    let header = unsafe { header::<f32>(memory).or_else(|_| header::<f64>(memory)) }?;
    // SAFETY: 32 bytes by the caller's promise; bytes have no alignment.
    unsafe { write(digest.cast::<[u8; 32]>(), header.digest) }?;
    Ok(Status::Ok)
}

/// Puts a core into the caller's memory.
///
/// # Safety
/// `memory` is null or has `bytes` bytes that nothing else uses.
#[inline(always)]
pub unsafe fn place<T: Real, L: Compensator<T>>(
    memory: *mut c_void,
    bytes: usize,
    law: u32,
    core: RunningCore<T, L>,
) -> Result<(), Status> {
    is_aligned(memory, MEMORY_ALIGNMENT)?;
    if bytes < size_of::<Block<T, L>>() || align_of::<Block<T, L>>() > MEMORY_ALIGNMENT {
        return Err(Status::MemorySize);
    }
    let header = Header { magic: magic::<T>(), law, started: 0, digest: *core.digest() };
    // SAFETY: aligned and large enough; the bytes are the core's alone by the caller's promise. What
    // lies there needs no drop.
    unsafe { memory.cast::<Block<T, L>>().write(Block { header, core }) };
    Ok(())
}

/// The core in the caller's memory.
///
/// # Safety
/// [`place`] put a core of this scalar and this law there, and no other reference to it lives.
pub unsafe fn block<'a, T: Real, L>(memory: *mut c_void) -> &'a mut Block<T, L> {
    // SAFETY: the caller's promise.
    unsafe { &mut *memory.cast::<Block<T, L>>() }
}

/// The core in the caller's memory, to be read.
///
/// # Safety
/// [`place`] put a core of this scalar and this law there, and no reference that changes it lives.
pub unsafe fn block_to_read<'a, T: Real, L>(memory: *const c_void) -> &'a Block<T, L> {
    // SAFETY: the caller's promise.
    unsafe { &*memory.cast::<Block<T, L>>() }
}
