"""FMUs from the wheel alone: the library for this platform is in it."""

from __future__ import annotations

import ctypes
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import trueweld as tw


@pytest.mark.skipif(sys.platform != "linux", reason="names the folder of Linux")
def test_an_fmu_is_made_without_a_library_being_named(place: Path, program: Callable[..., Any]) -> None:
    text = tw.export_fmu(law="seam-tracking", weld="short.toml", out="law.fmu")
    assert "linux64" in text
    ended = program("export-fmu", "--law", "seam-tracking", "--weld", "short.toml", "--out", "program.fmu")
    assert ended.returncode == 0, ended.stderr
    assert (place / "law.fmu").read_bytes() == (place / "program.fmu").read_bytes()
    with zipfile.ZipFile("law.fmu") as fmu:
        library = fmu.extract("binaries/linux64/trueweld_law.so")
        sources = zipfile.ZipFile(fmu.open("extra/trueweld/sources.zip")).namelist()
    version = ctypes.CDLL(str(place / library)).fmi2GetVersion
    version.restype = ctypes.c_char_p
    assert version() == b"2.0"
    assert {"Cargo.lock", "fmu/src/lib.rs", "core-nostd/src/lib.rs", "LICENSE-MIT"} <= set(sources)
