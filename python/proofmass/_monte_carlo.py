"""Monte Carlo through a model written in Python."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _proofmass
from ._answer import answered
from ._errors import DataError, RequestError, warn
from ._result import Covariance, Finding
from ._types import Watch


@dataclass(frozen=True)
class Sampled:
    """What the trials say of one output."""

    name: str
    mean: float
    median: float
    #: Standard deviation of the trials; `None` where their tails are so heavy that it does not settle.
    u: float | None
    #: Probabilistically symmetric interval.
    interval: tuple[float, float]
    #: Shortest interval.
    shortest: tuple[float, float]
    #: Standard uncertainty of the ends of the interval from the number of trials.
    scatter: float
    #: Trials in which it was no finite number, which are left out.
    invalid: int


@dataclass(frozen=True)
class Trials:
    """Outputs of a calculation by trials."""

    outputs: Mapping[str, Sampled]
    covariance: Covariance
    trials: int
    probability: float
    findings: tuple[Finding, ...]

    def __getitem__(self, name: str) -> Sampled:
        return self.outputs[name]


def monte_carlo(
    model: Callable[..., Any],
    inputs: Mapping[str, Mapping[str, Any]],
    *,
    correlation: Mapping[tuple[str, str], float] | None = None,
    trials: int = 1_000_000,
    seed: int = 1,
    probability: float = 0.95,
    watch: Watch | None = None,
) -> Trials:
    """Propagates distributions through a function of arrays (GUM Supplement 1).

    `inputs` say what is known of each, in the words of a model file: `{"value": 5.0, "u": 0.01}`, `{"value": 0, "half_width": 0.1,
    "shape": "triangular"}`, `{"observations": [...]}`. The function is called with one array for each by name, of some thousand trials at a
    time and from several threads in turn, and gives an array, or a dict of arrays. The same seed gives the same numbers whatever the number of
    threads. An exception that it raises comes out unchanged.
    """
    if not callable(model):
        raise RequestError(f"{model!r} is no function")
    names = list(inputs)
    entries = {
        "input": [{"name": name, "unit": "1", **known} for name, known in inputs.items()],
        "correlation": [{"between": list(pair), "coefficient": r} for pair, r in (correlation or {}).items()],
    }
    try:
        written = json.dumps(entries, default=_plain, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise RequestError(f"the inputs cannot be written: {error}") from None
    outputs = _names(model, inputs, written)

    def columns(given: list[bytes]) -> list[np.ndarray]:
        arrays = [np.frombuffer(column) for column in given]
        answer = model(**dict(zip(names, arrays, strict=True)))
        return _columns(answer, outputs, len(arrays[0]) if arrays else 1)

    try:
        _, call = _proofmass.monte_carlo(
            columns, written, [(name, "") for name in outputs], int(trials), int(seed), float(probability), watch
        )
    except OverflowError:
        raise RequestError(f"{trials} trials with seed {seed} cannot be made") from None
    found = json.loads(answered(call).output)
    findings = tuple(Finding._of(f) for f in found["findings"])
    warn(findings, level=2)
    sampled = {o["name"]: _sampled(o) for o in found["outputs"]}
    matrix = np.array(found["covariance"], dtype=float).reshape(len(sampled), len(sampled))
    covariance = Covariance(tuple(sampled), ("",) * len(sampled), matrix)
    return Trials(sampled, covariance, found["trials"], found["probability"], findings)


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{value!r} is neither a number nor a word")


def _names(model: Callable[..., Any], inputs: Mapping[str, Any], written: str) -> list[str]:
    """Names of the outputs, from one call with two draws."""
    shown: list[str] = []

    def look(given: list[bytes]) -> list[np.ndarray]:
        if not shown:
            answer = model(**dict(zip(inputs, (np.frombuffer(column) for column in given), strict=True)))
            shown.extend(answer if isinstance(answer, Mapping) else ["y"])
        return [np.zeros(len(given[0]) // 8 if given else 1)]

    try:
        _, call = _proofmass.monte_carlo(look, written, [("y", "")], 2, 1, 0.5, None)
    except ValueError as error:
        raise RequestError(str(error)) from None
    if not shown:
        answered(call)
    return [str(name) for name in shown]


def _columns(answer: Any, names: list[str], length: int) -> list[np.ndarray]:
    given = answer if isinstance(answer, Mapping) else {names[0]: answer}
    if list(given) != names:
        raise DataError(f"the model gave {list(given)}, and {names} before")
    columns = []
    for values in given.values():
        array = np.ascontiguousarray(np.broadcast_to(np.asarray(values, dtype=np.float64), (length,)))
        columns.append(array)
    return columns


def _sampled(o: Mapping[str, Any]) -> Sampled:
    symmetric, shortest = ((o[kind]["lower"], o[kind]["upper"]) for kind in ("symmetric", "shortest"))
    u = o.get("standard_uncertainty")
    return Sampled(o["name"], o["mean"], o["median"], u, symmetric, shortest, o["symmetric_scatter"], o["invalid"])
