"""The program `trueweld`, in this process."""

from __future__ import annotations

import signal
import sys

from . import _core


def main() -> int:
    """Runs the program with this process's arguments, and gives its status."""
    # The program ends where it is interrupted; Python would wait for it.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _core.run_program(["trueweld", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
