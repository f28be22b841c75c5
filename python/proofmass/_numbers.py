"""Numbers that may be calculated with, and what is none."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._errors import DataError, RequestError


def finite(numbers: np.ndarray, name: str) -> None:
    """Refuses NaN and infinities with the place of the first."""
    good = np.isfinite(numbers)
    if not good.all():
        at = tuple(int(i) for i in np.argwhere(~good)[0])
        place = at[0] if len(at) == 1 else at
        raise DataError(
            f"{name}[{place}] is {numbers[at]}", hint="leave such samples out, or mark the gap by the times"
        )


def real(values: Any, name: str) -> np.ndarray:
    """An array of real numbers as it is; masks, complex numbers, text and objects are no such."""
    if np.ma.isMaskedArray(values):
        raise RequestError(f"{name} is masked", hint="leave the masked samples out, or mark the gap by the times")
    array = np.asarray(values)
    if array.dtype.kind == "c":
        raise RequestError(
            f"{name} is complex, which holds no real numbers", hint="give real and imaginary parts apart"
        )
    if array.dtype.kind not in "fiub" and array.size:
        raise RequestError(
            f"{name} is of type {array.dtype}, which holds no numbers",
            hint="text of dates becomes times by pandas.to_datetime or numpy.datetime64, text of numbers by .astype(float)",
        )
    return array


def doubles(values: Any, name: str) -> np.ndarray:
    """Real numbers as float64 in the order of C."""
    return np.asarray(real(values, name), dtype=np.float64, order="C")
