"""Laws and effects in Python."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trueweld as tw
from trueweld import effects

pytestmark = pytest.mark.filterwarnings("ignore::trueweld.InputWarning")


class SeamFollower:
    """Feed-forward, and the integral of what the seam sensor sees across the seam."""

    needs_seam_sensor = True

    def __init__(self, rate_rad_s: float = 2.0) -> None:
        self.rate_rad_s = rate_rad_s
        self.reset()

    def reset(self) -> None:
        self.across_m = 0.0

    def demand(self, readings: tw.Readings) -> np.ndarray:
        if np.isfinite(readings.lateral_m):
            self.across_m -= self.rate_rad_s * readings.period_s * readings.lateral_m
        demand = readings.feed_forward()
        demand[1] += self.across_m
        return demand


def test_a_law_in_python_welds_as_the_same_law_in_rust(place: Path) -> None:
    feed_forward = tw.weld(weld="short.toml", compensator="feed-forward")

    class FeedForward:
        # As that of the library has it.
        outer_integral = 0.4

        def demand(self, readings: tw.Readings) -> np.ndarray:
            return readings.feed_forward()

    for own in (FeedForward, FeedForward()):
        welded = tw.weld(weld="short.toml", compensator=own)
        assert welded.runs[0].compensator == "python:feed-forward"
        runs = [of.trajectories[0].deviation_m for of in (feed_forward, welded)]
        assert np.array_equal(*runs)


def test_a_law_goes_through_every_command_that_takes_one(place: Path) -> None:
    law = SeamFollower()
    welded = tw.weld(weld="short.toml", compensator=law)
    assert welded.runs[0].compensator == "python:seam-follower"
    assert law.across_m == 0.0, "every run has a law of its own"
    compared = tw.compare_laws(weld="short.toml", laws=["none", law], passes=1)
    assert [of.name for of in compared.laws] == ["none", "python:seam-follower"]


def requirements(place: Path) -> str:
    text = """schema = "requirements/1"
failure_probability = 0.5
confidence = 0.8
[limits]
lateral_max_m = 0.0024
[uncertainty]
stiffness = 0.3
process = 0.3
ripple = 0.0
crosstalk = 0.0
delay_periods = [1.0, 1.0]
"""
    (place / "requirements.toml").write_text(text)
    return "requirements.toml"


def test_a_certificate_says_that_the_source_of_a_law_in_python_is_not_in_its_digest(place: Path) -> None:
    asked = {"weld": "short.toml", "requirements": requirements(place), "trials": 3, "worst": 0}
    open_ = tw.certify(compensator=SeamFollower(), evidence="open", **asked)
    assert any("not in the digest" in warning for warning in open_.provenance.warnings)
    assert "not in the digest" in open_.to_html()
    closed = tw.certify(compensator=SeamFollower(), evidence="closed", law_file=__file__, **asked)
    assert not closed.provenance.warnings
    assert [of.role for of in closed.provenance.files if of.file == __file__] == ["law"]
    assert open_.verdict == closed.verdict == "pass"


def test_a_certified_law_in_python_welds_under_its_certificate(place: Path) -> None:
    asked = {"weld": "short.toml", "requirements": requirements(place), "trials": 3, "worst": 0}
    tw.certify(compensator=SeamFollower(), evidence="closed", law_file=__file__, **asked)
    certificate = "closed/certify.json"
    welded = tw.weld(weld="short.toml", compensator=SeamFollower(), law_file=__file__, certificate=certificate)
    assert "certified: python:seam-follower" in welded.text
    with pytest.raises(tw.CommandError, match="something else"):
        tw.weld(weld="short.toml", compensator=SeamFollower(), certificate=certificate)


@pytest.mark.parametrize(
    ("law", "error", "text"),
    [
        (lambda readings: [0.0] * 5, tw.LawError, "expected 6 numbers"),
        (lambda readings: np.zeros((6, 1)), tw.LawError, "expected 6 numbers"),
        (lambda readings: None, tw.LawError, "returned None"),
        (lambda readings: "abcdef", tw.LawError, "expected 6 numbers"),
        (lambda readings: 1 / 0, ZeroDivisionError, "division"),
        (lambda: None, TypeError, "argument"),
        (
            type("Broken", (), {"__init__": lambda self: 1 / 0, "demand": lambda self, readings: None}),
            ZeroDivisionError,
            "division",
        ),
        (object(), tw.LawError, "is no law"),
        (None.__class__, tw.LawError, "None is no law"),
    ],
)
def test_what_a_law_raises_is_raised(law: Any, error: type[Exception], text: str, place: Path) -> None:
    with pytest.raises(error, match=text):
        tw.weld(weld="short.toml", compensator=law)


def test_the_traceback_of_a_law_shows_its_line(place: Path) -> None:
    def wrong(readings: tw.Readings) -> None:
        raise RuntimeError("here")

    with pytest.raises(RuntimeError, match="here") as caught:
        tw.weld(weld="short.toml", compensator=wrong)
    assert caught.traceback[-1].name == "wrong"


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 1e300, -1e300])
def test_a_demand_that_cannot_be_followed_is_not(value: float, place: Path) -> None:
    """The loops hold it, and the result says so; nothing fails."""
    held = tw.weld(weld="short.toml", compensator=lambda readings: [0.0, value, 0.0, 0.0, 0.0, 0.0])
    assert held.runs[0].limited_rows > 0
    assert np.isfinite(held.trajectories[0].deviation_m).all()


def test_two_laws_of_one_name_are_told_apart(place: Path) -> None:
    with pytest.raises(ValueError, match="two laws are called"):
        tw.compare_laws(weld="short.toml", laws=[SeamFollower(1.0), SeamFollower(2.0)])


def test_a_function_becomes_an_expression() -> None:
    def cable(link: Any, link_rate: Any, friction: Any, stiffness: Any) -> Any:
        return -(friction * np.tanh(link_rate / 0.001) + stiffness * link)

    parameters = {
        "friction": effects.Parameter(value=150, low=0, high=500, unit="N·m", step=20),
        "stiffness": effects.Parameter(value=4000, low=0, high=2e4, unit="N·m/rad", step=500),
    }
    drag = effects.define("cable-drag", cable, port="link-torque", at="A1", parameters=parameters)
    assert drag.expression == "(-((friction * tanh((link_rate / 0.001))) + (stiffness * link)))"
    with pytest.raises(TypeError, match="cannot branch"):
        effects.define("x", lambda link: 1.0 if link > 0 else 0.0, port="twist", at="A1", parameters={})  # type: ignore[operator]
    with pytest.raises(TypeError, match="no function cbrt"):
        effects.define("x", lambda link: np.cbrt(link), port="twist", at="A1", parameters={})


def test_an_effect_in_python_is_the_one_of_the_model_file(place: Path) -> None:
    def cable(link: Any, link_rate: Any, c: Any, s: Any) -> Any:
        return -(c * np.tanh(link_rate / 0.001) + s * link)

    parameters = {
        "c": effects.Parameter(value=150, low=0, high=500, unit="N·m", step=20),
        "s": effects.Parameter(value=4000, low=0, high=2e4, unit="N·m/rad", step=500),
    }
    drag = effects.define("cable-drag", cable, port="link-torque", at="A1", parameters=parameters)
    (place / "base.toml").write_text(
        'schema = "model/1"\nrobot = "fixtures/robots/kr500-mt.toml"\n'
        'process = "fixtures/processes/lap-weld-2024-t3.toml"\n'
        '[[effect]]\nid = "backlash"\nat = "A5"\nhalf_gap_rad = 1e-4\n'
    )
    model = drag.add_to("base.toml", "out/model.toml")
    assert tw.check(model).files[0].ok
    own = tw.weld(weld="short.toml", model=model, compensator="none")
    filed = tw.weld(weld="short.toml", model="fixtures/models/cable-drag.toml", compensator="none")
    # The same arithmetic in another order of brackets.
    assert own.runs[0].lateral_m.rms == pytest.approx(filed.runs[0].lateral_m.rms, rel=1e-9)
    with pytest.raises(FileExistsError):
        drag.add_to("base.toml", "short.toml")
