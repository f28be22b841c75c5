"""Numbers and arrays that carry their uncertainty, and what they have in common."""

from __future__ import annotations

import itertools
import operator
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _proofmass
from ._errors import DataError, RequestError
from ._numbers import doubles, finite

UncertainNumber = _proofmass.Uncertain
UncertainComplex = _proofmass.UncertainComplex

#: Names of causes that nobody named; other processes have others.
_counter = itertools.count(1)
_process = ""


def _begin_process() -> None:
    global _process
    _process = os.urandom(6).hex()


_begin_process()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_begin_process)

#: Most coefficients that a sum or product may hold.
_MOST = 50_000_000


def _cause() -> str:
    return f"{_process}-{next(_counter)}"


def ufloat(value: float, u: float, name: str | None = None, *, dof: float = float("inf")) -> UncertainNumber:
    """A number with its standard uncertainty.

    Two numbers that name the same cause share it; without a name the cause is its own.
    """
    try:
        return UncertainNumber.new(name or _cause(), float(value), float(u), float(dof))
    except ValueError as error:
        raise DataError(str(error)) from None


def ucomplex(
    value: complex,
    u: tuple[float, float],
    name: str | None = None,
    *,
    correlation: float = 0.0,
    dof: float = float("inf"),
) -> UncertainComplex:
    """A complex number; `u` are the standard uncertainties of real and imaginary part, `correlation` is theirs."""
    value, (u_re, u_im), word = complex(value), u, name or _cause()
    if not abs(correlation) <= 1:
        raise DataError(f"{correlation} is no coefficient of correlation")
    if not (u_re >= 0 and u_im >= 0 and dof > 0):
        raise DataError(f"u = ({u_re}, {u_im}) with {dof} degrees of freedom is no uncertainty")
    rest = (1 - correlation**2) ** 0.5 * u_im
    try:
        re = UncertainNumber.with_causes(value.real, [(f"{word}.re", u_re, dof)])
        im = UncertainNumber.with_causes(
            value.imag, [(f"{word}.re", correlation * u_im, dof), (f"{word}.im", rest, dof)]
        )
    except ValueError as error:
        raise DataError(str(error)) from None
    return UncertainComplex.new(re, im)


def uarray(values: ArrayLike, u: ArrayLike, name: str | None = None, *, dof: float = float("inf")) -> UncertainArray:
    """An array of independent numbers with their standard uncertainties; `u` is one for each, or one size for all.

    What all have in common is a number of its own: `uarray(readings, noise) * ufloat(1, gain_u, "gain")`.
    """
    given = values if isinstance(values, UncertainArray) else np.asanyarray(values)
    if isinstance(given, UncertainArray) or given.dtype == object:
        known = UncertainArray._of(given)
        return known if np.all(np.asarray(u) == 0) else known + uarray(np.zeros(known.shape), u, name, dof=dof)
    array = doubles(values, "values").copy()
    sizes = np.array(np.broadcast_to(doubles(u, "u"), array.shape))
    finite(array, "values")
    finite(sizes, "u")
    if (sizes < 0).any():
        raise DataError(f"u[{int(np.argmax(sizes.reshape(-1) < 0))}] is negative")
    if not dof > 0:
        raise DataError(f"{dof} degrees of freedom are none")
    block = name or _cause()
    return UncertainArray(array, [_Part(block, float(dof), np.arange(array.size), sizes.reshape(-1))])


@dataclass(frozen=True)
class _Part:
    """Contributions of causes to the elements of an array, each element with one cause of the block."""

    block: str
    dof: float
    #: Which cause of the block each element has; -1 is the one that the block is named after, -2 none.
    index: np.ndarray
    #: Change of each element when its cause changes by its standard uncertainty.
    contribution: np.ndarray

    def taken(self, where: np.ndarray) -> _Part:
        return _Part(self.block, self.dof, self.index[where], self.contribution[where])

    def scaled(self, factor: np.ndarray | float) -> _Part:
        with np.errstate(over="ignore"):
            contribution = self.contribution * factor
            # The sum is made in a fraction of the time of a look at each.
            if not np.isfinite(contribution.sum()) and not np.isfinite(contribution).all():
                raise DataError("an uncertainty of the result is too large to be a number")
        return _Part(self.block, self.dof, self.index, contribution)


def _joined(parts: list[_Part]) -> list[_Part]:
    """Parts in which no element has a cause twice."""
    joined: list[_Part] = []
    for part in parts:
        for k, other in enumerate(joined):
            if other.block != part.block:
                continue
            if other.index is part.index or np.array_equal(other.index, part.index):
                joined[k] = _Part(part.block, part.dof, part.index, other.contribution + part.contribution)
                break
            same = other.index == part.index
            if same.any():
                joined[k] = _Part(
                    part.block, part.dof, other.index, other.contribution + np.where(same, part.contribution, 0)
                )
                part = _Part(part.block, part.dof, part.index, np.where(same, 0, part.contribution))
        else:
            joined.append(part)
    return joined


def _name(block: str, index: int) -> str:
    """The name of a cause: that of its block with its number, or alone where a number brought it."""
    return block if index < 0 else f"{block}[{index}]"


_ELEMENT = re.compile(r"(.*)\[(0|[1-9][0-9]*)\]", re.DOTALL)


_SPEC = re.compile(
    r"(?:(?P<fill>.)?(?P<align>[<>^]))?(?P<sign>[+ ])?(?P<width>\d+)?(?:\.(?P<digits>\d+)(?P<of_u>u)?)?"
    r"(?P<form>[eEfFgG])?(?P<short>S)?",
    re.DOTALL,
)


def formatted(value: float, u: float, spec: str) -> str:
    """`value±u`, or value(u) with `S`: `.2u` is so many digits of u, `.3f` the format of both."""
    match = _SPEC.fullmatch(spec)
    if match is None or (match["of_u"] and int(match["digits"]) == 0):
        raise ValueError(f"{spec!r} is no format of an uncertain number; .2u, .3f, .3e, .2uS are")
    digits, sign = match["digits"], match["sign"] or ""
    if digits is not None and not match["of_u"] and not match["short"]:
        form = f".{digits}{match['form'] or 'g'}"
        text = f"{format(value, sign + form)}±{format(u, form)}"
    else:
        text = _to_the_place_of(value, u, match, sign)
    return format(text, f"{match['fill'] or ''}{match['align'] or '>'}{match['width'] or ''}")


def _to_the_place_of(value: float, u: float, match: re.Match[str], sign: str) -> str:
    """Value and u to the same place."""
    if u == 0:
        return format(value, f"{sign}{match['form'] or 'g'}") + ("(0)" if match["short"] else "±0")
    if match["of_u"] or match["digits"] is None:
        count = int(match["digits"] or 2)
        first = int(f"{u:.{count - 1}e}".partition("e")[2])
        place = count - 1 - first
    else:
        place = int(match["digits"])
    largest = max(abs(value), u)
    power = int(f"{largest:e}".partition("e")[2])
    form = match["form"] or "g"
    if form in "eE" or (form in "gG" and (largest >= 1e7 or power < -4)):
        letter = "E" if form in "EG" else "e"
        inner = _plain(value / 10.0**power, u / 10.0**power, place + power, bool(match["short"]), sign)
        return f"{inner}{letter}{power:+03d}" if match["short"] else f"({inner}){letter}{power:+03d}"
    return _plain(value, u, place, bool(match["short"]), sign)


def _plain(value: float, u: float, place: int, short: bool, sign: str) -> str:
    value, u, places = round(value, place), round(u, place), max(0, place)
    shown = format(value, f"{sign}.{places}f")
    if not short:
        return f"{shown}±{u:.{places}f}"
    return f"{shown}({u:.{places}f})" if u >= 1 and places else f"{shown}({round(u * 10.0**places)})"


class UncertainArray:
    """An array of numbers that carry their uncertainty; numpy's functions and operators work on it."""

    __array_priority__ = 1000

    def __init__(self, value: np.ndarray, parts: list[_Part]):
        self._value = value
        self._parts = parts

    @classmethod
    def _of(cls, other: Any) -> UncertainArray:
        """An array, numbers without uncertainty, or one number with its causes."""
        if isinstance(other, UncertainArray):
            return other
        if isinstance(other, UncertainNumber):
            parts = []
            for name, contribution, dof in other.causes():
                match = _ELEMENT.fullmatch(name)
                block, index = (match.group(1), int(match.group(2))) if match else (name, -1)
                parts.append(_Part(block, dof, np.array([index]), np.array([contribution])))
            return cls(np.array(other.value), parts)
        value = np.asarray(other)
        if value.dtype == object:
            for x in value.reshape(-1):
                if not isinstance(x, UncertainNumber | int | float | np.integer | np.floating) or isinstance(x, bool):
                    raise TypeError(f"{type(x).__name__} is no operand of uncertain numbers")
            return _side_by_side([cls._of(x) for x in value.reshape(-1)]).reshape(value.shape)
        if (value.dtype.kind not in "fiub" and value.size) or np.ma.isMaskedArray(other):
            raise TypeError(f"{type(other).__name__} of type {value.dtype} is no operand of uncertain numbers")
        value = value.astype(np.float64)
        finite(value, "operand")
        return cls(value, [])

    @property
    def value(self) -> np.ndarray:
        """The values."""
        return self._value.copy()

    @property
    def u(self) -> np.ndarray:
        """The standard uncertainties."""
        with np.errstate(over="ignore", under="ignore"):
            variance = self._variance()
        if bool(np.all((variance > 1e-280) & (variance < 1e280))):
            root: np.ndarray = np.sqrt(variance)
            return root
        # Squares leave the range of numbers long before their root does.
        scale = np.zeros(self._value.size)
        for part in self._parts:
            np.maximum(scale, np.abs(part.contribution), out=scale)
        with np.errstate(divide="ignore", invalid="ignore", under="ignore", over="ignore"):
            squares = np.zeros(self._value.size)
            for part in self._parts:
                squares += (part.contribution / scale) ** 2
            u = np.where(scale > 0, scale * np.sqrt(squares), scale)
        if not np.isfinite(u).all():
            raise DataError("an uncertainty of the array is too large to be a number")
        return u.reshape(self._value.shape)

    @property
    def nu(self) -> np.ndarray:
        """The effective degrees of freedom."""
        fourth, u = np.zeros(self._value.size), self.u.reshape(-1)
        with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
            for part in self._parts:
                share = np.where(u > 0, part.contribution / u, 0)
                np.add(fourth, share**4 / part.dof, out=fourth)
            nu = np.where(fourth > 0, 1 / fourth, np.inf)
        return nu.reshape(self._value.shape)

    def _variance(self) -> np.ndarray:
        variance = np.zeros(self._value.size)
        for part in self._parts:
            variance += part.contribution**2
        return variance.reshape(self._value.shape)

    def covariance(self) -> np.ndarray:
        """The covariance matrix of the elements, flattened in their order."""
        size = self._value.size
        if size * size > _MOST:
            raise RequestError(f"the covariance of {size} numbers does not fit", hint="take fewer of them")
        total = np.zeros((size, size))
        for part, other in itertools.product(self._parts, self._parts):
            if part.block == other.block:
                same = part.index[:, None] == other.index[None, :]
                total += np.where(same, part.contribution[:, None] * other.contribution[None, :], 0)
        return total

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape."""
        return self._value.shape

    @property
    def size(self) -> int:
        """How many numbers."""
        return self._value.size

    @property
    def ndim(self) -> int:
        """How many dimensions."""
        return self._value.ndim

    def __len__(self) -> int:
        return len(self._value)

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, int) and not isinstance(key, bool) and self.ndim == 1:
            if not -self.size <= key < self.size:
                raise IndexError(f"index {key} of {self.size} numbers")
            return self._element(key % self.size)
        where = np.arange(self._value.size).reshape(self._value.shape)[key]
        if np.ndim(where) == 0:
            return self._element(int(where))
        flat = where.reshape(-1)
        return UncertainArray(self._value[key], [p.taken(flat) for p in self._parts])

    def _element(self, at: int) -> UncertainNumber:
        causes = [(_name(p.block, p.index[at]), float(p.contribution[at]), p.dof) for p in self._parts]
        return UncertainNumber.with_causes(float(self._value.reshape(-1)[at]), [c for c in causes if c[1]])

    def __iter__(self) -> Any:
        return (self[k] for k in range(len(self)))

    def reshape(self, *shape: Any) -> UncertainArray:
        """The same numbers in another shape."""
        return UncertainArray(self._value.reshape(*shape), self._parts)

    @property
    def T(self) -> UncertainArray:
        """The transpose."""
        where = np.arange(self._value.size).reshape(self._value.shape).T
        turned: UncertainArray = self[np.unravel_index(where, self._value.shape)] if self.ndim > 1 else self
        return turned

    def sum(self, axis: int | None = None, dtype: Any = None, out: Any = None) -> Any:
        """The sum of all elements, or along one axis."""
        _only_axis(dtype, out)
        return self._along(axis, UncertainArray._total)

    def mean(self, axis: int | None = None, dtype: Any = None, out: Any = None) -> Any:
        """The mean of all elements, or along one axis."""
        _only_axis(dtype, out)
        return self._along(axis, lambda x: x._total() / x.size)

    def copy(self) -> UncertainArray:
        """The same numbers with the same causes."""
        return UncertainArray(self._value.copy(), self._parts)

    def _along(self, axis: int | None, reduce: Callable[[UncertainArray], UncertainNumber]) -> Any:
        if axis is None or self.ndim == 1:
            return reduce(self)
        where = np.moveaxis(np.arange(self.size).reshape(self.shape), axis, -1)
        flat = self.reshape(-1)
        numbers = [reduce(flat[row]) for row in where.reshape(-1, where.shape[-1])]
        return UncertainArray._of(np.array(numbers, dtype=object).reshape(where.shape[:-1]))

    def _total(self) -> UncertainNumber:
        causes: list[tuple[str, float, float]] = []
        for part in self._parts:
            index, place = np.unique(part.index, return_inverse=True)
            if len(causes) + len(index) > _MOST // 50:
                raise RequestError(f"a sum of {self.size} numbers has too many causes", hint="sum fewer of them")
            totals = np.bincount(place, weights=part.contribution, minlength=len(index))
            causes += [(_name(part.block, i), float(c), part.dof) for i, c in zip(index, totals, strict=True)]
        return UncertainNumber.with_causes(float(self._value.sum()), causes)

    def __matmul__(self, other: Any) -> Any:
        return _product(self, other)

    def __rmatmul__(self, other: Any) -> Any:
        return _product(other, self)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        return _by_ufunc(ufunc, method, inputs, options)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        own = _FUNCTIONS.get(function)
        if own is None:
            return NotImplemented
        return own(*args, **kwargs)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        raise TypeError("the uncertainty would be lost without a word: take .value")

    def __add__(self, other: Any) -> Any:
        return _two(np.add, self, other)

    def __radd__(self, other: Any) -> Any:
        return _two(np.add, other, self)

    def __sub__(self, other: Any) -> Any:
        return _two(np.subtract, self, other)

    def __rsub__(self, other: Any) -> Any:
        return _two(np.subtract, other, self)

    def __mul__(self, other: Any) -> Any:
        return _two(np.multiply, self, other)

    def __rmul__(self, other: Any) -> Any:
        return _two(np.multiply, other, self)

    def __truediv__(self, other: Any) -> Any:
        return _two(np.true_divide, self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return _two(np.true_divide, other, self)

    def __pow__(self, other: Any) -> Any:
        return _two(np.power, self, other)

    def __rpow__(self, other: Any) -> Any:
        return _two(np.power, other, self)

    def __eq__(self, other: object) -> Any:
        raise TypeError("uncertain arrays are not compared: take .value, or the u of their difference")

    __hash__ = None  # type: ignore[assignment]

    def __neg__(self) -> UncertainArray:
        return _one(np.negative, self)

    def __abs__(self) -> UncertainArray:
        return _one(np.absolute, self)

    def __repr__(self) -> str:
        shown = [str(self.reshape(-1)[k]) for k in range(min(self.size, 6))]
        more = ", …" if self.size > 6 else ""
        return f"uarray([{', '.join(shown)}{more}], shape={self.shape})"


def _only_axis(dtype: Any, out: Any) -> None:
    if dtype is not None or out is not None:
        raise RequestError("an uncertain array has no type and no place to choose")


def _rearranged(arrange: Callable[..., np.ndarray], arrays: Any, axis: int) -> UncertainArray:
    """Arrays put together as numpy puts together the places of their elements."""
    given = [UncertainArray._of(a) for a in arrays]
    ends = np.cumsum([a.size for a in given])
    places = [np.arange(end - a.size, end).reshape(a.shape) for a, end in zip(given, ends, strict=True)]
    where = arrange(places, axis)
    flat: UncertainArray = _side_by_side(given)[where.reshape(-1)]
    return flat.reshape(where.shape)


def _side_by_side(arrays: list[UncertainArray]) -> UncertainArray:
    """Flattened arrays one after the other; a block that several have is one part where it can be."""
    size, at = sum(a.size for a in arrays), 0
    parts: dict[tuple[str, int], tuple[np.ndarray, np.ndarray, float]] = {}
    for a in arrays:
        here = slice(at, at + a.size)
        nth: dict[str, int] = {}
        for part in a._parts:
            layer = nth[part.block] = nth.get(part.block, -1) + 1
            index, contribution, _ = parts.setdefault(
                (part.block, layer), (np.full(size, -2), np.zeros(size), part.dof)
            )
            index[here], contribution[here] = part.index, part.contribution
        at += a.size
    values = np.concatenate([a._value.reshape(-1) for a in arrays]) if arrays else np.zeros(0)
    return UncertainArray(values, [_Part(block, dof, i, c) for (block, _), (i, c, dof) in parts.items()])


def _diff(a: UncertainArray, n: int = 1, axis: int = -1) -> UncertainArray:
    for _ in range(n):
        later, sooner = [[slice(None)] * a.ndim for _ in range(2)]
        later[axis], sooner[axis] = slice(1, None), slice(None, -1)
        a = a[tuple(later)] - a[tuple(sooner)]
    return a


_FUNCTIONS: dict[Any, Callable[..., Any]] = {
    np.sum: lambda a, axis=None, **k: UncertainArray._of(a).sum(axis, **k),
    np.mean: lambda a, axis=None, **k: UncertainArray._of(a).mean(axis, **k),
    np.dot: lambda a, b: _product(a, b),
    np.concatenate: lambda arrays, axis=0: _rearranged(np.concatenate, arrays, axis),
    np.stack: lambda arrays, axis=0: _rearranged(np.stack, arrays, axis),
    np.diff: _diff,
    np.reshape: lambda a, shape: a.reshape(shape),
    np.transpose: lambda a: a.T,
    np.ravel: lambda a: a.reshape(-1),
    np.copy: lambda a: a.copy(),
    np.shape: lambda a: a.shape,
    np.size: lambda a: a.size,
    np.ndim: lambda a: a.ndim,
}


#: The same of numbers alone, without arrays.
_SINGLE = (UncertainNumber, float, int, np.floating, np.integer)
_OF_NUMBER: dict[np.ufunc, Callable[[UncertainNumber], UncertainNumber]] = {
    np.negative: UncertainNumber.__neg__,
    np.exp: UncertainNumber.exp,
    np.log: UncertainNumber.log,
    np.log10: UncertainNumber.log10,
    np.sqrt: UncertainNumber.sqrt,
    np.sin: UncertainNumber.sin,
    np.cos: UncertainNumber.cos,
    np.tan: UncertainNumber.tan,
    np.arcsin: UncertainNumber.arcsin,
    np.arccos: UncertainNumber.arccos,
    np.arctan: UncertainNumber.arctan,
    np.sinh: UncertainNumber.sinh,
    np.cosh: UncertainNumber.cosh,
    np.tanh: UncertainNumber.tanh,
}
_OF_NUMBERS: dict[np.ufunc, Callable[[Any, Any], UncertainNumber]] = {
    np.add: operator.add,
    np.subtract: operator.sub,
    np.multiply: operator.mul,
    np.true_divide: operator.truediv,
}


def _by_ufunc(ufunc: np.ufunc, method: str, inputs: Any, options: dict[str, Any]) -> Any:
    """What numpy does with arrays of numbers."""
    if method != "__call__" or options:
        return NotImplemented
    if ufunc is np.matmul:
        return _product(*inputs)
    if ufunc in _ONE:
        return _one(ufunc, *inputs)
    return _two(ufunc, *inputs) if ufunc in _TWO else NotImplemented


def number_ufunc(ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
    """What numpy does with numbers: a number where all are, else an array."""
    if method == "__call__" and not options:
        if len(inputs) == 1 and ufunc in _OF_NUMBER:
            return _OF_NUMBER[ufunc](inputs[0])
        if len(inputs) == 2 and ufunc in _OF_NUMBERS and all(isinstance(x, _SINGLE) for x in inputs):
            # One of the two is uncertain; the other may be a number of numpy.
            first, second = (x.item() if isinstance(x, np.generic) else x for x in inputs)
            return _OF_NUMBERS[ufunc](first, second)
    answer = _by_ufunc(ufunc, method, inputs, options)
    return answer[()] if isinstance(answer, UncertainArray) and answer.shape == () else answer


def _checked(value: np.ndarray, what: str, *slopes: np.ndarray) -> None:
    for numbers in (value, *slopes):
        if not np.isfinite(numbers).all():
            at = int(np.argmin(np.isfinite(np.atleast_1d(numbers)).reshape(-1)))
            raise DataError(f"{what} is no finite number, or its derivative is none, at index {at}")


_ONE: dict[np.ufunc, Callable[[np.ndarray, np.ndarray], Any]] = {
    np.negative: lambda x, y: -1.0,
    np.positive: lambda x, y: 1.0,
    np.absolute: lambda x, y: np.where(x == 0, np.nan, np.sign(x)),
    np.exp: lambda x, y: y,
    np.log: lambda x, y: 1 / x,
    np.log10: lambda x, y: 1 / (x * np.log(10)),
    np.log2: lambda x, y: 1 / (x * np.log(2)),
    np.sqrt: lambda x, y: 0.5 / y,
    np.square: lambda x, y: 2 * x,
    np.reciprocal: lambda x, y: -y * y,
    np.sin: lambda x, y: np.cos(x),
    np.cos: lambda x, y: -np.sin(x),
    np.tan: lambda x, y: 1 + y * y,
    np.arcsin: lambda x, y: 1 / np.sqrt(1 - x * x),
    np.arccos: lambda x, y: -1 / np.sqrt(1 - x * x),
    np.arctan: lambda x, y: 1 / (1 + x * x),
    np.sinh: lambda x, y: np.cosh(x),
    np.cosh: lambda x, y: np.sinh(x),
    np.tanh: lambda x, y: 1 - y * y,
    np.deg2rad: lambda x, y: np.pi / 180,
    np.rad2deg: lambda x, y: 180 / np.pi,
}


def _power(a: np.ndarray, b: np.ndarray, y: np.ndarray) -> tuple[Any, Any]:
    # The slope by the exponent of an exact one is never used.
    return b * a ** (b - 1), np.where(a > 0, y * np.log(np.where(a > 0, a, 1)), np.nan)


_TWO: dict[np.ufunc, Callable[[np.ndarray, np.ndarray, np.ndarray], tuple[Any, Any]]] = {
    np.add: lambda a, b, y: (1.0, 1.0),
    np.subtract: lambda a, b, y: (1.0, -1.0),
    np.multiply: lambda a, b, y: (b, a),
    np.true_divide: lambda a, b, y: (1 / b, -y / b),
    np.power: _power,
    np.arctan2: lambda a, b, y: (b / np.hypot(a, b) / np.hypot(a, b), -a / np.hypot(a, b) / np.hypot(a, b)),
    np.hypot: lambda a, b, y: (a / y, b / y),
}


def _one(ufunc: np.ufunc, operand: Any) -> UncertainArray:
    x = UncertainArray._of(operand)
    with np.errstate(all="ignore"):
        y = ufunc(x._value)
        slope = np.broadcast_to(_ONE[ufunc](x._value, y), x.shape).reshape(-1)
    _checked(y, ufunc.__name__, slope if x._parts else np.zeros(1))
    return UncertainArray(y, [p.scaled(slope) for p in x._parts])


def _two(ufunc: np.ufunc, left: Any, right: Any) -> Any:
    a, b = UncertainArray._of(left), UncertainArray._of(right)
    with np.errstate(all="ignore"):
        y = ufunc(a._value, b._value)
        slopes = _TWO[ufunc](a._value, b._value, y)
    parts = []
    for operand, slope in zip((a, b), slopes, strict=True):
        if not operand._parts:
            continue
        slope = np.broadcast_to(slope, y.shape).reshape(-1)
        _checked(y, ufunc.__name__, slope)
        spread = operand.shape != y.shape
        where = np.broadcast_to(np.arange(operand.size).reshape(operand.shape), y.shape).reshape(-1) if spread else None
        parts += [(p if where is None else p.taken(where)).scaled(slope) for p in operand._parts]
    _checked(y, ufunc.__name__)
    return UncertainArray(np.asarray(y), _joined(parts))


def _product(left: Any, right: Any) -> Any:
    """The product of matrices, of a matrix and a vector, of two vectors."""
    a, b = UncertainArray._of(left), UncertainArray._of(right)
    if a.ndim not in (1, 2) or b.ndim not in (1, 2) or a.shape[-1] != b.shape[0]:
        raise RequestError(f"arrays of shapes {a.shape} and {b.shape} have no product")
    rows, columns = a.reshape(-1, a.shape[-1]), b.reshape(b.shape[0], -1)
    if rows.shape[0] * columns.shape[1] * rows.shape[1] > _MOST // 1000:
        raise RequestError("the product has too many causes", hint="take fewer rows at a time")
    numbers = []
    for i in range(rows.shape[0]):
        for j in range(columns.shape[1]):
            numbers.append(_two(np.multiply, rows[i, :], columns[:, j]).sum())
    shape = a.shape[:-1] + b.shape[1:]
    return numbers[0] if shape == () else UncertainArray._of(np.array(numbers, dtype=object).reshape(shape))
