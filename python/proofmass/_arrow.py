"""Tables of others by the stream of the Arrow C data interface, without a package of Arrow."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy as np

from ._errors import DataError, RequestError
from ._log import note


class _Schema(ctypes.Structure):
    if TYPE_CHECKING:
        format: Any
        name: Any
        metadata: Any
        flags: Any
        n_children: Any
        children: Any
        dictionary: Any
        release: Any
        private_data: Any


class _Array(ctypes.Structure):
    if TYPE_CHECKING:
        length: Any
        null_count: Any
        offset: Any
        n_buffers: Any
        n_children: Any
        buffers: Any
        children: Any
        dictionary: Any
        release: Any
        private_data: Any


class _Stream(ctypes.Structure):
    if TYPE_CHECKING:
        get_schema: Any
        get_next: Any
        get_last_error: Any
        release: Any
        private_data: Any


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
_NUMBERS = {
    b"b": "bits",
    b"e": "f2",
    b"c": "i1",
    b"C": "u1",
    b"s": "i2",
    b"S": "u2",
    b"i": "i4",
    b"I": "u4",
    b"l": "i8",
    b"L": "u8",
    b"f": "f4",
    b"g": "f8",
}
#: Steps of a time stamp in a second.
_STEPS = {b"s": 1, b"m": 1_000, b"u": 1_000_000, b"n": 1_000_000_000}


#: What the heading of dates becomes.
STAMPED = "_s"


def since_first(stamps: np.ndarray, steps: int) -> np.ndarray:
    """Seconds since the first of some stamps in whole steps: of the date itself a number of seconds would round them."""
    return (stamps - stamps[0]) / steps if len(stamps) else stamps.astype(float)


def columns_of(table: Any) -> tuple[dict[str, np.ndarray], int]:
    """Columns of numbers by heading, without the rows that hold a null, and how many rows that are.

    A unit in the metadata of a field becomes part of its heading. Time stamps become seconds since the first.
    """
    capsule = table.__arrow_c_stream__()
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    stream = _Stream.from_address(pointer(capsule, b"arrow_array_stream"))
    if not stream.release:
        raise DataError("the stream of Arrow was read before", hint="give the table again")
    schema = _Schema()
    _ask(stream, stream.get_schema(ctypes.byref(stream), ctypes.byref(schema)))
    try:
        if schema.format != b"+s":
            raise RequestError("the stream of Arrow is no table", hint="give a table with columns of numbers")
        fields = [schema.children[k].contents for k in range(schema.n_children)]
        kept = [
            (k, heading, form) for k, f in enumerate(fields) if (form := _form(f)) and (heading := _heading(f, form))
        ]
        left_out = [f.name.decode() for k, f in enumerate(fields) if k not in {k for k, _, _ in kept}]
        pieces: list[list[np.ndarray]] = [[] for _ in kept]
        absent: list[np.ndarray] = []
        while True:
            array = _Array()
            _ask(stream, stream.get_next(ctypes.byref(stream), ctypes.byref(array)))
            if not array.release:
                break
            try:
                missing = _nulls(array, array.offset, array.length)
                for piece, (k, _, form) in zip(pieces, kept, strict=True):
                    numbers, nulls = _numbers(array.children[k].contents, array.offset, array.length, form[0])
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
        note("columns that hold no numbers are not read: %s", ", ".join(left_out))
    if not absent:
        raise DataError("the table is empty")
    whole = ~np.concatenate(absent)
    columns: dict[str, np.ndarray] = {}
    for piece, (_, heading, (_, steps)) in zip(pieces, kept, strict=True):
        if heading in columns:
            raise RequestError(f"two columns of the table are called {heading!r}", hint="rename one of them")
        numbers = np.concatenate(piece)[whole]
        columns[heading] = numbers if steps is None else since_first(numbers, steps)
    return columns, int((~whole).sum())


def _ask(stream: _Stream, code: int) -> None:
    if code:
        said = stream.get_last_error(ctypes.byref(stream))
        raise DataError(f"the stream of Arrow ends with error {code}" + (f": {said.decode()}" if said else ""))


def _form(field: _Schema) -> tuple[str, int | None] | None:
    """Type of the numbers, and of dates their steps in a second; `None` for what is no number."""
    if field.dictionary:
        return None
    if field.format in _NUMBERS:
        return _NUMBERS[field.format], None
    if field.format.startswith(b"ts"):
        return "i8", _STEPS[field.format[2:3]]
    return None


def _heading(field: _Schema, form: tuple[str, int | None]) -> str:
    name: str = field.name.decode()
    unit = _metadata(field).get("unit")
    if form[1] is not None:
        return name + STAMPED
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


def _numbers(array: _Array, offset: int, length: int, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Copies of the numbers of a column, and which are null."""
    start = array.offset + offset
    nulls = _nulls(array, start, length)
    if length == 0:
        return np.zeros(0), nulls
    if kind == "bits":
        return _bits(array.buffers[1], start, length).astype(float), nulls
    size = np.dtype(kind).itemsize
    return np.frombuffer(ctypes.string_at(array.buffers[1] + start * size, length * size), kind), nulls


def _bits(address: int, start: int, length: int) -> np.ndarray:
    bits = np.frombuffer(ctypes.string_at(address, (start + length + 7) // 8), np.uint8)
    return np.unpackbits(bits, bitorder="little")[start : start + length]


def _nulls(array: _Array, start: int, length: int) -> np.ndarray:
    """Which rows are null."""
    if length == 0 or array.null_count == 0 or not array.n_buffers or not array.buffers[0]:
        return np.zeros(length, bool)
    null: np.ndarray = _bits(array.buffers[0], start, length) == 0
    return null


#: What a consumer holds, by the address of its structure, until it releases it.
_held: dict[int, Any] = {}
_python = ctypes.pythonapi
_Destructor = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
_python.PyCapsule_New.restype = ctypes.py_object
_python.PyCapsule_New.argtypes = [ctypes.c_void_p, ctypes.c_char_p, _Destructor]
_pointer_of = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p)(("PyCapsule_GetPointer", _python))


def _released(pointer: Any) -> None:
    """Forgets a structure; a consumer that moved it elsewhere has another address, so the private number is the key."""
    structure = pointer.contents
    for k in range(getattr(structure, "n_children", 0)):
        child = structure.children[k]
        # One that was moved has none any more.
        if child.contents.release:
            child.contents.release(child)
    if structure.private_data:
        _held.pop(structure.private_data, None)
    structure.release = type(structure.release)()


_release_schema = _Schema._fields_[7][1](_released)
_release_array = _Array._fields_[8][1](_released)
_release_stream = _Stream._fields_[3][1](_released)
_keys = iter(range(1, 1 << 62))


def _hold(structure: Any, release: Any, kept: Any) -> None:
    key = next(_keys)
    structure.private_data, structure.release = key, release
    _held[key] = kept


@_Destructor  # type: ignore[untyped-decorator]
def _dropped(capsule: int) -> None:
    """Releases a stream that nobody took."""
    stream = _Stream.from_address(_pointer_of(capsule, b"arrow_array_stream"))
    if stream.release:
        stream.release(ctypes.byref(stream))
    _held.pop(-ctypes.addressof(stream), None)


def stream_of(columns: dict[str, list[Any]]) -> Any:
    """A capsule with the stream of a table: floats, and text where a column holds any; `None` is null."""
    stream = _Stream()

    def get_schema(_: Any, out: Any) -> int:
        _fill_schema(out.contents, columns)
        return 0

    given = False

    def get_next(_: Any, out: Any) -> int:
        nonlocal given
        if given:
            out.contents.release = type(out.contents.release)()
        else:
            _fill_table(out.contents, columns)
        given = True
        return 0

    def get_last_error(_: Any) -> None:
        return None

    stream.get_schema = kept_schema = _Stream._fields_[0][1](get_schema)
    stream.get_next = kept_next = _Stream._fields_[1][1](get_next)
    stream.get_last_error = kept_error = _Stream._fields_[2][1](get_last_error)
    _hold(stream, _release_stream, (kept_schema, kept_next, kept_error))
    # The structure itself stands until the capsule goes.
    _held[-ctypes.addressof(stream)] = stream
    return _python.PyCapsule_New(ctypes.addressof(stream), b"arrow_array_stream", _dropped)


def _is_text(values: list[Any]) -> bool:
    return any(isinstance(v, str) for v in values)


def _fill_schema(schema: _Schema, columns: dict[str, list[Any]]) -> None:
    fields = (ctypes.POINTER(_Schema) * len(columns))()
    kept: list[Any] = [fields]
    for k, (name, values) in enumerate(columns.items()):
        field = _Schema(b"U" if _is_text(values) else b"g", name.encode(), None, 2, 0)
        _hold(field, _release_schema, None)
        fields[k] = ctypes.pointer(field)
        kept.append(field)
    schema.format, schema.name, schema.metadata, schema.flags = b"+s", b"", None, 0
    schema.n_children, schema.children, schema.dictionary = len(columns), fields, None
    _hold(schema, _release_schema, kept)


def _fill_table(table: _Array, columns: dict[str, list[Any]]) -> None:
    rows = len(next(iter(columns.values()), []))
    children = (ctypes.POINTER(_Array) * len(columns))()
    kept: list[Any] = [children]
    for k, values in enumerate(columns.values()):
        child, buffers = _column(values)
        children[k] = ctypes.pointer(child)
        kept += [child, buffers]
    no_mask = (ctypes.c_void_p * 1)(None)
    table.length, table.null_count, table.offset, table.n_buffers = rows, 0, 0, 1
    table.buffers = ctypes.cast(no_mask, ctypes.POINTER(ctypes.c_void_p))
    table.n_children, table.children, table.dictionary = len(columns), children, None
    _hold(table, _release_array, [*kept, no_mask])


def _column(values: list[Any]) -> tuple[_Array, Any]:
    present = np.array([v is not None for v in values], bool)
    mask = np.packbits(present, bitorder="little")
    arrays = [mask]
    if _is_text(values):
        texts = [b"" if v is None else str(v).encode() for v in values]
        arrays.append(np.concatenate([[0], np.cumsum([len(t) for t in texts])]).astype(np.int64))
        arrays.append(np.frombuffer(b"".join(texts) or b"\0", np.uint8))
    else:
        arrays.append(np.array([0.0 if v is None else float(v) for v in values]))
    pointers = (ctypes.c_void_p * len(arrays))(*(a.ctypes.data for a in arrays))
    child = _Array(len(values), int((~present).sum()), 0, len(arrays), 0)
    child.buffers = ctypes.cast(pointers, ctypes.POINTER(ctypes.c_void_p))
    _hold(child, _release_array, (arrays, pointers))
    return child, (arrays, pointers)
