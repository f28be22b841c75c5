"""Tables of others by the stream of the Arrow C data interface, without a package of Arrow."""

from __future__ import annotations

import ctypes
import logging
from typing import Any

import numpy as np

from ._errors import DataError, RequestError

_log = logging.getLogger("proofmass")


class _Schema(ctypes.Structure):
    pass


class _Array(ctypes.Structure):
    pass


class _Stream(ctypes.Structure):
    pass


_Schema._fields_ = [
    ("format", ctypes.c_char_p),
    ("name", ctypes.c_char_p),
    ("metadata", ctypes.c_void_p),
    ("flags", ctypes.c_int64),
    ("n_children", ctypes.c_int64),
    ("children", ctypes.POINTER(ctypes.POINTER(_Schema))),
    ("dictionary", ctypes.POINTER(_Schema)),
    ("release", ctypes.CFUNCTYPE(None, ctypes.POINTER(_Schema))),
    ("private_data", ctypes.c_void_p),
]
_Array._fields_ = [
    ("length", ctypes.c_int64),
    ("null_count", ctypes.c_int64),
    ("offset", ctypes.c_int64),
    ("n_buffers", ctypes.c_int64),
    ("n_children", ctypes.c_int64),
    ("buffers", ctypes.POINTER(ctypes.c_void_p)),
    ("children", ctypes.POINTER(ctypes.POINTER(_Array))),
    ("dictionary", ctypes.POINTER(_Array)),
    ("release", ctypes.CFUNCTYPE(None, ctypes.POINTER(_Array))),
    ("private_data", ctypes.c_void_p),
]
_Stream._fields_ = [
    ("get_schema", ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(_Stream), ctypes.POINTER(_Schema))),
    ("get_next", ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(_Stream), ctypes.POINTER(_Array))),
    ("get_last_error", ctypes.CFUNCTYPE(ctypes.c_char_p, ctypes.POINTER(_Stream))),
    ("release", ctypes.CFUNCTYPE(None, ctypes.POINTER(_Stream))),
    ("private_data", ctypes.c_void_p),
]

#: Numbers by their letter in the interface.
_NUMBERS = {b"c": "i1", b"C": "u1", b"s": "i2", b"S": "u2", b"i": "i4", b"I": "u4", b"l": "i8", b"L": "u8", b"f": "f4", b"g": "f8"}
#: Steps of a time stamp in a second.
_STEPS = {b"s": 1, b"m": 1_000, b"u": 1_000_000, b"n": 1_000_000_000}


def columns_of(table: Any) -> tuple[dict[str, np.ndarray], int]:
    """Columns of numbers by heading, without the rows that hold a null, and how many rows that are.

    A unit in the metadata of a field becomes part of its heading. Time stamps become seconds since 1970.
    """
    capsule = table.__arrow_c_stream__()
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    stream = _Stream.from_address(pointer(capsule, b"arrow_array_stream"))
    schema = _Schema()
    _ask(stream, stream.get_schema(ctypes.byref(stream), ctypes.byref(schema)))
    try:
        if schema.format != b"+s":
            raise RequestError("the stream of Arrow is no table", hint="give a table with columns of numbers")
        fields = [schema.children[k].contents for k in range(schema.n_children)]
        kept = [(k, heading, form) for k, f in enumerate(fields) if (form := _form(f)) and (heading := _heading(f, form))]
        left_out = [f.name.decode() for k, f in enumerate(fields) if k not in {k for k, _, _ in kept}]
        pieces: list[list[np.ndarray]] = [[] for _ in kept]
        absent: list[np.ndarray] = []
        while True:
            array = _Array()
            _ask(stream, stream.get_next(ctypes.byref(stream), ctypes.byref(array)))
            if not array.release:
                break
            try:
                missing = np.zeros(array.length, bool)
                for piece, (k, _, form) in zip(pieces, kept, strict=True):
                    numbers, nulls = _numbers(array.children[k].contents, array.offset, array.length, form)
                    piece.append(numbers)
                    missing |= nulls
                absent.append(missing)
            finally:
                array.release(ctypes.byref(array))
    finally:
        schema.release(ctypes.byref(schema))
    if not kept:
        raise RequestError("the table has no column of numbers")
    if left_out:
        _log.info("columns that hold no numbers are not read: %s", ", ".join(left_out))
    if not absent:
        raise DataError("the table is empty")
    whole = ~np.concatenate(absent)
    columns = {heading: np.concatenate(piece)[whole] for piece, (_, heading, _) in zip(pieces, kept, strict=True)}
    return columns, int((~whole).sum())


def _ask(stream: _Stream, code: int) -> None:
    if code:
        said = stream.get_last_error(ctypes.byref(stream))
        raise DataError(f"the stream of Arrow ends with error {code}" + (f": {said.decode()}" if said else ""))


def _form(field: _Schema) -> tuple[str, int] | None:
    """Type of the numbers and steps in a unit; `None` for what is no number."""
    if field.dictionary:
        return None
    if field.format in _NUMBERS:
        return _NUMBERS[field.format], 1
    if field.format.startswith(b"ts"):
        return "i8", _STEPS[field.format[2:3]]
    return None


def _heading(field: _Schema, form: tuple[str, int]) -> str:
    name, unit = field.name.decode(), _metadata(field).get("unit")
    if field.format.startswith(b"ts"):
        return f"{name}_s"
    return f"{name} ({unit})" if unit else name


def _metadata(field: _Schema) -> dict[str, str]:
    if not field.metadata:
        return {}
    at = field.metadata

    def number() -> int:
        nonlocal at
        value = ctypes.c_int32.from_address(at).value
        at += 4
        return value

    def text() -> str:
        nonlocal at
        length = number()
        value = ctypes.string_at(at, length).decode("utf-8", "replace")
        at += length
        return value

    return {text(): text() for _ in range(number())}


def _numbers(array: _Array, offset: int, length: int, form: tuple[str, int]) -> tuple[np.ndarray, np.ndarray]:
    """Copies of the numbers of a column, and which are null."""
    kind, steps = np.dtype(form[0]), form[1]
    start = array.offset + offset
    nulls = np.zeros(length, bool)
    if length == 0:
        return np.zeros(0), nulls
    if array.null_count != 0 and array.buffers[0]:
        bits = np.frombuffer(ctypes.string_at(array.buffers[0], (start + length + 7) // 8), np.uint8)
        nulls = np.unpackbits(bits, bitorder="little")[start : start + length] == 0
    address = array.buffers[1] + start * kind.itemsize
    numbers = np.frombuffer(ctypes.string_at(address, length * kind.itemsize), kind)
    return (numbers if steps == 1 else numbers / steps), nulls
