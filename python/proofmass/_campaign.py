"""Campaigns and requests in memory."""

from __future__ import annotations

import datetime
import json
import os
from collections.abc import Callable, Mapping
from typing import Any

from . import _proofmass
from ._command import in_keywords
from ._data import recording
from ._errors import RequestError, raised, warn
from ._result import Result


def _today() -> str:
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    now = datetime.datetime.now(datetime.UTC)
    if epoch and epoch.isascii() and epoch.isdigit() and len(epoch) < 12:
        now = datetime.datetime.fromtimestamp(int(epoch), datetime.UTC)
    return now.date().isoformat()


def _bytes(name: str, content: Any) -> bytes:
    """A file of the campaign: bytes and text as they are, arrays and tables as a recording, mappings of the campaign as TOML."""
    if isinstance(content, str):
        return content.encode()
    if isinstance(content, bytes | bytearray | memoryview):
        return bytes(content)
    lent = recording(content, name).lent
    return lent[1] + bytes(lent[2])


def calibrate_campaign(
    files: Mapping[str, Any], *, watch: Callable[[str, int, int], object] | None = None
) -> Result | list[Result]:
    """Calibrates from a campaign whose files are in memory, `campaign.toml` (a text) among them.

    The other files are arrays, arrays by name, tables, bytes or texts under the names that campaign.toml has for them. A campaign of
    several devices gives a list.
    """
    if "campaign.toml" not in files:
        raise RequestError("there is no campaign.toml", hint=f"add it beside {', '.join(files) or 'the recordings'}")
    given = [(name, _bytes(name, content)) for name, content in files.items()]
    return _results(_proofmass.campaign(given, _today(), watch))


def run(request: Mapping[str, Any], *, watch: Callable[[str, int, int], object] | None = None) -> Result:
    """Evaluates the JSON of a request that needs no data (`job` is its kind): a model of measurement, a plan, a drift."""
    try:
        written = json.dumps(request).encode()
    except (TypeError, ValueError, RecursionError) as error:
        raise RequestError(f"the request cannot be written as JSON: {error}") from None
    result = _results(_proofmass.request(written, _today(), watch))
    assert isinstance(result, Result)
    return result


def _results(answer: _proofmass.Call) -> Result | list[Result]:
    if answer.error is not None:
        kind, what, place, hint = answer.error
        raise raised((kind, what, place, hint and in_keywords(hint)))
    results = [Result(stored) for stored in answer.results]
    for result in results:
        warn(result.findings, level=3)
    return results[0] if len(results) == 1 else results
