"""Errors and warnings: what is wrong, where, what to do."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from typing import Any


class ProofmassError(Exception):
    """A command came to no result.

    The text is one line. `place` has the lines that say where and on what evidence, `hint` the remedy.
    """

    def __init__(self, what: str, place: Sequence[str] = (), hint: str | None = None):
        super().__init__(what)
        self.place = tuple(place)
        self.hint = hint

    def __str__(self) -> str:
        lines = [super().__str__(), *(f"  {line}" for line in self.place)]
        if self.hint:
            lines.append(f"hint: {self.hint}")
        return "\n".join(lines)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (*self.args, self.place, self.hint)


class RequestError(ProofmassError, ValueError):
    """The request contradicts itself, or asks for what there is not."""


class DataError(ProofmassError, ValueError):
    """The data cannot be read, or do not carry the result that is asked for."""


class OutputError(ProofmassError):
    """The result cannot be written."""


class ProofmassWarning(UserWarning):
    """A finding: a doubt about a result, with its code.

    The text begins with the code, so that `warnings.filterwarnings("ignore", message="code:")` keeps one quiet.
    """

    def __init__(self, finding: Any):
        super().__init__(finding)
        self.finding = finding
        self.code = finding.code

    def __str__(self) -> str:
        return f"{self.code}: {self.finding}"


def near_to(word: str, known: Iterable[str]) -> str | None:
    """The known word that is meant, if one is near."""
    import difflib

    return next(iter(difflib.get_close_matches(word, known, 1)), None)


_KINDS = {"request": RequestError, "output": OutputError}


def raised(error: tuple[str, str, list[str], str | None]) -> BaseException:
    """The exception of what a command says."""
    kind, what, place, hint = error
    if kind == "cancelled":
        return KeyboardInterrupt(what)
    return _KINDS.get(kind, DataError)(what, place, hint)


def warn(findings: Iterable[Any], level: int) -> None:
    """Warns of every finding that is more than a note."""
    for finding in findings:
        if finding.severity != "note":
            warnings.warn(ProofmassWarning(finding), stacklevel=level + 1)
