"""Paths as functions take them, and files that are whole or not there."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

StrPath = str | os.PathLike[str]


def write_whole(path: Path, text: str) -> None:
    """Writes a file beside its place and moves it there: a failure leaves what was there."""
    mode = 0o666 & ~(mask := os.umask(0))
    os.umask(mask)
    handle, made = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(made, mode)
        os.replace(made, path)
    except BaseException:
        os.unlink(made)
        raise
