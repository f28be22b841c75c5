"""Compensation of arrays."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _proofmass
from ._errors import DataError, RequestError
from ._numbers import doubles, finite


class Calibration:
    """A calibration of a triaxial accelerometer by one matrix: a = K⁻¹ (output − b).

    It is what `proofmass.apply` does to a recording, for arrays. Its terms over temperature and its curvature are used where it
    has them.
    """

    def __init__(self, path: str | os.PathLike[str]):
        try:
            self._inner = _proofmass.Compensation.open(os.fspath(path))
        except ValueError as error:
            raise DataError(str(error)) from error

    @classmethod
    def from_json(cls, written: bytes) -> Calibration:
        """From the bytes of a calibration.json."""
        calibration = cls.__new__(cls)
        try:
            calibration._inner = _proofmass.Compensation.read(written)
        except ValueError as error:
            raise DataError(str(error)) from error
        return calibration

    @property
    def input_unit(self) -> str:
        """Unit of the outputs of the sensor."""
        return self._inner.units[0]

    @property
    def output_unit(self) -> str:
        """Unit of what comes out."""
        return self._inner.units[1]

    def apply(self, outputs: ArrayLike, *, temperature: ArrayLike | None = None) -> np.ndarray:
        """Compensates outputs of shape (n, 3), or (3,), in the unit of the calibration.

        A calibration over temperature needs the temperature in °C, of each row or of all; it is held at the ends of the range
        in which the calibration was measured.
        """
        if hasattr(outputs, "columns"):
            raise RequestError(
                "a table has columns in an order of its own", hint='name them: table[["x", "y", "z"]].to_numpy()'
            )
        rows = doubles(outputs, "outputs")
        if rows.ndim not in (1, 2) or rows.shape[-1] != 3:
            raise RequestError(
                f"an array of shape {rows.shape} has no three axes",
                hint="give it shape (n, 3): a row for each sample, columns x, y, z",
            )
        finite(rows, "outputs")
        measured = self._inner.temperatures
        at = None
        if measured is not None:
            if temperature is None:
                raise RequestError(
                    "the calibration follows the temperature, which is not given", hint="add temperature=… in °C"
                )
            at = np.clip(doubles(temperature, "temperature"), *measured).reshape(-1)
            finite(at, "temperature")
            samples = 1 if rows.ndim == 1 else len(rows)
            if at.size not in (1, samples):
                raise RequestError(f"{at.size} temperatures are given for {samples} samples")
        flat = rows.reshape(-1)
        return np.frombuffer(self._inner.apply(flat, at), dtype=np.float64).reshape(rows.shape).copy()

    def to_json(self) -> bytes:
        """The bytes of calibration.json."""
        return self._inner.json()

    def __reduce__(self) -> tuple[Any, ...]:
        return Calibration.from_json, (self.to_json(),)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Calibration) and self.to_json() == other.to_json()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<Calibration from {self.input_unit} to {self.output_unit}>"
