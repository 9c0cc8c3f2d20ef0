"""What a law in Python is."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from ._core import Readings

#: A correction: x, y, z in m, then the rotation about them in rad, axes of the weld frame W (x along
#: the weld, y across it, z into the material). The part along z is not used: depth is the force
#: loop's.
Correction = npt.NDArray[np.float64] | Sequence[float]


@runtime_checkable
class Law(Protocol):
    """A compensation law: any object with this method; it need not inherit from this class.

    A law may also have:

    ``reset()``
        the start of a weld: forgets what belongs to the last one;
    ``freeze()``
        stops learning what would stay from weld to weld;
    ``name``
        what results call it, after ``python:`` (default: the name of its class);
    ``needs_seam_sensor``, ``needs_passes``
        true where it is no use without a seam sensor, or learns from one weld to the next;
    ``outer_integral``
        a share above 0 where the following error of the position loop is to be removed on top of it:
        the integral of the laws of the library that are not fed by the load, at this share of its
        rate across the seam. 1.0 with a seam sensor in the law; 0.4 without.

    ``__getstate__()`` and ``__setstate__(state)``
        what it keeps from period to period, for a state of a :class:`Simulation` (default: its
        attributes); it is pickled. A function keeps nothing: its copies share what it changes.

    Every run has a law of its own: a deep copy of the object. What a law raises ends the command.
    """

    def demand(self, readings: Readings) -> Correction:
        """The correction that is asked for in this control period."""


#: The name of a law of the library, several with + between them; a law in Python, a class of them, or
#: a function of the readings.
LawLike = str | Law | type[Law] | Callable[[Readings], Correction]


def state_of(law: Any) -> bytes:
    """What a law keeps from period to period, without its class."""
    return pickle.dumps(law.__getstate__())


def restore(law: Any, state: bytes) -> None:
    """Has a law keep what :func:`state_of` gave of it."""
    kept = pickle.loads(state)
    if hasattr(law, "__setstate__"):
        law.__setstate__(kept)
        return
    # As the default of `__getstate__` gives it: attributes; with slots a pair of attributes and slots.
    attributes, slots = kept if isinstance(kept, tuple) else (kept, None)
    if hasattr(law, "__dict__"):
        vars(law).clear()
        vars(law).update(attributes or {})
    for name, value in (slots or {}).items():
        setattr(law, name, value)
