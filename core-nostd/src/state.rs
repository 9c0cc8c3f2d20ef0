//! What changes while a controller or a law runs, as a row of numbers: taken out of one, and put
//! back into another that was built from the same configuration.
//!
//! A type lists what changes in it once, in [`Stateful::visit_state`]; a [`StateVisitor`] either
//! copies each number or replaces it. Gains, limits and models are no state: whoever keeps a state
//! keeps a digest of the configuration with it. No memory is copied as it lies, so that a state is
//! the same on every machine.
//!
//! ```
//! use trueweld_core::filter::{Biquad, Filter};
//! use trueweld_core::state::{StateError, StateVisitor, Stateful};
//!
//! /// Copies up to eight numbers.
//! struct Copied([f64; 8], usize);
//!
//! impl StateVisitor for Copied {
//!     fn visit(&mut self, number: &mut f64) -> Result<(), StateError> {
//!         *self.0.get_mut(self.1).ok_or(StateError::Length)? = *number;
//!         self.1 += 1;
//!         Ok(())
//!     }
//! }
//!
//! let mut filter = Biquad::low_pass(5.0, 0.012).unwrap();
//! filter.update(1.0);
//! let mut state = Copied([0.0; 8], 0);
//! filter.visit_state(&mut state)?;
//! assert_eq!(state.1, 2);
//! # Ok::<(), StateError>(())
//! ```

use crate::scalar::{Real, lit};
use crate::spatial::{Twist, Wrench};
use heapless::Deque;
use nalgebra::{SMatrix, Vector3};

/// Why a state cannot be taken out or put back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StateError {
    /// Something in it cannot give its state: a law of one's own that does not list it.
    Unsupported,
    /// It has more or fewer numbers than what it is put into.
    Length,
    /// A number that this place cannot have: a flag that is neither 0 nor 1, a count above its
    /// bound.
    Value,
}

impl core::fmt::Display for StateError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Unsupported => "a law or a controller does not give its state",
            Self::Length => "the state has another length than this configuration's",
            Self::Value => "the state holds a number that cannot be at its place",
        })
    }
}

impl core::error::Error for StateError {}

/// How a visit went.
pub type StateResult = Result<(), StateError>;

/// Copies the numbers of a state, or replaces them, in the order in which they come.
pub trait StateVisitor {
    /// The next number of the state.
    ///
    /// # Errors
    /// [`StateError::Length`] where there is no room for it, or none is left.
    fn visit(&mut self, number: &mut f64) -> StateResult;
}

/// Something with a state.
pub trait Stateful {
    /// Shows every number that changes from period to period. Where the visitor replaces them, an
    /// error may leave some replaced: the whole is then to be built anew.
    ///
    /// # Errors
    /// [`StateError`].
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult;
}

impl dyn StateVisitor + '_ {
    /// A scalar: `f32` and `f64` to the last bit.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn scalar<T: Real>(&mut self, value: &mut T) -> StateResult {
        let mut number = nalgebra::try_convert::<T, f64>(*value).ok_or(StateError::Value)?;
        self.visit(&mut number)?;
        *value = lit(number);
        Ok(())
    }

    /// A single-precision number of a type that has no other.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn single(&mut self, value: &mut f32) -> StateResult {
        let mut number = f64::from(*value);
        self.visit(&mut number)?;
        *value = number as f32;
        Ok(())
    }

    /// A count from 0 to `most`.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn count(&mut self, value: &mut usize, most: usize) -> StateResult {
        let mut number = *value as f64;
        self.visit(&mut number)?;
        let count = number as usize;
        if count as f64 != number || count > most {
            return Err(StateError::Value);
        }
        *value = count;
        Ok(())
    }

    /// A byte.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn byte(&mut self, value: &mut u8) -> StateResult {
        let mut count = usize::from(*value);
        self.count(&mut count, u8::MAX.into())?;
        *value = count as u8;
        Ok(())
    }

    /// A flag.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn flag(&mut self, value: &mut bool) -> StateResult {
        let mut count = usize::from(*value);
        self.count(&mut count, 1)?;
        *value = count == 1;
        Ok(())
    }

    /// A value that may be missing. `blank`: what it begins as where it was missing and comes.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn option<V>(
        &mut self,
        value: &mut Option<V>,
        blank: V,
        visit: impl FnOnce(&mut Self, &mut V) -> StateResult,
    ) -> StateResult {
        let mut is_there = value.is_some();
        self.flag(&mut is_there)?;
        if is_there {
            visit(self, value.get_or_insert(blank))?;
        } else {
            *value = None;
        }
        Ok(())
    }

    /// A queue of fixed room. `blank`: what its values begin as where there were fewer or more.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn queue<V: Copy, const N: usize>(
        &mut self,
        queue: &mut Deque<V, N>,
        blank: V,
        mut visit: impl FnMut(&mut Self, &mut V) -> StateResult,
    ) -> StateResult {
        let length = self.length(queue.len(), N)?;
        if length != queue.len() {
            queue.clear();
            // No more than there is room for.
            for _ in 0..length {
                let _ = queue.push_back(blank);
            }
        }
        queue.iter_mut().try_for_each(|value| visit(self, value))
    }

    /// A scalar that may be missing.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn scalar_option<T: Real>(&mut self, value: &mut Option<T>) -> StateResult {
        self.option(value, T::zero(), |visitor, value| visitor.scalar(value))
    }

    /// Scalars in their order.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn scalars<'v, T: Real>(
        &mut self,
        values: impl IntoIterator<Item = &'v mut T>,
    ) -> StateResult {
        values.into_iter().try_for_each(|value| self.scalar(value))
    }

    /// A vector or matrix, column by column.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn matrix<T: Real, const R: usize, const C: usize>(
        &mut self,
        value: &mut SMatrix<T, R, C>,
    ) -> StateResult {
        self.scalars(value.iter_mut())
    }

    /// A twist, angular part first.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn twist<T: Real>(&mut self, value: &mut Twist<T>) -> StateResult {
        self.pair(&mut value.angular, &mut value.linear)
    }

    /// A wrench, moment first.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn wrench<T: Real>(&mut self, value: &mut Wrench<T>) -> StateResult {
        self.pair(&mut value.moment, &mut value.force)
    }

    fn pair<T: Real>(&mut self, first: &mut Vector3<T>, second: &mut Vector3<T>) -> StateResult {
        self.matrix(first)?;
        self.matrix(second)
    }

    /// A list of fixed room that `count` values are in: its length, so that whoever owns it brings
    /// it to that length before its values are visited.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn length(&mut self, count: usize, most: usize) -> Result<usize, StateError> {
        let mut count = count;
        self.count(&mut count, most)?;
        Ok(count)
    }
}
