"""Results as objects with the names of their JSON."""

from __future__ import annotations

import html
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._paths import write_whole
from ._schema import LEFT_OUT, LEFT_OUT_LISTS
from ._table import Table, Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SHOWN_KEYS = 12


class Record:
    """A part of a result: its names are those of the JSON, as attributes and as keys.

    ``run.lateral_m.rms`` is ``run["lateral_m"]["rms"]``; the unit is at the end of a name. What does
    not exist is None, of a list that the JSON leaves out empty. A record cannot be changed.
    """

    __slots__ = ("_values",)
    _values: Mapping[str, Any]

    def __init__(self, values: Mapping[str, Any]) -> None:
        object.__setattr__(self, "_values", values)

    def __getattr__(self, name: str) -> Any:
        # While an object is unpickled it has no values yet.
        if name == "_values":
            raise AttributeError(name)
        if name in self._values:
            return self[name]
        if name in LEFT_OUT_LISTS:
            return []
        if name in LEFT_OUT:
            return None
        known = ", ".join(self._values)
        raise AttributeError(f"there is no {name!r} here; there are {known}", name=name, obj=self)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("a result cannot be changed")

    def __getitem__(self, key: str) -> Any:
        return _shown(self._values[key])

    def __contains__(self, key: object) -> bool:
        return key in self._values

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __dir__(self) -> list[str]:
        return [*object.__dir__(self), *self._values]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Record) and self._values == other._values

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        keys = list(self._values)
        shown = ", ".join(f"{key}={_brief(self._values[key])}" for key in keys[:_SHOWN_KEYS])
        more = f", … {len(keys) - _SHOWN_KEYS} more" if len(keys) > _SHOWN_KEYS else ""
        return f"{type(self).__name__}({shown}{more})"

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (self._values,))

    def to_dict(self) -> dict[str, Any]:
        """The same as plain dictionaries, lists, numbers and texts: a copy."""
        copied = json.loads(json.dumps(self._values))
        assert isinstance(copied, dict)
        return copied


def _shown(value: Any) -> Any:
    if isinstance(value, dict):
        return Record(value)
    if isinstance(value, list):
        return [_shown(item) for item in value]
    return value


def _brief(value: Any) -> str:
    if isinstance(value, dict):
        return "{…}"
    if isinstance(value, list) and len(value) > 6:
        return f"[{len(value)}]"
    if isinstance(value, list):
        return "[" + ", ".join(_brief(item) for item in value) + "]"
    return f"{value:.6g}" if isinstance(value, float) else repr(value)


class Result(Record):
    """What a command has found, in every form that the program has for it."""

    __slots__ = ("_forms",)
    _forms: dict[str, Any]

    def __init__(self, json_text: str, forms: dict[str, Any]) -> None:
        super().__init__(json.loads(json_text))
        object.__setattr__(self, "_forms", {**forms, "json": json_text})

    def __getattr__(self, name: str) -> Any:
        if name == "_forms":
            raise AttributeError(name)
        return super().__getattr__(name)

    @property
    def sentence(self) -> str:
        """The finding in a sentence or two."""
        return str(self._values.get("sentence") or self._forms["headline"] or self.text.strip())

    @property
    def text(self) -> str:
        """What the program prints."""
        return str(self._forms["text"])

    @property
    def status(self) -> int:
        """Status with which the program ends: 0, or 1 where what was asked for is not reached."""
        return int(self._forms["status"])

    @property
    def warnings(self) -> list[str]:
        """Values outside their plausible range, and what else a reader should know of the inputs."""
        return list(self._forms["warnings"])

    @property
    def table(self) -> Table | None:
        """Every sample behind the result, as ``--samples`` writes them; None where it has none."""
        table: Table | None = self._forms["table"]
        return table

    @property
    def trajectories(self) -> list[Trajectory]:
        """The simulated welds with every signal as an array, in the order of ``runs``."""
        return [] if self.table is None else self.table.runs

    def to_json(self) -> str:
        """The text that ``--json`` writes, byte for byte."""
        return str(self._forms["json"])

    def to_html(self) -> str:
        """The page that ``--html`` writes: one file that needs no network."""
        page = self._forms["page"]
        if callable(page):
            page = self._forms["page"] = page()
        if page is None:
            raise ValueError("this result is text alone; there is no page of it")
        return str(page)

    def save(self, path: str | Path) -> Path:
        """Writes the result: as a page where the name ends in .html, as JSON where in .json."""
        path = Path(path)
        forms: dict[str, Callable[[], str]] = {".html": self.to_html, ".json": self.to_json, ".txt": lambda: self.text}
        if path.suffix not in forms:
            expected = ", ".join(forms)
            raise ValueError(f"{path}: expected a name that ends in one of {expected}")
        write_whole(path, forms[path.suffix]())
        return path

    def plot(self, **options: Any) -> Figure:
        """A picture of the result with matplotlib, which the extra ``plot`` brings."""
        from . import _plot

        return _plot.plot(self, **options)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.sentence}>"

    def __str__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        """The page of the command, in a frame of its own: its style stays there."""
        if self._forms["page"] is None:
            return f"<pre>{html.escape(self.text)}</pre>"
        page = html.escape(self.to_html(), quote=True)
        return (
            f'<iframe srcdoc="{page}" style="width:100%;height:640px;border:1px solid #ccc" '
            'sandbox="allow-scripts"></iframe>'
        )

    def __reduce__(self) -> tuple[Any, ...]:
        page = None if self._forms["page"] is None else self.to_html()
        return (type(self), (self.to_json(), {**self._forms, "page": page}))
