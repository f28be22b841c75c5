"""Campaigns and requests in memory."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from . import _proofmass
from ._answer import answered, results
from ._data import recording
from ._errors import RequestError, warn
from ._result import Result
from ._types import Watch


def _bytes(name: str, content: Any) -> bytes:
    """A file of the campaign: bytes and text as they are, arrays and tables as a recording, mappings of the campaign as TOML."""
    if isinstance(content, str):
        return content.encode()
    if isinstance(content, bytes | bytearray | memoryview):
        return bytes(content)
    lent = recording(content, name).lent
    return lent[1] + bytes(lent[2])


def calibrate_campaign(files: Mapping[str, Any], *, watch: Watch | None = None) -> Result | list[Result]:
    """Calibrates from a campaign whose files are in memory, `campaign.toml` (a text) among them.

    The other files are arrays, arrays by name, tables, bytes or texts under the names that campaign.toml has for them. A campaign of
    several devices gives a list.
    """
    if "campaign.toml" not in files:
        raise RequestError("there is no campaign.toml", hint=f"add it beside {', '.join(files) or 'the recordings'}")
    given = [(name, _bytes(name, content)) for name, content in files.items()]
    return _warned(_proofmass.campaign(given, watch))


def run(request: Mapping[str, Any], *, watch: Watch | None = None) -> Result:
    """Evaluates the JSON of a request that needs no data (`job` is its kind): a model of measurement, a plan, a drift."""
    try:
        written = json.dumps(request).encode()
    except (TypeError, ValueError, RecursionError) as error:
        raise RequestError(f"the request cannot be written as JSON: {error}") from None
    result = _warned(_proofmass.request(written, watch))
    assert isinstance(result, Result)
    return result


def _warned(answer: _proofmass.Call) -> Result | list[Result]:
    """The results, with warnings of their findings."""
    found = results(answered(answer).results)
    for result in found if isinstance(found, list) else [found]:
        warn(result.findings, level=3)
    return found
