"""What the command line declares: commands, their arguments, and the keywords that stand for these."""

from __future__ import annotations

import json
from typing import Any

from . import _proofmass

#: Places that a command writes to, which no array can stand for.
WRITTEN = {"output", "draws", "imu_yaml", "plot", "name"}
#: Options that a function has no use for: it returns the object, whose `needs_decision` says the rest.
UNUSED = {"json", "strict"}


_known: dict[str, dict[str, Any]] = {}


def descriptions() -> dict[str, dict[str, Any]]:
    """Every command by its words, as the command line declares it."""
    if not _known:
        _known.update({" ".join(c["words"]): c for c in json.loads(_proofmass.commands())})
    return _known


def arguments(words: str) -> list[dict[str, Any]]:
    """The arguments of a command that its function takes, those without an option first."""
    known = [a for a in descriptions()[words]["arguments"] if a["id"] not in UNUSED]
    return sorted(known, key=lambda a: (a["position"] is None, a["position"] or 0))


def keyword(argument: dict[str, Any]) -> str:
    """The Python name of an argument."""
    name = (argument["long"] or argument["id"]).replace("-", "_")
    return f"{name}_" if name in ("from", "lambda", "in", "is", "global") else name
