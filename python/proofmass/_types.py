"""Types of what functions are given."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any, BinaryIO

from numpy.typing import ArrayLike

#: A file by its name, an array, arrays by name, a table with columns, a file object, the bytes of a file.
Data = str | os.PathLike[str] | ArrayLike | Mapping[str, ArrayLike] | BinaryIO | bytes | Any
#: A place in the file system.
Place = str | os.PathLike[str]
#: Told the stage, the steps behind and the steps in all (0: unknown); what it raises stops the command.
Watch = Callable[[str, int, int], object]
#: Names of a module; one may have a function `list` of its own.
Names = list[str]
