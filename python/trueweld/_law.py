"""What a law in Python is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, runtime_checkable

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

    Every run has a law of its own: a deep copy of the object. What a law raises ends the command.
    """

    def demand(self, readings: Readings) -> Correction:
        """The correction that is asked for in this control period."""


#: The name of a law of the library, several with + between them; a law in Python, a class of them, or
#: a function of the readings.
LawLike = str | Law | type[Law] | Callable[[Readings], Correction]
