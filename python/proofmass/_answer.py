"""What the compiled part answers, as results, notes and errors."""

from __future__ import annotations

from . import _proofmass
from ._errors import raised
from ._log import note
from ._result import Result
from ._wording import in_keywords


def answered(answer: _proofmass.Call, words: str | None = None) -> _proofmass.Call:
    """The answer, its notes told to the log; its error, in keywords of the command, is raised."""
    for line in answer.notes:
        note("%s", line)
    if answer.error is None:
        return answer
    kind, what, place, hint = answer.error
    hint = hint and in_keywords(hint, words)
    raise raised((kind, in_keywords(what, words), [in_keywords(p, words) for p in place], hint))


def results(stored: list[_proofmass.StoredResult]) -> Result | list[Result]:
    """The result, or a list of several; how each recording was read is told to the log."""
    found = [Result(one) for one in stored]
    for result in found:
        for line in result._stored.readings():
            note("read %s", line)
    return found[0] if len(found) == 1 else found
