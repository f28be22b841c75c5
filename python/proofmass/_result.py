"""Results: quantities with their uncertainty, findings, tables, pages."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from . import _proofmass
from ._arrow import stream_of
from ._calibration import Calibration
from ._errors import DataError, OutputError

if TYPE_CHECKING:
    from pathlib import Path

T = TypeVar("T")


class kept(Generic[T]):
    """A property that is made once, without a lock that a forked process would wait for."""

    def __init__(self, make: Callable[[Any], T]):
        self._make, self._name, self.__doc__ = make, make.__name__, make.__doc__

    def __get__(self, owner: Any, kind: Any = None) -> T:
        if owner is None:
            return self  # type: ignore[return-value]
        return owner.__dict__.setdefault(self._name, self._make(owner))  # type: ignore[no-any-return]


@dataclass(frozen=True)
class Quantity:
    """A stated quantity: value ± U = k u, with its degrees of freedom and the probability of the interval."""

    name: str
    unit: str
    value: float
    #: Standard uncertainty; `None` where the distribution has none.
    u: float | None
    #: Expanded uncertainty; `None` where the interval is not symmetric.
    U: float | None
    #: Coverage factor.
    k: float | None
    #: Effective degrees of freedom; infinite where nothing limits them.
    nu: float
    #: Probability of the interval.
    probability: float
    #: Lower and upper end.
    interval: tuple[float, float]
    #: Method that states it, where the kind of result has several.
    method: str | None = None

    @classmethod
    def _of(cls, written: Mapping[str, Any]) -> Quantity:
        value, expanded = written["value"], written.get("U")
        interval = written.get("interval")
        if interval is None:
            interval = (value - expanded, value + expanded)
        nu = written.get("nu_eff")
        return cls(
            written["name"],
            written["unit"],
            value,
            written.get("u"),
            expanded,
            written.get("k"),
            float("inf") if nu in (None, "infinite") else nu,
            written["probability"],
            tuple(interval),
            written.get("method"),
        )

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        if self.U is None:
            low, high = self.interval
            return f"{self.name} = {self.value:.6g} {self.unit}, {100 * self.probability:g} %: {low:.6g} to {high:.6g}"
        k = "" if self.k is None else f", k = {self.k:.3g}"
        value, expanded = stated(self.value, self.U)
        return f"{self.name} = {value} ± {expanded} {self.unit} ({100 * self.probability:.4g} %{k})"


@dataclass(frozen=True)
class Finding:
    """What there is to doubt: the code, how grave it is, the sentence, the evidence, the remedy."""

    code: str
    #: `note`, `warning` or `decision`.
    severity: str
    what: str
    evidence: str
    advice: str
    #: The evidence as numbers and words.
    fields: Mapping[str, Any]

    @classmethod
    def _of(cls, written: Mapping[str, Any]) -> Finding:
        return cls(
            written["code"],
            written["severity"],
            written["what"],
            written.get("evidence", ""),
            written.get("advice", ""),
            written.get("evidence_fields", {}),
        )

    def __str__(self) -> str:
        return "; ".join(part for part in (self.what, self.evidence, self.advice) if part)


class Estimates(Mapping[str, Quantity]):
    """The quantities of a result by name; attributes of them as arrays in their order."""

    def __init__(self, quantities: list[Quantity]):
        self._quantities = {q.name: q for q in quantities}

    def __getitem__(self, name: str) -> Quantity:
        try:
            return self._quantities[name]
        except KeyError:
            raise KeyError(f"{name!r}; there are {', '.join(self._quantities)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._quantities)

    def __len__(self) -> int:
        return len(self._quantities)

    def __repr__(self) -> str:
        return "\n".join(str(q) for q in self._quantities.values())

    @property
    def values_array(self) -> np.ndarray:
        """The values, in the order of the names."""
        return np.array([q.value for q in self._quantities.values()])

    @property
    def u_array(self) -> np.ndarray:
        """The standard uncertainties; NaN where a distribution has none."""
        return np.array([np.nan if q.u is None else q.u for q in self._quantities.values()])


@dataclass(frozen=True)
class Covariance:
    """The joint covariance of the fitted parameters."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    matrix: np.ndarray

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self.matrix, dtype=dtype)

    def between(self, a: str, b: str) -> float:
        """Covariance of two parameters by name."""
        return float(self.matrix[self.names.index(a), self.names.index(b)])


class Result:
    """A result of a command: what `result.json` holds, and every file that is made from it."""

    def __init__(self, stored: _proofmass.StoredResult):
        self._stored = stored

    @kept
    def _document(self) -> dict[str, Any]:
        document: dict[str, Any] = json.loads(self._stored.json())
        return document

    @property
    def kind(self) -> str:
        """Kind of the result, as `kind` in result.json."""
        return str(self._document["kind"])

    @property
    def title(self) -> str:
        """Title of the report."""
        return self._document.get("title") or ""

    @kept
    def estimate(self) -> Estimates:
        """The stated quantities by name."""
        return Estimates([Quantity._of(q) for q in self._document.get("quantities", [])])

    @kept
    def covariance(self) -> Covariance | None:
        """Covariance of the fitted parameters, where there is a joint estimate."""
        written = self._document.get("covariance")
        if not written:
            return None
        matrix = np.array(written["matrix"], dtype=float)
        matrix.flags.writeable = False
        return Covariance(tuple(written["names"]), tuple(written["units"]), matrix)

    @kept
    def findings(self) -> tuple[Finding, ...]:
        """What there is to doubt, the gravest first."""
        return tuple(Finding._of(f) for f in self._document.get("findings", []))

    @property
    def needs_decision(self) -> bool:
        """Whether a finding needs a decision before the result is used."""
        return any(f.severity == "decision" for f in self.findings)

    def uncertain(self, name: str) -> _proofmass.Uncertain:
        """A fitted parameter as a number that carries its causes: two of one result keep their correlation."""
        number = self._stored.uncertain(name)
        if number is None:
            raise KeyError(f"{name!r} is no parameter of the joint estimate")
        return number

    @property
    def calibration(self) -> Calibration | Any:
        """The calibration, where the result is one of a single matrix; else `None`."""
        written = self._stored.calibration()
        if written is None or json.loads(written)["kind"] != "triaxial":
            return None
        return Calibration.from_json(written)

    @kept
    def files(self) -> dict[str, bytes]:
        """Every file that `write` writes, by name, without the list of them."""
        return dict(self._stored.files())

    @property
    def tables(self) -> tuple[str, ...]:
        """Names of the tables."""
        return tuple(name for name in self.files if name.endswith(".csv"))

    def table(self, name: str) -> dict[str, np.ndarray]:
        """A table as arrays by heading: numbers where every field is one, else text."""
        name = name if name.endswith(".csv") else f"{name}.csv"
        if name not in self.files:
            raise DataError(f"the result has no table {name}", hint=f"there are {', '.join(self.tables)}")
        import csv

        rows = list(csv.reader(io.StringIO(self.files[name].decode("utf-8-sig"))))
        return {head: column([row[k] for row in rows[1:]]) for k, head in enumerate(rows[0])}

    def to_dict(self) -> dict[str, Any]:
        """What result.json holds."""
        document: dict[str, Any] = json.loads(self._stored.json())
        return document

    def to_json(self) -> bytes:
        """The bytes of result.json."""
        return self._stored.json()

    def _rows(self) -> dict[str, list[Any]]:
        quantities = self.estimate.values()
        fields = ("name", "unit", "value", "u", "U", "k", "nu", "probability")
        return {field: [getattr(q, field) for q in quantities] for field in fields}

    def to_pandas(self) -> Any:
        """The quantities as a data frame of pandas, a row for each."""
        import pandas  # type: ignore[import-untyped, unused-ignore]

        return pandas.DataFrame(self._rows()).set_index("name")

    def to_polars(self) -> Any:
        """The quantities as a data frame of polars, a row for each."""
        import polars

        return polars.DataFrame(self._rows())

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """The quantities as a stream of Arrow, a row for each."""
        return stream_of(self._rows())

    def html(self) -> str:
        """The report, one page that needs no network."""
        return self._stored.html()

    def write(self, folder: str | os.PathLike[str], *, force: bool = False) -> Path:
        """Writes the folder that the command writes: result.json, report, tables, the list of them.

        It appears whole or not at all. `force` allows a folder that holds other files, which are kept.
        """
        try:
            written = self._stored.write(os.fspath(folder), force)
        except ValueError as error:
            raise OutputError(str(error)) from None
        from pathlib import Path

        return Path(written)

    def plot(self, ax: Any = None) -> Any:
        """Draws the quantities with their intervals, those of one unit on one axis; needs matplotlib."""
        import matplotlib.pyplot as plt

        units: dict[str, list[Quantity]] = {}
        for quantity in self.estimate.values():
            units.setdefault(quantity.unit, []).append(quantity)
        if ax is None:
            _, axes = plt.subplots(len(units), 1, squeeze=False, layout="constrained")
            axes = axes[:, 0]
        else:
            axes, units = np.array([ax]), dict(list(units.items())[:1])
        for axis, (unit, quantities) in zip(axes, units.items(), strict=False):
            values = np.array([q.value for q in quantities])
            ends = np.array([q.interval for q in quantities]).T
            positions = np.arange(len(quantities))
            axis.errorbar(values, positions, xerr=np.abs(ends - values), fmt="o", capsize=3)
            axis.set_yticks(positions, [q.name for q in quantities])
            axis.invert_yaxis()
            axis.set_xlabel(unit)
        return axes[0] if ax is not None else axes

    def __str__(self) -> str:
        return self._stored.text(100)

    def __repr__(self) -> str:
        count = len(self.findings)
        said = f", {count} finding{'s' * (count != 1)}" if count else ""
        return f"<{type(self).__name__} {self.kind}: {len(self.estimate)} quantities{said}>\n{self.estimate!r}"

    def _repr_html_(self) -> str:
        from html import escape

        rows = "".join(
            "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in _cells(q)) + "</tr>" for q in self.estimate.values()
        )
        heads = "".join(f"<th>{head}</th>" for head in ("quantity", "value", "U", "unit", "k", "u", "ν"))
        findings = "".join(
            f"<li><b>{escape(f.severity)}</b> <code>{escape(f.code)}</code> {escape(str(f))}</li>"
            for f in self.findings
        )
        findings = f"<ul>{findings}</ul>" if findings else ""
        # Its lines are dark whatever the page is.
        picture = self._stored.picture()
        picture = f'<div style="background:#fff;max-width:60em">{picture}</div>' if picture else ""
        return f"<h3>{escape(self.title)}</h3><table><tr>{heads}</tr>{rows}</table>{findings}{picture}"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Result) and self.__reduce__()[1] == other.__reduce__()[1]

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return _read, (self._stored.json(), list(self._stored.beside()))

    def __copy__(self) -> Result:
        return self

    def __deepcopy__(self, memo: Any) -> Result:
        return self


def stated(value: float, expanded: float) -> tuple[str, str]:
    """U to two digits and the value to the same place."""
    if not (np.isfinite(expanded) and expanded > 0):
        return f"{value:.9g}", f"{expanded:.2g}"
    place = 1 - int(np.floor(np.log10(float(f"{expanded:.1e}"))))
    if place > 6 or max(abs(value), expanded) >= 1e7:
        power = int(np.floor(np.log10(max(abs(value), expanded))))
        digits = max(0, place + power)
        return f"{value / 10.0**power:.{digits}f}e{power:+03d}", f"{expanded / 10.0**power:.{digits}f}e{power:+03d}"
    place = max(0, place)
    return f"{value:.{place}f}", f"{expanded:.{place}f}"


def _cells(q: Quantity) -> tuple[str, ...]:
    """The cells of a row."""
    value, expanded = (f"{q.value:.6g}", "") if q.U is None else stated(q.value, q.U)
    k, u = ("" if x is None else f"{x:.3g}" for x in (q.k, q.u))
    nu = "∞" if np.isinf(q.nu) else ("> 9999" if q.nu > 9999 else f"{q.nu:.3g}")
    return q.name, value, expanded, q.unit, k, u, nu


def column(fields: list[str]) -> np.ndarray:
    """Fields as numbers where every one is, else as text."""
    try:
        return np.array([float(field) if field else np.nan for field in fields])
    except ValueError:
        return np.array(fields)


def _read(written: bytes, beside: list[tuple[str, bytes]]) -> Result:
    return Result(_proofmass.StoredResult.read(written, beside))


def read(path: str | os.PathLike[str]) -> Result:
    """Reads a result: a result.json, or the folder that holds it."""
    from pathlib import Path

    place = Path(path)
    place = place / "result.json" if place.is_dir() else place
    try:
        written = place.read_bytes()
    except (OSError, ValueError) as error:
        raise DataError(str(error), hint="name a result.json or the folder that holds it") from error
    trials = place.with_name("trials.csv")
    beside = [(trials.name, trials.read_bytes())] if trials.is_file() else []
    try:
        return _read(written, beside)
    except ValueError as error:
        raise DataError(f"{place}: {error}") from error
