"""Texts of the command line in the words of Python."""

from __future__ import annotations

import re
from typing import Any

from ._description import descriptions

#: What stays as it is: a call of the command line in quotes.
_CALL = re.compile(r"`proofmass [^`]*`")
_OPTION = re.compile(
    r"--([a-z][a-z0-9]*(?:-[a-z0-9]+)*)(?:[ =](<[^>]*>|[A-Z][A-Z0-9_,…]*(?![a-z])|\"[^\"]*\"|[-+]?\d[\w.,…]*))?"
)


def in_keywords(text: str, words: str | None = None) -> str:
    """A text that names options, in the keywords of a function."""
    known: dict[str, Any] = {}
    if words in descriptions():
        known = {a["long"]: a for a in descriptions()[words]["arguments"]}

    def said(match: re.Match[str]) -> str:
        argument, name, value = known.get(match.group(1)), match.group(1).replace("-", "_"), match.group(2)
        if argument and argument["kind"] == "bool":
            return f"{name}=True" + (f" {value}" if value else "")
        if argument and argument["several"] and value:
            return f"{name}=({value}"
        return f"{name}={value}" if value else f"{name}="

    def options(piece: str) -> str:
        piece = _OPTION.sub(said, piece)
        piece = re.sub(r"=\((<?[A-Z_]+>?) (<?[A-Z_]+>?)", r"=(\1, \2)", piece)
        # A word that an option may have, or a unit, belongs to it.
        choices = {c for a in known.values() for c in a["choices"]} | {"g", "mg", "count", "s", "ms"}
        piece = re.sub(r"(\w+)= ([\w-]+)", lambda m: f'{m[1]}="{m[2]}"' if m[2] in choices else m[0], piece)
        return re.sub(r"(?<![\w-])-o( [A-Z]+)?\b", lambda m: f"output={(m[1] or '').strip()}", piece)

    parts, at = [], 0
    for call in _CALL.finditer(text):
        parts += [options(text[at : call.start()]), call.group()]
        at = call.end()
    return "".join([*parts, options(text[at:])])
