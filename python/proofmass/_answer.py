"""What the compiled part answers, as results, notes and errors."""

from __future__ import annotations

import logging

from . import _proofmass
from ._errors import raised
from ._result import Result
from ._wording import in_keywords

_log = logging.getLogger("proofmass")


def answered(answer: _proofmass.Call, words: str | None = None) -> _proofmass.Call:
    """The answer, its notes told to the log; its error, in keywords of the command, is raised."""
    for note in answer.notes:
        _log.info("%s", note)
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
            _log.info("read %s", line)
    return found[0] if len(found) == 1 else found
