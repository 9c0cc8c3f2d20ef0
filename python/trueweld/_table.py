"""Every sample of a result: columns, arrays by joint, and tables for other packages."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._extras import needed

if TYPE_CHECKING:
    import pandas
    import polars
    import xarray

_Array = npt.NDArray[np.float64]

# What stands between a signal's name and its unit, and which row of signals it is one of.
_PARTS = {
    "joint": ("a1", "a2", "a3", "a4", "a5", "a6"),
    "axis": ("x", "y", "z"),
    "rotation": ("rx", "ry", "rz"),
    "direction": ("longitudinal", "lateral", "depth"),
}
_PART = re.compile(r"^(?P<name>.+)_(?P<part>a[1-6]|r?[xyz]|longitudinal|lateral|depth)_(?P<unit>[a-z_]+)$")


class Table:
    """A table with a row for every sample.

    ``table["time_s"]`` is a column: of numbers an array over the memory of the result, which cannot
    be written; of words a list. ``table.runs`` are the rows of each simulated weld as a
    :class:`Trajectory`. pandas, Polars, PyArrow and DuckDB take the table as it is
    (``polars.DataFrame(table)``), by the Arrow PyCapsule interface.
    """

    def __init__(self, table: Any) -> None:
        self._table = table

    @property
    def names(self) -> list[str]:
        """Names of the columns, with the unit at their end."""
        return list(self._table.names)

    def __len__(self) -> int:
        return len(self._table)

    def __getitem__(self, name: str) -> Any:
        return self._table[name]

    def __contains__(self, name: object) -> bool:
        return name in self._table.names

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __repr__(self) -> str:
        return f"<Table: {len(self)} rows, {len(self.names)} columns>"

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        return self._table.__arrow_c_stream__(requested_schema)

    @property
    def runs(self) -> list[Trajectory]:
        """The simulated welds, in the order of the result's runs; none where it has other samples."""
        words = [word for word in ("weld", "controller", "law") if word in self]
        if "time_s" not in self or len(words) != 3:
            return []
        return [
            Trajectory(self._table, dict(zip(words, of, strict=True)), first, end)
            for of, first, end in self._table.sections(words)
        ]

    def to_numpy(self) -> dict[str, Any]:
        """The columns by name; numbers as arrays of NumPy without a copy."""
        return {name: self[name] for name in self.names}

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame of pandas, which the extra ``pandas`` brings."""
        frame: pandas.DataFrame = needed("pandas", "pandas").DataFrame(self.to_numpy())
        return frame

    def to_polars(self) -> polars.DataFrame:
        """A data frame of Polars, which the extra ``polars`` brings."""
        frame: polars.DataFrame = needed("polars", "polars").DataFrame(self)
        return frame

    def __reduce__(self) -> tuple[Any, ...]:
        columns = {
            name: np.asarray(values) if isinstance(values, np.ndarray) else list(values)
            for name, values in self.to_numpy().items()
        }
        return (_unpickled, (columns,))


def _unpickled(columns: dict[str, Any]) -> Table:
    from ._core import ResultTable

    return Table(ResultTable.from_columns(list(columns.items())))


class Trajectory:
    """One simulated weld: a row for every control period.

    A signal is an attribute. ``time_s`` and ``path_m`` are of shape (time,); ``link_rad``,
    ``motor_rad`` and ``torque_nm`` of shape (time, joint); ``deviation_m`` of shape (time, direction):
    longitudinal, lateral, depth. :attr:`signals` lists them all. Arrays are C-contiguous; an array of
    several columns is put together once and kept.
    """

    def __init__(self, table: Any, words: dict[str, str], first: int, end: int) -> None:
        self._table, self._first, self._end = table, first, end
        self.weld, self.controller, self.law = words["weld"], words["controller"], words["law"]
        self._groups = _groups(table.names)
        self._kept: dict[str, _Array] = {}

    @property
    def signals(self) -> list[str]:
        """Names of the signals."""
        return list(self._groups)

    @property
    def phase(self) -> list[str]:
        """Where the weld is in its program, in words, one a row."""
        return list(self._table["phase"][self._first : self._end])

    def __len__(self) -> int:
        return self._end - self._first

    def __getattr__(self, name: str) -> _Array:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self[name]
        except KeyError:
            known = ", ".join(self._groups)
            raise AttributeError(f"there is no signal {name!r}; there are {known}", name=name, obj=self) from None

    def __getitem__(self, name: str) -> _Array:
        _, columns = self._groups[name]
        if len(columns) == 1:
            column: _Array = self._table[columns[0]][self._first : self._end]
            return column
        if name not in self._kept:
            self._kept[name] = self._table.matrix(columns, self._first, self._end)
        return self._kept[name]

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._groups]

    def __repr__(self) -> str:
        return f"<Trajectory: {self.weld}, {self.law}, {len(self)} rows>"

    def to_xarray(self) -> xarray.Dataset:
        """A data set of xarray, which the extra ``xarray`` brings, over time, joint and direction."""
        data = {}
        for name, (dimension, _) in self._groups.items():
            dimensions = ("time",) if dimension is None else ("time", dimension)
            data[name] = (dimensions, self[name])
        used = {dimension for dimension, _ in self._groups.values() if dimension}
        coordinates: dict[str, Any] = {name: list(_PARTS[name]) for name in used}
        coordinates["time"] = self["time_s"]
        about = {"weld": self.weld, "controller": self.controller, "law": self.law}
        found: xarray.Dataset = needed("xarray", "xarray").Dataset(data, coords=coordinates, attrs=about)
        return found


def _groups(names: list[str]) -> dict[str, tuple[str | None, list[str]]]:
    """Signals by name, each with what its columns are told apart by."""
    words = {"weld", "controller", "law", "phase", "fault"}
    found: dict[str, tuple[str | None, list[str]]] = {}
    for name in names:
        if name in words:
            continue
        match = _PART.match(name)
        signal, dimension = name, None
        if match:
            signal = f"{match['name']}_{match['unit']}"
            dimension = next(of for of, parts in _PARTS.items() if match["part"] in parts)
        if signal in found and found[signal][0] == dimension:
            found[signal][1].append(name)
        else:
            found[signal] = (dimension, [name])
    return found
