"""A command of `proofmass` as a function: its keywords become options, its answer an object."""

from __future__ import annotations

import csv
import difflib
import functools
import inspect
import itertools
import json
import logging
import os
import re
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np

from . import _proofmass
from ._calibration import Calibration
from ._data import Lent, Recording, is_place, recording
from ._errors import RequestError, raised, warn
from ._result import Finding, Result, column

P = ParamSpec("P")
R = TypeVar("R")
_log = logging.getLogger("proofmass")


@functools.cache
def descriptions() -> dict[str, dict[str, Any]]:
    """Every command by its words, as the command line declares it."""
    return {" ".join(c["words"]): c for c in json.loads(_proofmass.commands())}


#: Places that a command writes to, which no array can stand for.
WRITTEN = {"output", "draws", "imu_yaml", "plot"}
#: Options that a function has no use for: it returns the object, whose `needs_decision` says the rest.
UNUSED = {"json", "strict"}


def arguments(words: str) -> list[dict[str, Any]]:
    """The arguments of a command that its function takes, those without an option first."""
    known = [a for a in descriptions()[words]["arguments"] if a["id"] not in UNUSED]
    return sorted(known, key=lambda a: (a["position"] is None, a["position"] or 0))


def command(words: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Makes a function of a command out of its signature."""

    def wrap(function: Callable[P, R]) -> Callable[P, R]:
        signature = inspect.signature(function)

        def quiet(*args: P.args, **kwargs: P.kwargs) -> R:
            for name in kwargs:
                if name not in signature.parameters:
                    near = difflib.get_close_matches(name, signature.parameters, 1)
                    meant = f"; did you mean {near[0]!r}?" if near else ""
                    raise TypeError(f"{function.__name__}() got an unexpected keyword argument {name!r}{meant}")
            given = signature.bind(*args, **kwargs).arguments
            return _answer(words, given, signature)  # type: ignore[return-value]

        @functools.wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            answer = quiet(*args, **kwargs)
            for result in answer if isinstance(answer, list) else [answer]:
                if isinstance(result, Result):
                    warn(result.findings, level=2)
            return answer

        # The same without warnings of what its result says: for a call among thousands.
        called.quiet = quiet  # type: ignore[attr-defined]
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
        if value is None or _is_default(signature.parameters[name].default, value):
            continue
        argument = known[name]
        if argument["kind"] == "path" and (argument["id"] in WRITTEN or words == "keygen"):
            if not is_place(value):
                raise TypeError(f"{name} is a place to write to, not of type {type(value).__name__}")
            value = _text(value)
            if value == "-":
                raise RequestError("- is the output of the command line", hint="name a file")
        elif argument["kind"] == "path":
            value = _places(value, name, lent, recordings)
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
    if answer.results:
        results = [Result(stored) for stored in answer.results]
        for result in results:
            for line in result._stored.readings():
                _log.info("read %s", line)
        return results[0] if len(results) == 1 else results
    if answer.output:
        return json.loads(answer.output) if asks_json else answer.output.decode()
    return Path(given["output"]) if "output" in given else None


def _said(words: str, options: list[str], lent: list[Lent], watch: Any, level: int) -> _proofmass.Call:
    """Runs it, tells its notes to the log, warns of what no result says, raises its error."""
    answer = _proofmass.call([*words.split(), *options], lent, watch)
    for note in answer.notes:
        _log.info("%s", note)
    if answer.error is not None:
        kind, what, place, hint = answer.error
        hint = hint and in_keywords(hint, words)
        raise raised((kind, in_keywords(what, words), [in_keywords(p, words) for p in place], hint))
    warn([Finding._of(f) for f in json.loads(answer.findings)], level + 1)
    return answer


def _applied(
    words: str, positions: list[str], options: list[str], lent: list[Lent], watch: Any
) -> dict[str, np.ndarray]:
    """The compensated recording as arrays by heading."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "compensated.csv"
        _said(words, [*options, f"--output={place}", *_ended(positions)], lent, watch, level=5)
        with place.open(encoding="utf-8", newline="") as file:
            heads = next(csv.reader(file))
            try:
                columns = np.loadtxt(file, delimiter=",", ndmin=2, converters=_number).T
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


def _places(value: Any, name: str, lent: list[Lent], recordings: dict[str, Recording]) -> str | list[str]:
    """The name of a file, or of what is lent in its place; several where there are several."""
    if isinstance(value, str) and "\n" in value:
        value = value.encode()
    if is_place(value):
        return _text(value)
    if isinstance(value, Result | Calibration):
        return _lent((f"{name}.json", b"", memoryview(_document(name, value))), lent)
    if isinstance(value, list | tuple) and value and all(is_place(v) or not np.isscalar(v) for v in value):
        if all(is_place(v) for v in value):
            return [_text(v) for v in value]
        if not all(_is_number_row(v) for v in value):
            places: list[str] = []
            for k, v in enumerate(value):
                place = _places(v, f"{name}[{k}]", lent, recordings)
                places.append(place if isinstance(place, str) else place[0])
            return places
    found = recording(value, f"{name} in memory")
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
    name, known = content[0], {n for n, _, _ in lent}
    stem, dot, end = name.rpartition(".")
    for k in itertools.count(2):
        if name not in known:
            break
        name = f"{stem}-{k}{dot}{end}" if dot else f"{content[0]}-{k}"
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
            _log.info("%d rows of %s hold a null and are left out: gaps by their times", found.absent, name)
    plain = [r for r in recordings.values() if r.plain]
    if not plain:
        return
    if len({r.columns for r in recordings.values()}) > 1 and given.get("columns") is None:
        raise RequestError("the recordings have different numbers of columns", hint="say columns=…")
    if given.get("columns") is None and "columns" in known and plain[0].columns is not None:
        yield "--columns=" + ",".join(str(k + 1) for k in range(plain[0].columns))
    if given.get("unit") is None and "unit" in known:
        yield "--unit=m/s²"
    timed = given.get("rate") is not None or given.get("time") is not None
    if "rate" in known and not timed and given.get("rows") != "readings":
        raise RequestError(
            "an array has no times", hint="say rate=… in hertz, or give a dict of arrays with the times among them"
        )


def keyword(argument: dict[str, Any]) -> str:
    """The Python name of an argument."""
    name = (argument["long"] or argument["id"]).replace("-", "_")
    return f"{name}_" if name in ("from", "lambda", "in", "is", "global") else name


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


#: What stays as it is: a call of the command line in quotes.
_CALL = re.compile(r"`proofmass [^`]*`")
_OPTION = re.compile(
    r"--([a-z][a-z0-9]*(?:-[a-z0-9]+)*)(?:[ =](<[^>]*>|[A-Z][A-Z0-9_,…]*(?![a-z])|\"[^\"]*\"|[-+]?\d[\w.,…]*))?"
)


def in_keywords(text: str, words: str | None = None) -> str:
    """A text that names options, in the keywords of a function."""
    known: dict[str, Any] = {}
    if words in descriptions():
        known = {a["long"]: a for a in descriptions()[words]["arguments"]}

    def said(match: re.Match[str]) -> str:
        argument, name, value = known.get(match.group(1)), match.group(1).replace("-", "_"), match.group(2)
        if argument and argument["kind"] == "bool":
            return f"{name}=True" + (f" {value}" if value else "")
        if argument and argument["several"] and value:
            return f"{name}=({value}"
        return f"{name}={value}" if value else f"{name}="

    def options(piece: str) -> str:
        piece = _OPTION.sub(said, piece)
        piece = re.sub(r"=\((<?[A-Z_]+>?) (<?[A-Z_]+>?)", r"=(\1, \2)", piece)
        # A word that an option may have, or a unit, belongs to it.
        choices = {c for a in known.values() for c in a["choices"]} | {"g", "mg", "count", "s", "ms"}
        piece = re.sub(r"(\w+)= ([\w-]+)", lambda m: f'{m[1]}="{m[2]}"' if m[2] in choices else m[0], piece)
        return re.sub(r"(?<![\w-])-o( [A-Z]+)?\b", lambda m: f"output={(m[1] or '').strip()}", piece)

    parts, at = [], 0
    for call in _CALL.finditer(text):
        parts += [options(text[at : call.start()]), call.group()]
        at = call.end()
    return "".join([*parts, options(text[at:])])
