"""What can be wrong."""

from __future__ import annotations

import re


class TrueweldError(Exception):
    """What this package cannot do, and what to do about it.

    ``message``: what was read and what was expected; ``help``: what to do, where there is something
    to do.
    """

    def __init__(self, message: str, help: str | None = None) -> None:
        self.message = message
        self.help = help
        super().__init__(message, help)

    def __str__(self) -> str:
        return f"{self.message}\n  help: {self.help}" if self.help else self.message


class CommandError(TrueweldError):
    """A command that cannot come to a result."""

    def __init__(self, message: str, help: str | None = None) -> None:
        super().__init__(_with_keywords(message), help and _with_keywords(help))


class ArgumentError(CommandError, ValueError):
    """The value of a keyword that a command cannot take."""


def _with_keywords(text: str) -> str:
    """Options of the command line, such as ``--stiffness-error <E>``, as keywords."""
    return re.sub(r"--([a-z][a-z-]*)( <[^>]*>)?", lambda flag: flag[1].replace("-", "_"), text)


class InputError(TrueweldError, ValueError):
    """An input file that cannot be used.

    ``file``, ``line``, ``column``: where the mistake is; line and column count from 1, and are None
    where no line can be named.
    """

    def __init__(
        self,
        message: str,
        help: str | None = None,
        file: str = "",
        line: int | None = None,
        column: int | None = None,
    ) -> None:
        super().__init__(message, help)
        self.file = file
        self.line = line
        self.column = column
        self.args = (message, help, file, line, column)

    def __str__(self) -> str:
        place = ":".join(str(part) for part in (self.file, self.line, self.column) if part)
        return f"{place}: {super().__str__()}"


class LawError(TrueweldError, TypeError):
    """A law in Python that is none, or that did not return six numbers."""


class InputWarning(UserWarning):
    """A value outside its plausible range, or what else a reader of a result should know."""
