"""Packages that extras bring."""

from __future__ import annotations

import importlib
from typing import Any


def needed(module: str, extra: str) -> Any:
    """The module of an extra; where it is not installed, an error that says how it comes."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            f"{error}; the extra brings it: pip install 'trueweld[{extra}]'", name=error.name
        ) from None
