"""Many devices in one table, a result or an error for each."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ._arrow import stream_of
from ._command import FUNCTIONS
from ._data import named_columns, values_of
from ._errors import ProofmassError, RequestError
from ._result import Result


class Batch(Mapping[Any, "Result | ProofmassError"]):
    """What each device gave, by serial number: its result, or the error that says why there is none."""

    def __init__(self, by: str, answers: dict[Any, Result | ProofmassError]):
        self._by, self._answers = by, answers

    def __getitem__(self, serial: Any) -> Result | ProofmassError:
        return self._answers[serial]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._answers)

    def __len__(self) -> int:
        return len(self._answers)

    @property
    def results(self) -> dict[Any, Result]:
        """The devices that have a result."""
        return {serial: a for serial, a in self._answers.items() if isinstance(a, Result)}

    @property
    def errors(self) -> dict[Any, ProofmassError]:
        """The devices that have none."""
        return {serial: a for serial, a in self._answers.items() if not isinstance(a, Result)}

    def to_dict(self) -> dict[str, list[Any]]:
        """A row for each device: value and u of every quantity, the codes of its findings, its error."""
        names: dict[str, str] = {}
        for result in self.results.values():
            names.update((name, q.unit) for name, q in result.estimate.items())
        rows: dict[str, list[Any]] = {self._by: list(self._answers)}
        answers = list(self._answers.values())
        for name in names:
            found = [a.estimate.get(name) if isinstance(a, Result) else None for a in answers]
            rows[name] = [None if q is None else q.value for q in found]
            rows[f"u({name})"] = [None if q is None else q.u for q in found]
        rows["findings"] = [" ".join(f.code for f in a.findings) if isinstance(a, Result) else None for a in answers]
        rows["error"] = [None if isinstance(a, Result) else str(a) for a in answers]
        return rows

    def to_pandas(self) -> Any:
        """The rows as a data frame of pandas."""
        import pandas  # type: ignore[import-untyped, unused-ignore]

        return pandas.DataFrame(self.to_dict()).set_index(self._by)

    def to_polars(self) -> Any:
        """The rows as a data frame of polars."""
        import polars

        return polars.DataFrame(self.to_dict())

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """The rows as a stream of Arrow."""
        rows = self.to_dict()
        rows[self._by] = [str(serial) for serial in rows[self._by]]
        return stream_of(rows)

    def __repr__(self) -> str:
        return f"<Batch of {len(self)} devices: {len(self.results)} results, {len(self.errors)} errors>"


def calibrate_batch(table: Any, *, by: str = "serial", threads: int | None = None, **options: Any) -> Batch:
    """Calibrates every device of a table from its rows, in their order; `options` are those of `proofmass.calibrate`.

    A device that is refused is an entry with its error and stops no other. Findings stand in the results and are no warnings here.
    """
    columns = named_columns(table)
    if columns is None:
        raise RequestError(
            f"{type(table).__name__} has no columns by name", hint="give a data frame or a dict of arrays"
        )
    if by not in columns:
        raise RequestError(f"the table has no column {by!r}", hint=f"there are {', '.join(columns)}")
    arrays = {name: values_of(c) for name, c in columns.items()}
    serials = arrays.pop(by)
    for name, array in arrays.items():
        if len(array) != len(serials):
            raise RequestError(f"{name!r} has {len(array)} values, {by!r} has {len(serials)}")
    if len(serials) == 0:
        raise RequestError("the table is empty")
    if "output" in options:
        raise RequestError("a batch writes no folder", hint="write each result: batch[serial].write(folder)")
    if threads is not None and not (isinstance(threads, int) and threads > 0):
        raise RequestError(f"{threads!r} threads are none")
    groups: dict[Any, list[int]] = {}
    for row, serial in enumerate(serials.tolist()):
        if serial is None or serial != serial:
            raise RequestError(f"{by}[{row}] is missing", hint="leave such rows out, or name them")
        try:
            groups.setdefault(serial, []).append(row)
        except TypeError:
            raise RequestError(f"{by}[{row}] is of type {type(serial).__name__}, which names nothing") from None

    def one(rows: np.ndarray) -> Result | ProofmassError:
        kept = {name: array[rows] for name, array in arrays.items()}
        try:
            result = FUNCTIONS["calibrate"].quiet(kept, **options)  # type: ignore[attr-defined]
        except ProofmassError as error:
            return error
        answer: Result = result[0] if isinstance(result, list) else result
        return answer

    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(threads or os.cpu_count() or 1) as pool:
        answers = list(pool.map(one, (np.array(rows) for rows in groups.values())))
    return Batch(by, dict(zip(groups, answers, strict=True)))
