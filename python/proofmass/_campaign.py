"""Campaigns and requests in memory."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from . import _proofmass
from ._answer import answered, results
from ._command import FUNCTIONS
from ._data import recording
from ._description import arguments, keyword
from ._errors import RequestError, near_to, warn
from ._result import Result
from ._types import Data, Watch


def _bytes(name: str, content: Any) -> bytes:
    """A file of the campaign: bytes and text as they are, arrays and tables as a recording, mappings of the campaign as TOML."""
    if isinstance(content, str):
        return content.encode()
    if isinstance(content, bytes | bytearray | memoryview):
        return bytes(content)
    lent = recording(content, name).lent
    return lent[1] + bytes(lent[2])


def calibrate_campaign(files: Mapping[str, Any], *, watch: Watch | None = None) -> Result | Any:
    """Calibrates from a campaign whose files are in memory, `campaign.toml` (a text) among them.

    The other files are arrays, arrays by name, tables, bytes or texts under the names that campaign.toml has for them. A campaign of
    several devices gives a list.
    """
    if "campaign.toml" not in files:
        raise RequestError("there is no campaign.toml", hint=f"add it beside {', '.join(files) or 'the recordings'}")
    given = [(name, _bytes(name, content)) for name, content in files.items()]
    return _warned(_proofmass.campaign(given, watch))


def run(request: Mapping[str, Any], *data: Data, watch: Watch | None = None) -> Any:
    """Evaluates a request that came as JSON: `job` is the kind of one that needs no data, `command` the words of a command.

    `{"job": "uncertainty", "model": …}` is a model of measurement, a plan, a drift of a velocity. `{"command": "noise", "rate": 100}`
    is `proofmass.noise(*data, rate=100)`: the other keys are keywords of the function, `data` are arrays or paths.
    """
    if not isinstance(request, Mapping):
        raise RequestError(f"a request is a mapping, not of type {type(request).__name__}")
    if "command" in request:
        return _commanded(request, data, watch)
    if data:
        raise RequestError(
            "a request by `job` takes no data", hint='say {"command": "noise", …} and the keywords of that function'
        )
    try:
        written = json.dumps(request).encode()
    except (TypeError, ValueError, RecursionError) as error:
        raise RequestError(f"the request cannot be written as JSON: {error}") from None
    return _warned(_proofmass.request(written, watch))


def _commanded(request: Mapping[str, Any], data: tuple[Data, ...], watch: Watch | None) -> Any:
    """The answer of the function of a command."""
    if "job" in request:
        raise RequestError("a request has a `job` or a `command`, not both")
    words = request["command"]
    function = FUNCTIONS.get(words) if isinstance(words, str) else None
    if function is None:
        near = near_to(str(words), FUNCTIONS)
        raise RequestError(
            f"there is no command {words!r}",
            hint=f"did you mean {near!r}?" if near else ", ".join(sorted(FUNCTIONS)),
        )
    known = [keyword(a) for a in arguments(words)]
    options = {str(key): value for key, value in request.items() if key != "command"}
    for key in options:
        if key not in known:
            near = near_to(key, known)
            raise RequestError(
                f"`{words}` has no key {key!r}", hint=f"did you mean {near!r}?" if near else ", ".join(known)
            )
    try:
        answer = function.quiet(*data, **options, watch=watch)  # type: ignore[attr-defined]
    except TypeError as error:
        raise RequestError(str(error)) from None
    for result in answer if isinstance(answer, list) else [answer]:
        if isinstance(result, Result):
            warn(result.findings, level=3)
    return answer


def _warned(answer: _proofmass.Call) -> Result | list[Result]:
    """The results, with warnings of their findings."""
    found = results(answered(answer).results)
    for result in found if isinstance(found, list) else [found]:
        warn(result.findings, level=3)
    return found
