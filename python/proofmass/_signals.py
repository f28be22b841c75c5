"""Calls on arrays that need no command."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from . import _proofmass
from ._errors import DataError, RequestError
from ._numbers import doubles, finite


@dataclass(frozen=True)
class DeviationCurve:
    """A stability statistic against averaging time."""

    #: Averaging times in s.
    tau: np.ndarray
    #: The deviation, in the unit of the samples.
    deviation: np.ndarray
    #: Lower ends of the intervals; NaN where no degrees of freedom are known.
    low: np.ndarray
    #: Upper ends.
    high: np.ndarray
    #: Equivalent degrees of freedom; NaN where none are known.
    edf: np.ndarray
    #: How many terms were averaged.
    terms: np.ndarray


@dataclass(frozen=True)
class Sine:
    """x(t) = Re(amplitude e^{2πjft}) + offset, t = 0 at the first sample."""

    #: Hz.
    frequency: float
    #: Standard uncertainty of the frequency; `None` where it was given.
    frequency_u: float | None
    #: Complex peak amplitude.
    amplitude: complex
    #: Covariance of its real and imaginary part.
    covariance: np.ndarray
    #: Degrees of freedom of that covariance.
    dof: float
    #: Constant part.
    offset: float
    #: Root mean square of the residuals.
    residual_rms: float

    @property
    def modulus(self) -> float:
        """Peak amplitude."""
        return abs(self.amplitude)

    @property
    def phase(self) -> float:
        """Phase in radians at the first sample."""
        return float(np.angle(self.amplitude))

    @property
    def modulus_u(self) -> float:
        """Standard uncertainty of the peak amplitude."""
        toward = np.array([np.cos(self.phase), np.sin(self.phase)])
        return float(np.sqrt(toward @ self.covariance @ toward))

    @property
    def phase_u(self) -> float:
        """Standard uncertainty of the phase in radians."""
        across = np.array([-np.sin(self.phase), np.cos(self.phase)])
        return float(np.sqrt(across @ self.covariance @ across)) / self.modulus if self.modulus else float("inf")


def _samples(samples: ArrayLike) -> np.ndarray:
    array = doubles(samples, "samples")
    if array.ndim != 1:
        raise RequestError(f"samples have shape {array.shape}", hint="give one channel, such as samples[:, 0]")
    finite(array, "samples")
    return array


def allan_deviation(
    samples: ArrayLike,
    rate: float,
    *,
    statistic: str = "oadev",
    taus: str | Sequence[float] = "octave",
    probability: float = 0.95,
) -> DeviationCurve:
    """A stability statistic of a signal, with intervals: OADEV at octaves where nothing else is asked for.

    `samples` are the signal itself (a rate, an acceleration), evenly spaced at `rate` hertz; `statistic` and `taus` are those of
    `proofmass.noise`. The intervals are χ², their degrees of freedom those of a noise model fitted to the record.
    """
    if not isinstance(taus, str):
        taus = ",".join(repr(float(tau)) for tau in taus)
    array = _samples(samples)
    try:
        points = _proofmass.allan_deviation(array, float(rate), statistic, taus, float(probability))
    except ValueError as error:
        raise DataError(str(error)) from None
    columns = np.array([[np.nan if x is None else x for x in p] for p in points], dtype=float).reshape(-1, 6).T
    tau, deviation, low, high, edf, terms = columns
    if not np.isfinite(deviation).all():
        raise DataError("the deviation is no finite number", hint="the samples are too large to be squared: scale them")
    return DeviationCurve(tau, deviation, low, high, edf, terms.astype(int))


def fit_sine(samples: ArrayLike, rate: float, frequency: float | None = None, *, white: bool = True) -> Sine:
    """The sine in a signal: three parameters where the frequency is given, else four (IEEE 1057, ISO 16063-11 method 3).

    Residuals are taken as white; with `white=False` only those beside the frequency count, which is right for noise of any colour.
    """
    array = _samples(samples)
    try:
        known = None if frequency is None else float(frequency)
        found, u, (re, im), (covariance, dof, offset, rms) = _proofmass.fit_sine(array, float(rate), known, white)
    except ValueError as error:
        raise DataError(str(error)) from None
    rr, ri, ii = covariance
    matrix = np.array([[rr, ri], [ri, ii]])
    if u is not None:
        # So far it is that of a known frequency, whose error turns the phase about the middle of the record.
        turn = np.pi * (len(array) - 1) / float(rate) * u * np.array([-im, re])
        matrix = matrix + np.outer(turn, turn)
    return Sine(found, u, complex(re, im), matrix, dof, offset, rms)
