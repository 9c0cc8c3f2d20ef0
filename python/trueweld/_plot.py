"""Pictures of results with matplotlib: the one that the command's page begins with."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ._extras import needed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ._records import Result

# Okabe and Ito's set, told apart by the colour-blind: as on the pages.
_COLOURS = ["#d55e00", "#0072b2", "#cc79a7", "#bea000", "#785a28", "#56b4e9", "#1e1e1e"]
_LIMIT = "#008c64"
_MILLI = 1e3

_HEIGHT_IN = 3.6
_BAR_IN = 0.24
# Names of bars take room beside a title.
_TITLE_COLUMNS, _TITLE_COLUMNS_OF_BARS = 95, 68

_MOVING = {"feed rising", "steady", "feed falling"}


def plot(result: Result, ax: Axes | None = None) -> Figure:
    """Draws a result into `ax`, or into a new figure, and gives the figure."""
    pyplot = needed("matplotlib.pyplot", "plot")
    name = str(result["schema"]).split("/")[0]
    if name in _WITHOUT:
        raise NotImplementedError(_WITHOUT[name])
    draw = _PICTURES[name]
    given = ax
    if ax is None:
        figure, ax = pyplot.subplots(figsize=(8, _HEIGHT_IN), layout="constrained")
        # It is shown by its value; the backend of a notebook would show it again.
        pyplot.close(figure)
    bars = draw(result, ax)
    columns = _TITLE_COLUMNS if bars is None else _TITLE_COLUMNS_OF_BARS
    ax.set_title(textwrap.fill(result.sentence, columns), loc="left", fontsize="medium")
    figure = cast("Figure", ax.get_figure(root=True))
    if given is None and bars is not None:
        figure.set_size_inches(8, max(_HEIGHT_IN, 1.2 + _BAR_IN * bars))
    return figure


def _weld(result: Result, ax: Axes) -> None:
    tolerance = None
    for k, run in enumerate(result.trajectories):
        moving = np.array([phase in _MOVING for phase in run.phase])
        lateral = run.deviation_m[:, 1]
        label = run.law if run.law != "none" else "no compensation"
        ax.plot(_MILLI * run.path_m[moving], _MILLI * lateral[moving], color=_COLOURS[k % 7], lw=1, label=label)
    for run in result.runs:
        tolerance = run.half_pin_m
    if tolerance is not None:
        ax.axhspan(-_MILLI * tolerance, _MILLI * tolerance, color=_LIMIT, alpha=0.1, label="tolerance")
    ax.set(xlabel="position on the seam, mm", ylabel="lateral deviation, mm")
    ax.legend(frameon=False)


def _step(result: Result, ax: Axes) -> None:
    for k, run in enumerate(result.trajectories):
        ax.plot(run.time_s, -run.force_n[:, 2] / _MILLI, color=_COLOURS[k % 7], lw=1, label=run.controller)
    ax.plot(run.time_s, run.push_desired_n / _MILLI, color="#6e6e6e", lw=1, ls="--", label="asked for")
    ax.set(xlabel="time, s", ylabel="push, kN")
    ax.legend(frameon=False)


def _bars(ax: Axes, names: list[str], values: list[Any], label: str) -> int:
    """Horizontal bars with their values; gives how many."""
    numbers = [np.nan if value is None else value for value in values]
    bars = ax.barh(names, numbers, color=_COLOURS[1])
    ax.bar_label(bars, labels=[_number(value) for value in values], padding=3)
    ax.invert_yaxis()
    ax.margins(x=0.12)
    ax.set(xlabel=label)
    return len(names)


def _number(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{value:.0f}" if value >= 1000 else f"{value:.3g}"


def _noise_floor(ax: Axes) -> None:
    ax.axvline(1.0, color=_LIMIT, lw=1, ls="--")


def _compare(result: Result, ax: Axes) -> int:
    logs = result.logs
    _noise_floor(ax)
    return _bars(ax, [log.name for log in logs], [log.score for log in logs], "score; 1 is the noise floor")


def _diagnose(result: Result, ax: Axes) -> int:
    candidates = result.candidates[:6]
    names = [" and ".join(f"{of.effect} {of.at}".strip() for of in one.effects) for one in candidates]
    return _bars(ax, names, [one.probability for one in candidates], "probability")


def _improve(result: Result, ax: Axes) -> int:
    names = []
    for k, step in enumerate(result.steps):
        added = " and ".join(f"{of.effect} {of.at}".strip() for of in step.added)
        names.append(f"+ {added}" if added else ("recalibrated" if k else "as given"))
    values = [step.holdout_score for step in result.steps]
    _noise_floor(ax)
    return _bars(ax, names, values, "score where nothing was fitted; 1 is the noise floor")


def _certify(result: Result, ax: Axes) -> int:
    judged = [of for of in result.requirements if of.achieved is not None and of.limit]
    names = [f"{of.name}, {of.case}" for of in judged]
    shares = [of.achieved / of.limit for of in judged]
    colours = [_COLOURS[1] if of["pass"] else _COLOURS[0] for of in judged]
    ax.barh(names, shares, color=colours)
    ax.axvline(1.0, color=_LIMIT, lw=1, ls="--")
    ax.invert_yaxis()
    ax.set(xlabel="achieved, of the limit")
    return len(judged)


def _compare_laws(result: Result, ax: Axes) -> None:
    sweep = result.sweeps[0]
    for k, of in enumerate(sweep.results):
        points = [(p[sweep.varied], p.lateral_rms_m) for p in of.points if p.lateral_rms_m is not None]
        if points:
            x, y = zip(*points, strict=True)
            ax.plot(x, _MILLI * np.array(y), "o-", color=_COLOURS[k % 7], lw=1, ms=3, label=of.law)
    ax.set(xlabel=sweep.varied, ylabel="lateral deviation, RMS, mm", yscale="log")
    ax.legend(frameon=False, fontsize="small")


def _record(result: Result, ax: Axes) -> int:
    """When each log was recorded."""
    for k, log in enumerate(result.logs):
        first, last = log.time_s[0], log.time_s[-1]
        ax.barh(log.name, last - first, left=first, color=_COLOURS[k % 7])
        ax.text(last, k, f"  {log.kind}", va="center", fontsize="small")
    ax.invert_yaxis()
    ax.margins(x=0.2)
    ax.set(xlabel="time, s")
    return len(result.logs)


def _plan(result: Result, ax: Axes) -> int:
    """The log in which each effect shows best, with the size from which it does."""
    logs = [log.name for log in result.logs]
    rows = [(f"{of.effect} {of.at}".strip(), of) for of in result.shown]
    for k, (_, of) in enumerate(rows):
        if of.best_log in logs:
            x = logs.index(of.best_log)
            ax.plot(x, k, "o", color=_COLOURS[1])
            unit = "" if of.unit == "1" else f" {of.unit}"
            ax.text(x + 0.1, k, f"from {_number(of.value)}{unit}", va="center", fontsize="small")
    ax.set_xticks(range(len(logs)), logs, rotation=30, ha="right")
    ax.set_yticks(range(len(rows)), [name for name, _ in rows])
    label = f"log that shows it best; {len(result.not_shown)} more effects are shown by none"
    ax.set(xlim=(-0.5, len(logs) + 0.5), ylim=(len(rows) - 0.5, -0.5), xlabel=label)
    return len(rows)


def _identify(result: Result, ax: Axes) -> int:
    """Each number with its interval, as a share of what the model has, or of itself."""
    found = [of for of in result.parameters if of.value]
    for k, of in enumerate(found):
        unit = of.given or of.value
        ends = [of.value if end is None else end for end in (of.low, of.high)]
        colour = _COLOURS[1] if of.identifiable else "#6e6e6e"
        ax.plot([end / unit for end in ends], [k, k], color=colour)
        ax.plot(of.value / unit, k, "o", color=colour)
    names = [f"{of.name} {of.at}".strip() + f" {_number(of.value)} {of.unit}" for of in found]
    ax.set_yticks(range(len(found)), names)
    ax.invert_yaxis()
    ax.axvline(1.0, color="#6e6e6e", lw=1, ls="--")
    ax.set(xlabel="identified, with its interval; 1 is what the model has, or else the number itself")
    return len(found)


def _identify_plan(result: Result, ax: Axes) -> int:
    names = [of.at for of in result.expected]
    places = np.arange(len(names))
    for k, (key, label) in enumerate((("half_share", "planned"), ("by_hand_half_share", "by hand"))):
        shares = [np.nan if of[key] is None else 100 * of[key] for of in result.expected]
        ax.barh(places + 0.4 * k, shares, height=0.4, color=_COLOURS[1 - k], label=label)
    ax.set_yticks(places + 0.2, names)
    ax.invert_yaxis()
    ax.set(xlabel="half the expected interval of the stiffness, %")
    ax.legend(frameon=False)
    return 2 * len(names)


def _register(result: Result, ax: Axes) -> int:
    names = [", ".join(of.logs) for of in result.trackers]
    left = [None if of.left_m is None else _MILLI * of.left_m for of in result.trackers]
    return _bars(ax, names, left, "distance that is left between seen and expected, mm")


def _tune(result: Result, ax: Axes) -> int:
    tuned = [*result.controllers, *result.laws]
    widest = [of.weld.lateral_max_m if of.weld else None for of in tuned]
    millimetres = [None if of is None else _MILLI * of for of in widest]
    return _bars(ax, [of.name for of in tuned], millimetres, "largest lateral deviation of a weld, mm")


def _study_layout(result: Result, ax: Axes) -> None:
    places = [of.placement for of in result.front]
    shown = ax.scatter(
        [of.x_m for of in places], [of.z_m for of in places], c=[of.share for of in result.front], cmap="viridis_r"
    )
    cast("Figure", ax.get_figure(root=True)).colorbar(shown, ax=ax, label="largest share of a limit")
    for name, of, mark in (("as filed", result.filed, "x"), ("chosen", result.chosen, "*")):
        if of is not None:
            place = of.statics.placement
            ax.plot(place.x_m, place.z_m, mark, color=_COLOURS[0], ms=12, ls="none", label=name)
    ax.set(xlabel="x, m", ylabel="z, m")
    ax.legend(frameon=False)


def _study_limits(result: Result, ax: Axes) -> int:
    names, shares = [], []
    for place in result.places:
        at = place.placement
        where = f", x {at.x_m:.2f} m, z {at.z_m:.2f} m" if len(result.places) > 1 else ""
        for of in place.limits:
            names.append(f"{of.driven}{where}")
            shares.append(None if of.largest is None or not of.nominal else of.largest / of.nominal)
    return _bars(ax, names, shares, "largest that keeps the requirements; 1 is that of the weld")


def _study_paper(result: Result, ax: Axes) -> None:
    for k, weld in enumerate(dict.fromkeys(of.weld for of in result.envelopes)):
        points = [(of.x_m, of.envelope_n) for of in result.envelopes if of.weld == weld and of.envelope_n is not None]
        if points:
            x, push = zip(*points, strict=True)
            ax.plot(x, np.array(push) / _MILLI, "o-", color=_COLOURS[k % 7], lw=1, ms=3, label=weld)
    ax.set(xlabel="x of the seam, m", ylabel="largest push that the arm holds, kN")
    ax.legend(frameon=False)


def _study_sensitivity(result: Result, ax: Axes) -> int:
    indices = sorted(result.figures[0].indices, key=lambda of: -of.total.value)
    for k, of in enumerate(indices):
        ax.barh(of.input, of.total.value, color=_COLOURS[1])
        ax.plot([of.total.low, of.total.high], [k, k], color=_COLOURS[6], lw=1)
    ax.invert_yaxis()
    ax.set(xlabel=f"share of the spread of {result.figures[0].figure}, with its interactions")
    return len(indices)


def _improve_fleet(result: Result, ax: Axes) -> int:
    """Each unit's values with their intervals, over the largest of the units'."""
    units = [of.unit for of in result.units]
    rows = [(of, parameter) for of in [*result.effects, *result.calibration] for parameter in of.parameters]
    names: list[str] = []
    for k, unit in enumerate(units):
        ax.plot([], [], "o", color=_COLOURS[k % 7], ms=4, label=unit)
    for of, parameter in rows:
        values = [value for value in parameter.units if value is not None]
        scale = max((abs(value.value) for value in values), default=0.0) or 1.0
        if not values:
            continue
        row = len(names)
        names.append(f"{of.effect}{f' at {of.at}' if of.at else ''}: {parameter.name}")
        for k, value in enumerate(parameter.units):
            if value is None:
                continue
            # Units of one row stand below each other.
            at = row + 0.6 * ((k + 0.5) / len(units) - 0.5)
            ends = np.clip([value.low / scale, value.high / scale], -2.0, 2.0)
            ax.plot(ends, [at, at], color=_COLOURS[k % 7], lw=1)
            ax.plot(value.value / scale, at, "o", color=_COLOURS[k % 7], ms=4)
    ax.set_yticks(range(len(names)), names)
    ax.invert_yaxis()
    ax.axvline(0.0, color="#6e6e6e", lw=0.5)
    ax.set(xlabel="value and 95 % interval, over the largest of the units'", xlim=(-2.05, 2.05))
    ax.legend(frameon=False)
    return 2 * len(names)


_PICTURES: dict[str, Callable[[Result, Axes], int | None]] = {
    "weld-result": _weld,
    "step-result": _step,
    "compare": _compare,
    "diagnose": _diagnose,
    "improve": _improve,
    "improve-fleet": _improve_fleet,
    "certify": _certify,
    "compare-laws": _compare_laws,
    "record": _record,
    "plan": _plan,
    "identify": _identify,
    "identify-plan": _identify_plan,
    "register": _register,
    "tune": _tune,
    "study-layout": _study_layout,
    "study-limits": _study_limits,
    "study-paper": _study_paper,
    "study-sensitivity": _study_sensitivity,
}

# Results that are words, and why there is nothing to draw.
_WITHOUT = {
    "check": "there is no picture of a check: it says of each file whether it is in order",
    "import-log": "there is no picture of an import: it says how each column is read",
    "compare-logs": "there is no picture of two logs but on the page: show the result, or write its page",
    "replay": "there is no picture of a replay: it says in which period a core first differs",
}
