"""What the tests share: the repository's fixtures, a folder to work in, the program."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FIXTURES = ROOT / "fixtures"


def changed(name: str, **values: str) -> str:
    """The text of a fixture with other values of some keys."""
    text = (FIXTURES / name).read_text(encoding="utf-8")
    for key, value in values.items():
        text, count = re.subn(rf"^{key} = .*$", f"{key} = {value}", text, flags=re.MULTILINE)
        assert count, key
    return text


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, with the fixtures, a weld of 60 mm and requirements that it has room for."""
    (tmp_path / "fixtures").symlink_to(FIXTURES)
    short = changed("welds/published-vertical.toml", start_m="[1.700, -1.000, 0.500]", end_m="[1.700, -0.940, 0.500]")
    (tmp_path / "short.toml").write_text(short, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def program() -> Callable[..., subprocess.CompletedProcess[str]]:
    """Runs the program `trueweld` that the wheel brings."""
    path = shutil.which("trueweld", path=str(Path(sys.executable).parent))
    assert path, "the wheel puts `trueweld` beside the interpreter"

    def run(*arguments: str, timeout: float = 600) -> subprocess.CompletedProcess[str]:
        return subprocess.run([path, *arguments], capture_output=True, text=True, timeout=timeout, check=False)

    return run
