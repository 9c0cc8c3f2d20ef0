"""Physical effects of one's own, for welds and for fits.

An effect is an expression at a port of the robot or of the process. It is stated as text, or as a
function of Python that is called once, with symbols: what it does with them becomes the expression,
which the simulator then evaluates without Python.

>>> def cable(link, link_rate, friction, stiffness):
...     return -(friction * np.tanh(link_rate / 0.001) + stiffness * link)
>>> drag = define("cable-drag", cable, port="link-torque", at="A1", parameters={
...     "friction": Parameter(value=0, low=0, high=500, unit="N·m", step=20),
...     "stiffness": Parameter(value=0, low=0, high=2e4, unit="N·m/rad", step=500),
... })
>>> model = drag.add_to("model.toml", "out/with-cable.toml")
>>> tw.diagnose(logs, model=model)

Ports, their variables and their units: docs/your-own-effect.md.
"""

from __future__ import annotations

import inspect
import json
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ._paths import StrPath, write_whole

__all__ = ["Effect", "Expression", "Parameter", "dahl", "define", "play", "sign", "step"]

# What NumPy calls a function, and what an expression does.
_FUNCTIONS = {
    np.abs: "abs",
    np.sign: "sign",
    np.sqrt: "sqrt",
    np.exp: "exp",
    np.log: "ln",
    np.sin: "sin",
    np.cos: "cos",
    np.tan: "tan",
    np.arcsin: "asin",
    np.arccos: "acos",
    np.arctan: "atan",
    np.sinh: "sinh",
    np.cosh: "cosh",
    np.tanh: "tanh",
    np.floor: "floor",
    np.minimum: "min",
    np.maximum: "max",
    np.arctan2: "atan2",
}
_OPERATORS = {
    np.add: "+",
    np.subtract: "-",
    np.multiply: "*",
    np.divide: "/",
    np.power: "^",
}


class Expression:
    """A symbol, or what was made of symbols. NumPy's functions take it."""

    __slots__ = ("text",)

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return f"Expression({self.text!r})"

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Expression:
        if method == "__call__" and not options:
            if ufunc in _OPERATORS:
                return _joined(_OPERATORS[ufunc], *inputs)
            if ufunc is np.negative:
                return -_of(inputs[0])
            if ufunc in _FUNCTIONS:
                return _called(_FUNCTIONS[ufunc], *inputs)
        known = ", ".join(sorted(of.__name__ for of in _FUNCTIONS))
        raise TypeError(f"an effect has no function {ufunc.__name__}; there are {known}")

    def __bool__(self) -> bool:
        raise TypeError("an effect cannot branch on what it reads; use trueweld.effects.step, which is 1 above 0")

    def __lt__(self, other: Any) -> bool:
        return bool(self)

    __le__ = __gt__ = __ge__ = __lt__

    def __float__(self) -> float:
        raise TypeError("an effect's function is called with symbols; use NumPy's functions instead of math's")

    def __add__(self, other: Any) -> Expression:
        return _joined("+", self, other)

    def __radd__(self, other: Any) -> Expression:
        return _joined("+", other, self)

    def __sub__(self, other: Any) -> Expression:
        return _joined("-", self, other)

    def __rsub__(self, other: Any) -> Expression:
        return _joined("-", other, self)

    def __mul__(self, other: Any) -> Expression:
        return _joined("*", self, other)

    def __rmul__(self, other: Any) -> Expression:
        return _joined("*", other, self)

    def __truediv__(self, other: Any) -> Expression:
        return _joined("/", self, other)

    def __rtruediv__(self, other: Any) -> Expression:
        return _joined("/", other, self)

    def __pow__(self, other: Any) -> Expression:
        return _joined("^", self, other)

    def __rpow__(self, other: Any) -> Expression:
        return _joined("^", other, self)

    def __neg__(self) -> Expression:
        return Expression(f"(-{self.text})")

    def __pos__(self) -> Expression:
        return self

    def __abs__(self) -> Expression:
        return _called("abs", self)


def _of(value: Any) -> Expression:
    if isinstance(value, Expression):
        return value
    number = float(value)
    return Expression(repr(number) if number >= 0 else f"({number!r})")


def _joined(operator: str, left: Any, right: Any) -> Expression:
    return Expression(f"({_of(left).text} {operator} {_of(right).text})")


def _called(name: str, *arguments: Any) -> Expression:
    return Expression(f"{name}({', '.join(_of(argument).text for argument in arguments)})")


def step(value: Any) -> Expression:
    """1 above 0, else 0."""
    return _called("step", value)


def sign(value: Any) -> Expression:
    """-1, 0 or 1."""
    return _called("sign", value)


def dahl(variable: Any, width: Any) -> Expression:
    """Friction that turns round over a way: from -1 to 1, over `width` after each reversal."""
    return _called("dahl", variable, width)


def play(variable: Any, width: Any) -> Expression:
    """Follows a variable behind a slack of `width` to either side."""
    return _called("play", variable, width)


@dataclass(frozen=True)
class Parameter:
    """A number of an effect.

    ``step``: the effect grows from nothing with it, and this is a small value; 0 as its value lets a
    fit decide. ``shape``: values that a fit may begin from, of one that shapes the effect.
    """

    value: float
    low: float
    high: float
    unit: str = ""
    step: float | None = None
    shape: Sequence[float] = ()
    meaning: str = ""


@dataclass(frozen=True)
class Effect:
    """An effect of one's own: made by :func:`define`."""

    id: str
    expression: str
    port: str
    at: str | None = None
    unit: str | None = None
    shows: str | None = None
    parameters: Mapping[str, Parameter] = field(default_factory=dict)

    def to_toml(self) -> str:
        """The effect as a model file has it."""
        lines = ["[[effect]]"]
        for key in ("id", "at", "port", "unit", "expression", "shows"):
            value = getattr(self, key)
            if value is not None:
                lines.append(f"{key} = {_text(value)}")
        for name, parameter in self.parameters.items():
            lines += ["", f"[effect.parameters.{name}]", f"value = {float(parameter.value)!r}"]
            if parameter.unit:
                lines.append(f"unit = {_text(parameter.unit)}")
            if parameter.meaning:
                lines.append(f"meaning = {_text(parameter.meaning)}")
            lines += [f"low = {float(parameter.low)!r}", f"high = {float(parameter.high)!r}"]
            if parameter.step is not None:
                lines.append(f"step = {float(parameter.step)!r}")
            if parameter.shape:
                lines.append(f"shape = {[float(value) for value in parameter.shape]!r}")
        return "\n".join(lines) + "\n"

    def add_to(self, model: StrPath, out: StrPath) -> Path:
        """Writes a model file with this effect added, beside what it was; gives the path of it.

        A file that this did not write is not written over.
        """
        model, out = Path(model), Path(out)
        head = "# A model with an effect added by trueweld in Python."
        if out.exists() and not out.read_text(encoding="utf-8").startswith(head):
            raise FileExistsError(f"{out}: there is a file that this did not write; expected another name")
        text = model.read_text(encoding="utf-8")
        try:
            given = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise ValueError(f"{model}: {error}") from error

        # Paths start from the model file's folder.
        def moved(line: re.Match[str]) -> str:
            path = (model.resolve().parent / given[line[2]]).resolve()
            return line[1] + _text(str(path))

        text = re.sub(r"""^((robot|process)\s*=\s*)("[^"\n]*"|'[^'\n]*')""", moved, text, flags=re.MULTILINE)
        # What `improve` measured is of the model as it was: its table, with those within it, ends at the next.
        text = re.sub(r"^\[posterior\b.*?(?=^\[(?!\[?posterior\b)|\Z)", "", text, flags=re.MULTILINE | re.DOTALL)
        out.parent.mkdir(parents=True, exist_ok=True)
        write_whole(out, f"{head}\n{text.rstrip()}\n\n{self.to_toml()}")
        return out


def define(
    id: str,
    expression: str | Callable[..., Any],
    *,
    port: str,
    at: str | None = None,
    unit: str | None = None,
    shows: str | None = None,
    parameters: Mapping[str, Parameter],
) -> Effect:
    """An effect of one's own.

    ``expression``: text, or a function whose arguments have the names of the port's variables and of
    the parameters. ``port``: what it adds to; ``at``: the joint, such as A1, where the port is one of
    a joint. Whether the names are right is said where the model file is read (:func:`trueweld.check`).
    """
    if callable(expression):
        names = list(inspect.signature(expression).parameters)
        made = expression(**{name: Expression(name) for name in names})
        expression = _of(made).text
    return Effect(id, expression, port, at, unit, shows, dict(parameters))


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False)
