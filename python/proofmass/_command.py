"""A command of `proofmass` as a function: its keywords become options, its answer an object."""

from __future__ import annotations

import functools
import inspect
import itertools
import json
import os
from collections.abc import Callable, Iterable
from typing import Any, ParamSpec, TypeVar

import numpy as np

from . import _proofmass
from ._answer import answered, results
from ._calibration import Calibration
from ._data import Lent, Recording, is_place, recording
from ._description import WRITTEN, arguments, descriptions, keyword
from ._errors import RequestError, near_to, warn
from ._log import note
from ._result import Finding, Result, column

P = ParamSpec("P")
R = TypeVar("R")


#: The function of every command, by its words.
FUNCTIONS: dict[str, Callable[..., Any]] = {}


def command(words: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Makes a function of a command out of its signature."""

    def wrap(function: Callable[P, R]) -> Callable[P, R]:
        known: list[inspect.Signature] = []

        def quiet(*args: P.args, **kwargs: P.kwargs) -> R:
            if not known:
                known.append(inspect.signature(function))
            signature = known[0]
            for name in kwargs:
                if name not in signature.parameters:
                    near = near_to(name, signature.parameters)
                    meant = f"; did you mean {near!r}?" if near else ""
                    raise TypeError(f"{function.__name__}() got an unexpected keyword argument {name!r}{meant}")
            given = signature.bind(*args, **kwargs).arguments
            return _answer(words, given, signature)  # type: ignore[no-any-return]

        @functools.wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            answer = quiet(*args, **kwargs)
            for result in answer if isinstance(answer, list) else [answer]:
                if isinstance(result, Result):
                    warn(result.findings, level=2)
            return answer

        # The same without warnings of what its result says: for a call among thousands.
        called.quiet = quiet  # type: ignore[attr-defined]
        FUNCTIONS[words] = called
        return called

    return wrap


def _answer(words: str, given: dict[str, Any], signature: inspect.Signature) -> Any:
    watch = given.pop("watch", None)
    lent: list[Lent] = []
    recordings: dict[str, Recording] = {}
    known = {keyword(a): a for a in arguments(words)}
    options: list[str] = []
    positions: list[str] = []
    for name, value in given.items():
        if value is None and signature.parameters[name].default is inspect.Parameter.empty:
            raise RequestError(f"{name} is None: it has to be given")
        if value is None or _is_default(signature.parameters[name].default, value):
            continue
        argument = known[name]
        if argument["kind"] == "path" and argument["id"] in WRITTEN:
            if not is_place(value):
                raise TypeError(f"{name} is a place to write to, not of type {type(value).__name__}")
            value = _text(value)
            if value == "-":
                raise RequestError("- is the output of the command line", hint="name a file")
        elif argument["kind"] == "path":
            value = _places(value, name, lent, recordings, given.get("columns"))
        if argument["position"] is not None:
            positions.extend(value if isinstance(value, list) else [str(value)])
        else:
            options.extend(_option(argument, value))
    options.extend(_assumed(known, given, recordings))
    if words == "apply" and "output" not in given:
        return _applied(words, positions, options, lent, watch)
    asks_json = "output" not in known and any(a["id"] == "json" for a in descriptions()[words]["arguments"])
    if asks_json:
        options.append("--json")
    answer = _said(words, [*options, *_ended(positions)], lent, watch, level=4)
    if found := answer.results:
        return results(found)
    if answer.output:
        return json.loads(answer.output) if asks_json else answer.output.decode()
    if "output" not in given:
        return None
    from pathlib import Path

    return Path(given["output"])


def _said(words: str, options: list[str], lent: list[Lent], watch: Any, level: int) -> _proofmass.Call:
    """Runs it, and warns of what no result says."""
    answer = answered(_proofmass.call([*words.split(), *options], lent, watch), words)
    warn([Finding._of(f) for f in json.loads(answer.findings)], level + 1)
    return answer


def _applied(
    words: str, positions: list[str], options: list[str], lent: list[Lent], watch: Any
) -> dict[str, np.ndarray]:
    """The compensated recording as arrays by heading."""
    import csv
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        place = os.path.join(folder, "compensated.csv")
        _said(words, [*options, f"--output={place}", *_ended(positions)], lent, watch, level=5)
        with open(place, encoding="utf-8", newline="") as file:
            heads = next(csv.reader(file))
            try:
                columns: Any = np.loadtxt(file, delimiter=",", ndmin=2, converters=_number).T
            except ValueError:
                # A column of text, kept as it is.
                file.seek(0)
                rows = list(csv.reader(file))[1:]
                columns = [column(list(fields)) for fields in zip(*rows, strict=True)]
    arrays: dict[str, np.ndarray] = {}
    for head, values in zip(heads, columns, strict=True):
        name = next(n for k in itertools.count(1) if (n := head if k == 1 else f"{head}.{k}") not in arrays)
        arrays[name] = values
    return arrays


def _number(field: str) -> float:
    if "_" in field:
        raise ValueError(field)
    return float(field) if field else float("nan")


def _ended(positions: list[str]) -> list[str]:
    return ["--", *positions] if positions else []


def _places(value: Any, name: str, lent: list[Lent], recordings: dict[str, Recording], columns: Any) -> str | list[str]:
    """The name of a file, or of what is lent in its place; several where there are several."""
    if isinstance(value, list | tuple) and value and all(is_place(v) or not np.isscalar(v) for v in value):
        if not all(_is_number_row(v) for v in value):
            return [_place(v, f"{name}[{k}]", lent, recordings, columns) for k, v in enumerate(value)]
    return _place(value, name, lent, recordings, columns)


def _place(value: Any, name: str, lent: list[Lent], recordings: dict[str, Recording], columns: Any) -> str:
    """The name of one file, or of what is lent in its place."""
    if isinstance(value, str) and "\n" in value:
        value = value.encode()
    if is_place(value):
        return _text(value)
    if isinstance(value, Result | Calibration):
        return _lent((f"{name}.json", b"", memoryview(_document(name, value))), lent)
    found = recording(value, f"{name} in memory", columns)
    recordings[name] = found
    return _lent(found.lent, lent)


def _document(name: str, value: Result | Calibration) -> bytes:
    """What a command reads of an object: its calibration where one is asked for, else all of it."""
    if isinstance(value, Calibration):
        return value.to_json()
    wanted = value.files.get("calibration.json") if name.startswith("calibration") else None
    return value.to_json() if wanted is None else wanted


def _lent(content: Lent, lent: list[Lent]) -> str:
    """The name under which a content is lent, which no other has."""
    (stem, suffix), known = os.path.splitext(content[0]), {name for name, _, _ in lent}
    others = (f"{stem}-{k}{suffix}" for k in itertools.count(2))
    name = next(name for name in itertools.chain([content[0]], others) if name not in known)
    lent.append((name, *content[1:]))
    return name


def _is_number_row(value: Any) -> bool:
    """Whether it is a row of a list of lists, and no recording."""
    return isinstance(value, list | tuple) and all(np.isscalar(v) for v in value)


def _assumed(known: dict[str, Any], given: dict[str, Any], recordings: dict[str, Recording]) -> Iterable[str]:
    """What is agreed of an array without headings: its columns in their order, SI units."""
    for name, found in recordings.items():
        if found.absent and given.get("rate") is not None:
            raise RequestError(
                f"{found.absent} rows of {name} hold a null, and without times a gap has no place",
                hint="give the column of the times instead of rate=",
            )
        if found.absent:
            note("%d rows of %s hold a null and are left out: gaps by their times", found.absent, name)
    unnamed = {found.unnamed for found in recordings.values()}
    counts = [count for count in unnamed if count is not None]
    if not counts:
        return
    if given.get("columns") is None:
        if len(unnamed) > 1:
            raise RequestError("the recordings have different numbers of columns", hint="say columns=…")
        if "columns" in known:
            yield "--columns=" + ",".join(str(k + 1) for k in range(counts[0]))
    if given.get("unit") is None and "unit" in known:
        yield "--unit=m/s²"
    timed = given.get("rate") is not None or given.get("time") is not None
    if "rate" in known and not timed and given.get("rows") != "readings":
        raise RequestError(
            "an array has no times", hint="say rate=… in hertz, or give a dict of arrays with the times among them"
        )


def _is_default(default: Any, value: Any) -> bool:
    if default is inspect.Parameter.empty or type(default) is not type(value):
        return False
    return bool(default == value)


def _text(value: Any) -> str:
    if isinstance(value, bool | np.bool_):
        raise RequestError(f"{value} is neither a number nor a word")
    if is_place(value):
        text = os.fsdecode(value)
        if "\0" in text or any("\ud800" <= c <= "\udfff" for c in text):
            raise RequestError(f"{text!r} is no text that can be passed on", hint="rename the file")
        return text
    if isinstance(value, int | np.integer):
        return str(int(value))
    if isinstance(value, float | np.floating):
        return repr(float(value))
    raise RequestError(f"{value!r} is of type {type(value).__name__}: a number or a word is needed")


def _option(argument: dict[str, Any], value: Any) -> list[str]:
    """An option of the command line, in one piece where it has one value."""
    flag = f"--{argument['long']}"
    if argument["kind"] == "bool":
        if not isinstance(value, bool | np.bool_):
            raise RequestError(f"{keyword(argument)} is True or False, not {value!r}")
        return [flag] if value else []
    if isinstance(value, dict):
        value = [f"{name}={_text(v)}" for name, v in value.items()]
    several = isinstance(value, list | tuple | np.ndarray)
    texts = [_text(v) for v in value] if several else [_text(value)]
    if argument["several"]:
        return [flag, *texts]
    if argument["repeated"] and not argument["delimiter"]:
        return [f"{flag}={text}" for text in texts]
    return [f"{flag}={','.join(texts)}"]
