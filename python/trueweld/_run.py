"""A command of the program in this process."""

from __future__ import annotations

import operator
import os
import re
import sys
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from . import _core, _results
from ._errors import InputWarning
from ._records import Result
from ._table import Table

Progress = Callable[[str, float], object]

# Shorter work is done before anybody has read of it.
_SHOWN_AFTER_S = 1.0


def call(
    names: Sequence[str],
    options: Mapping[str, Any],
    *,
    positional: Sequence[str] = (),
    joined: Sequence[str] = (),
) -> Any:
    """Runs a command with its options by name.

    ``positional``: options that the command line has without a flag; ``joined``: lists that it has
    with commas. Gives a result; of a command that has none what the program prints.
    """
    options = dict(options)
    progress = options.pop("progress", None)
    law_file = options.pop("law_file", None)
    laws: dict[str, Any] = {}
    flags: list[str] = []
    behind: list[str] = []
    for name, value in options.items():
        if value is None or value is False:
            continue
        flag = "--" + name.rstrip("_").replace("_", "-")
        if value is True:
            flags.append(flag)
            continue
        several = isinstance(value, (list, tuple))
        values = [_word(one, laws) for one in (value if several else [value])]
        if name in positional:
            behind += values
        elif name in joined:
            flags.append(f"{flag}={','.join(values)}")
        else:
            flags += [f"{flag}={one}" for one in values]
    arguments = [*names, *flags, *(["--", *behind] if behind else [])]
    with _Shown(progress) as told:
        outcome = _core.run_command(arguments, list(laws.items()), law_file, told)
    for warning in outcome.warnings:
        warnings.warn(warning, InputWarning, stacklevel=3)
    if not outcome.results:
        return outcome.text
    return _result(outcome)


def _word(value: Any, laws: dict[str, Any]) -> str:
    """A value as the command line has it; a law by a name of its own."""
    if isinstance(value, bool):
        raise TypeError(f"expected a value, and it is {value}")
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if not callable(value) and hasattr(value, "__index__"):
        return str(operator.index(value))
    if not callable(value) and hasattr(value, "__float__"):
        return repr(float(value))
    name = law_name(value)
    if laws.setdefault(name, value) is not value:
        raise ValueError(f"two laws are called {name}; expected an attribute `name` that tells them apart")
    return name


def law_name(law: Any) -> str:
    """The name of a law in Python in results: python:NAME."""
    name = getattr(law, "name", None)
    if not isinstance(name, str):
        name = getattr(law, "__name__", None) or type(law).__name__
    name = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", name).lower()
    return "python:" + (re.sub(r"[^a-z0-9]+", "-", name).strip("-") or "law")


def _result(outcome: Any) -> Result:
    found = outcome.results[-1]
    of = _results.CLASSES.get(found.schema.split("/")[0], Result)
    return of(
        found.json,
        {
            "headline": found.headline,
            "page": found.page if found.headline is not None else None,
            "table": None if found.samples is None else Table(found.samples),
            "status": outcome.status,
            "text": outcome.text,
            "warnings": outcome.warnings,
        },
    )


class _Shown:
    """Shows progress as one line, where a person looks: at a terminal or in a notebook."""

    def __init__(self, progress: Progress | bool | None) -> None:
        self._own = progress if callable(progress) else None
        self._is_shown = progress is True or (progress is None and _is_watched())
        self._since = time.monotonic()
        self._width = 0

    def __enter__(self) -> Progress | None:
        return self._own or (self._show if self._is_shown else None)

    def __exit__(self, *_: object) -> None:
        if self._width:
            print("\r" + " " * self._width + "\r", end="", file=sys.stderr, flush=True)

    def _show(self, label: str, share: float) -> None:
        spent = time.monotonic() - self._since
        if spent < _SHOWN_AFTER_S:
            return
        left = f", {spent / share - spent:.0f} s left" if share > 0.02 else ""
        line = f"{label} {100 * share:.0f} %{left}"
        print("\r" + line.ljust(self._width), end="", file=sys.stderr, flush=True)
        self._width = max(self._width, len(line))


def _is_watched() -> bool:
    return "ipykernel" in sys.modules or (sys.stderr is not None and sys.stderr.isatty())
