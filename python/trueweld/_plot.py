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
_TITLE_COLUMNS = 95

_MOVING = {"feed rising", "steady", "feed falling"}


def plot(result: Result, ax: Axes | None = None) -> Figure:
    """Draws a result into `ax`, or into a new figure, and gives the figure."""
    pyplot = needed("matplotlib.pyplot", "plot")
    name = str(result["schema"]).split("/")[0]
    draw = _PICTURES.get(name)
    if draw is None:
        known = ", ".join(_PICTURES)
        raise NotImplementedError(f"there is no picture of {name}; the page has some (there are pictures of {known})")
    title = textwrap.fill(result.sentence, _TITLE_COLUMNS)
    if ax is not None:
        draw(result, ax)
        ax.set_title(title, loc="left", fontsize="medium")
        return cast("Figure", ax.get_figure(root=True))
    figure, ax = pyplot.subplots(figsize=(8, _HEIGHT_IN), layout="constrained")
    bars = draw(result, ax)
    ax.set_title(title, loc="left", fontsize="medium")
    if bars is not None:
        figure.set_size_inches(8, max(_HEIGHT_IN, 1.2 + _BAR_IN * bars))
    # It is shown by its value; the backend of a notebook would show it again.
    pyplot.close(figure)
    return cast("Figure", figure)


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


_PICTURES: dict[str, Callable[[Result, Axes], int | None]] = {
    "weld-result": _weld,
    "step-result": _step,
    "compare": _compare,
    "diagnose": _diagnose,
    "improve": _improve,
    "certify": _certify,
    "compare-laws": _compare_laws,
}
