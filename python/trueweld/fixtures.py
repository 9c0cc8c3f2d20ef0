"""The example files of the project, as the package brings them: robots, welds, campaigns of logs."""

from __future__ import annotations

from pathlib import Path

__all__ = ["path", "campaign"]

_ROOT = Path(__file__).resolve().parent / "_fixtures"


def path(name: str = "") -> Path:
    """A file or folder of the examples, such as ``"welds/coupon.toml"``; without a name, all of them."""
    found = _ROOT / name
    if not found.exists():
        folder = found.parent if found.parent.exists() else _ROOT
        there = ", ".join(sorted(inside.name for inside in folder.iterdir()))
        raise FileNotFoundError(f"there is no example {name!r}; in {folder.name} there are {there}")
    return found


def campaign(name: str) -> Path:
    """The folder of a campaign: ``"backlash"`` is simulated, ``"kr300-measured"`` a real KUKA KR 300."""
    return path(f"campaigns/{name}")
