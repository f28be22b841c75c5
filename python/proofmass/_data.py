"""Data that is in memory already, as a recording that a command reads."""

from __future__ import annotations

import io
import math
import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._arrow import STAMPED, columns_of, since_first
from ._errors import DataError, RequestError
from ._numbers import finite, real

#: A name, the bytes before the numbers, the numbers.
Lent = tuple[str, bytes, Any]


@dataclass(frozen=True)
class Recording:
    """A recording that was lent, and what has to be said of it."""

    lent: Lent
    #: How many columns it has, where no heading says their names and units.
    unnamed: int | None = None
    #: How many rows with a null were left out.
    absent: int = 0


def is_place(data: Any) -> bool:
    """Whether it is the name of a file or folder."""
    return isinstance(data, str | os.PathLike)


def recording(data: Any, name: str, columns: Any = None) -> Recording:
    """An array, arrays by name, a table, a file object or bytes as a recording of this name.

    `columns` are those that are asked for: of a plain array they are the names of its channels.
    """
    if isinstance(data, bytes | bytearray | memoryview):
        return Recording((name, b"", memoryview(data).cast("B")))
    if hasattr(data, "read"):
        try:
            content = data.read()
            content = content.encode() if isinstance(content, str) else content
        except (ValueError, OSError) as error:
            raise DataError(f"{name} cannot be read: {error}") from error
        if not isinstance(content, bytes | bytearray | memoryview):
            raise RequestError(f"{name}.read() gave {type(content).__name__}, not bytes")
        return Recording((_named(data, name), b"", memoryview(content)))
    absent, asked = 0, columns
    # A frame of pandas has its columns at hand, and exports them only with another package.
    if hasattr(data, "__arrow_c_stream__") and not (hasattr(data, "iloc") or hasattr(data, "to_frame")):
        columns, absent = columns_of(data)
    else:
        columns = named_columns(data)
        if hasattr(data, "iloc") and columns is not None:
            columns, absent = _without_nulls(columns)
    if columns is not None:
        return Recording(_by_name(columns, name), absent=absent)
    return _array(data, name, asked)


def _named(data: Any, name: str) -> str:
    given = getattr(data, "name", None)
    given = os.path.basename(given) if isinstance(given, str) else ""
    return given if given not in ("", "-") else name


def _frame_of_pandas(frame: Any) -> dict[str, Any]:
    """Columns of a frame of pandas, the times of its index before them."""
    columns = {str(name): frame[name] for name in frame.columns}
    index = frame.index
    if index.name is not None or getattr(index.dtype, "kind", "O") in "mM" or hasattr(index.dtype, "tz"):
        name = str(index.name) if index.name is not None else "time"
        if name in columns:
            raise RequestError(f"index and column of the frame are both named {name!r}", hint="rename one of them")
        columns = {name: index.to_series(), **columns}
    return columns


def named_columns(data: Any) -> Mapping[str, Any] | None:
    """The columns of a mapping, of a data frame, of a table of Arrow, of an array with fields; `None` for a plain array."""
    if isinstance(data, Mapping):
        columns = {str(k): v for k, v in data.items()}
        if len(columns) < len(data):
            raise RequestError("two columns have one name, as a number and as a word", hint="rename one of them")
        return columns
    if isinstance(data, np.ndarray) and data.dtype.names:
        return {name: data[name] for name in data.dtype.names}
    if hasattr(data, "iloc") and hasattr(data, "columns"):
        return _frame_of_pandas(data)
    if hasattr(data, "iloc") or hasattr(data, "to_frame"):
        # One column with its name, if it has one.
        return named_columns(data.to_frame()) if getattr(data, "name", None) else None
    if hasattr(type(data), "collect") and hasattr(type(data), "columns"):
        raise RequestError(f"{type(data).__name__} is not evaluated", hint="give .collect() of it")
    if hasattr(data, "columns") and hasattr(data, "__getitem__") and not isinstance(data, np.ndarray):
        names = getattr(data, "column_names", None) or list(data.columns)
        return {str(name): data[name] for name in names}
    return None


def _by_name(columns: Mapping[str, Any], name: str) -> Lent:
    """Columns with names, once copied, as an archive of arrays."""
    if not columns:
        raise RequestError(f"{name} has no columns")
    arrays, length = {}, None
    for heading, values in columns.items():
        array, heading = _seconds(values_of(values), heading)
        if heading in arrays or "\0" in heading or len(heading) > 1000:
            raise RequestError(f"{heading[:60]!r} cannot be the name of one more column", hint="rename it")
        array = _numbers(array, f"{name}[{heading!r}]")
        if array.ndim != 1:
            raise RequestError(f"{name}[{heading!r}] has shape {array.shape}, not one dimension")
        if length is not None and len(array) != length[1]:
            raise RequestError(f"{name}[{heading!r}] has {len(array)} values, {name}[{length[0]!r}] has {length[1]}")
        length = length or (heading, len(array))
        arrays[heading] = array
    if length is None or length[1] == 0:
        raise DataError(f"{name} is empty")
    import zipfile

    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for heading, array in arrays.items():
            with archive.open(zipfile.ZipInfo(f"{heading}.npy"), "w", force_zip64=True) as file:
                np.lib.format.write_array(file, array, allow_pickle=False)
    return name, b"", content.getbuffer()


def values_of(values: Any) -> np.ndarray:
    """A column as an array; dates with a zone are those of UTC."""
    if np.ma.isMaskedArray(values):
        return values
    if getattr(getattr(values, "dtype", None), "tz", None) is not None:
        return np.asarray(values, dtype="datetime64[ns]")
    return np.asarray(values.to_numpy() if hasattr(values, "to_numpy") else values)


def _without_nulls(columns: dict[str, Any]) -> tuple[dict[str, Any], int]:
    """Columns of a frame without the rows that hold `<NA>`, and how many these are.

    NaN is a number that is none, and is told later.
    """
    absent = None
    for values in columns.values():
        if not isinstance(getattr(values, "dtype", None), np.dtype) and hasattr(values, "isna"):
            missing = np.asarray(values.isna(), dtype=bool)
            absent = missing if absent is None else absent | missing
    if absent is None or not absent.any():
        return columns, 0
    kept = {name: values[~absent] for name, values in columns.items()}
    numbers = {}
    for name, values in kept.items():
        is_nullable = not isinstance(values.dtype, np.dtype) and getattr(values.dtype, "tz", None) is None
        numbers[name] = (
            values.astype(values.dtype.numpy_dtype) if is_nullable and hasattr(values.dtype, "numpy_dtype") else values
        )
    return numbers, int(absent.sum())


def _seconds(array: np.ndarray, heading: str) -> tuple[np.ndarray, str]:
    """Dates as seconds since the first, spans of time as seconds."""
    if array.dtype.kind not in "mM":
        return array, heading
    if np.isnat(array).any():
        raise DataError(f"{heading!r} has a date that is none, at index {int(np.argmax(np.isnat(array)))}")
    unit, count = np.datetime_data(array.dtype)
    if unit == "generic":
        raise RequestError(f"{heading!r} has spans of time without a unit")
    if unit in ("Y", "M") or (unit not in _STEPS and unit not in ("W", "D", "h", "m")):
        array, unit, count = array.astype(f"{array.dtype.kind}8[s]"), "s", 1
    whole = array.astype(np.int64)
    if unit in ("W", "D", "h", "m"):
        whole, unit = whole * {"W": 604_800, "D": 86_400, "h": 3600, "m": 60}[unit], "s"
    whole = whole * count
    steps = _STEPS[unit]
    seconds = whole / steps if array.dtype.kind == "m" else since_first(whole, steps)
    return seconds, heading + STAMPED


#: Steps of dates and spans in a second.
_STEPS = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}


def _numbers(array: np.ndarray, name: str) -> np.ndarray:
    """Numbers in a form that is read without a copy: floats as they are, integers and Booleans as float64."""
    array = real(array, name)
    wanted = array.dtype.newbyteorder("<") if array.dtype in (np.float64, np.float32) else np.dtype("<f8")
    if math.prod(array.shape) > sys.maxsize // 16 or _stride_trick(array):
        raise RequestError(
            f"{name} claims {math.prod(array.shape)} numbers that stand in less memory", hint="copy it first"
        )
    array = np.ascontiguousarray(array, dtype=wanted)
    finite(array, name)
    return array


def _stride_trick(array: np.ndarray) -> bool:
    """Whether a large array shows the same memory many times."""
    reach = sum((n - 1) * abs(s) for n, s in zip(array.shape, array.strides, strict=True)) + array.itemsize
    return array.size > 1 << 24 and array.nbytes > reach


def _names(channels: int, asked: Any, name: str) -> list[str]:
    """Names of the channels of an array: those that are asked for by as many words, else x, y, z."""
    if isinstance(asked, str):
        asked = asked.split(",")
    words = [w.strip() for w in asked if isinstance(w, str)] if isinstance(asked, list | tuple) else []
    if len(words) == channels == len(set(words)) and not any(w.isdecimal() or not w for w in words):
        if channels > 1 and sorted(words) == list(_AXES[:channels]) and words != sorted(words):
            raise RequestError(
                f"the channels of {name} are x, y, z in this order, not {', '.join(words)}",
                hint="put the columns of the array in order, or choose them by number, such as columns=(3, 2, 1)",
            )
        return words
    if channels == 1:
        return ["column"]
    return list(_AXES) if channels == 3 else [f"column{k + 1}" for k in range(channels)]


_AXES = ("x", "y", "z")


def _array(data: Any, name: str, asked: Any) -> Recording:
    """A plain array: one channel, or a row for each sample."""
    try:
        array = np.asanyarray(data)
    except (ValueError, TypeError) as error:
        raise RequestError(f"{name} is of type {type(data).__name__}, which is no array") from error
    if array.ndim not in (1, 2):
        raise RequestError(f"{name} has shape {array.shape}", hint="give it shape (n,) or (n, channels)")
    if array.size == 0:
        raise DataError(f"{name} is empty")
    if array.ndim == 2 and array.shape[1] > array.shape[0]:
        raise RequestError(
            f"{name} has shape {array.shape}: {array.shape[0]} samples of {array.shape[1]} channels",
            hint="give a row for each sample, such as array.T",
        )
    array = _numbers(array, name)
    channels = 1 if array.ndim == 1 else array.shape[1]
    names = _names(channels, asked, name)
    # Rows of channels lie in memory as records of fields do.
    fields = [(heading, array.dtype.str) for heading in names]
    described = repr({"descr": fields, "fortran_order": False, "shape": (len(array),)}) + "\n"
    text = described.encode()
    head = b"\x93NUMPY\x03\x00" + len(text).to_bytes(4, "little") + text
    return Recording((name, head, array.reshape(-1).data.cast("B")), channels)
