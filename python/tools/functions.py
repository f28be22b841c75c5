"""Writes the functions of the package from the commands that the compiled part declares.

    python tools/functions.py [--check]

With --check nothing is written, and the first file that differs is named.
"""

from __future__ import annotations

import json
import re
import sys
import textwrap
import types
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "proofmass"

# The package without what is written here, which may be missing or out of date.
bare = types.ModuleType("proofmass")
bare.__path__ = [str(PACKAGE)]
sys.modules["proofmass"] = bare

from proofmass._description import WRITTEN, arguments, descriptions, keyword  # noqa: E402
from proofmass._wording import in_keywords  # noqa: E402

#: Commands whose answers are no result of their own.
ANSWERS = {
    "init": "Path",
    "plan": "Result | Any",
    "apply": "dict[str, np.ndarray] | Any",
    "export": "str | Any",
    "filter": "str | Any",
    "import": "Path | None",
    "convert": "Path",
    "inspect": "dict[str, Any]",
    "formats": "list[dict[str, Any]]",
    "explain": "Any",
    "verify": "dict[str, Any]",
    "keygen": "str",
    "certificate read": "dict[str, Any]",
    "certificate check": "list[str]",
    "certificate template": "str",
    "calibrate": "Result | Any",
    **dict.fromkeys((words for words in descriptions() if words.startswith("simulate ")), "Path"),
    **dict.fromkeys((words for words in descriptions() if words.startswith("records ")), "Any"),
}
GROUPS = {
    "velocity": "Velocity of an axis from encoder and accelerometer.",
    "simulate": "Recordings whose truth is known.",
    "test": "Tests of accelerometers: static, thermal, dynamic.",
    "records": "Devices, standards and results over time.",
}
#: Names that Python keeps for itself.
RENAMED = {"import": "import_"}
HEAD = '''"""{title}

Written by tools/functions.py from the options of the commands: change those, not this.
"""

from __future__ import annotations

{imports}from ._command import command
{result}from ._types import Data, Names, Place, Watch

{late}__all__ = {names}


def __dir__() -> Names:
    return __all__
'''

#: Columns by name or number, and what is typed as numbers with commas.
COLUMNS = {"time", "temperature", "column", "input", "output_column", "reference", "reference_time", "acceleration"}
NUMBERS = {"band", "frequencies", "taus", "still", "between"}


def annotation(argument: dict) -> str:
    """The type of a keyword."""
    kind = argument["kind"]
    if kind == "bool":
        return "bool"
    if kind == "path":
        one = "Place" if argument["id"] in WRITTEN else "Data"
        many = argument["repeated"] or argument["several"]
        return f"Sequence[{one}] | {one}" if many else one
    one = {"float": "float", "int": "int", "str": "str"}[kind]
    if argument["several"]:
        return f"Sequence[{one}]"
    if argument["delimiter"] or argument["repeated"] or argument["id"] == "columns":
        plain = one if one == "str" else f"{one} | str"
        return f"{plain} | Sequence[str | int | float]" if one == "str" else f"{plain} | Sequence[{one}]"
    if argument["id"] in COLUMNS:
        return "str | int"
    return "str | Sequence[float]" if argument["id"] in NUMBERS else one


def default(argument: dict) -> str | None:
    """The default of a keyword as Python writes it; `None` where the argument is needed."""
    values = argument["defaults"]
    if argument["kind"] == "bool":
        return "False"
    if not values:
        return None if argument["required"] else "None"
    single = len(values) == 1 and not argument["delimiter"] and argument["id"] not in NUMBERS
    if argument["kind"] in ("float", "int") and single:
        return values[0]
    return json.dumps(",".join(values).strip(","), ensure_ascii=False)


def wrapped(text: str, indent: int, width: int = 118) -> str:
    """Paragraphs of a docstring."""
    pad = " " * indent
    paragraphs = text.strip().split("\n\n")
    lines = []
    for paragraph in paragraphs:
        if any(line.startswith("    ") for line in paragraph.splitlines()):
            lines.append("\n".join(pad + line if line else "" for line in paragraph.splitlines()))
        else:
            lines.append(
                textwrap.fill(paragraph, width, initial_indent=pad, subsequent_indent=pad, break_on_hyphens=False)
            )
    return "\n\n".join(lines)


def function(words: str, name: str) -> str:
    """The code of one function."""
    described = descriptions()[words]
    known = arguments(words)
    positional = [a for a in known if a["position"] is not None]
    keywords = [a for a in known if a["position"] is None]
    keywords.sort(key=lambda a: default(a) is not None)
    lines = []
    for argument in [*positional, "*", *keywords]:
        if argument == "*":
            lines.append("    *,")
            continue
        value, kind = default(argument), annotation(argument)
        # A calibration and a recording come first, what may be left out is a keyword that is.
        if words == "apply" and argument["id"] == "output":
            value = "None"
        # Nothing is written where nobody said so.
        if words == "init" and argument["id"] == "output":
            value = None
        if value is None:
            kind = kind.removesuffix(" | None")
            lines.append(f"    {keyword(argument)}: {kind},")
        else:
            kind = f"{kind} | None" if value == "None" else kind
            lines.append(f"    {keyword(argument)}: {kind} = {value},")
    lines.append("    watch: Watch | None = None,")
    # What must be given stands before what need not, also among the keywords.
    star = lines.index("    *,")
    lines[star + 1 :] = sorted(lines[star + 1 :], key=lambda line: " = " in line)
    about = in_keywords(described["long"] or described["about"] or "", words).replace("\\", "\\\\")
    first, _, rest = about.partition("\n\n")
    first = " ".join(first.split())
    doc = [textwrap.fill(first, 118, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False).lstrip()]
    if not doc[0].endswith((".", ":")):
        doc[0] += "."
    if rest:
        doc.append(wrapped(rest, 4))
    entries = []
    for argument in positional + keywords:
        text = argument["long_help"] or argument["help"] or ""
        text = " ".join(in_keywords(text.replace(" and more with --help", ""), words).split()).replace("\\", "\\\\")
        if argument["id"] == "output" and "[default:" in text:
            text = text[: text.index("[default:")] + "[default: none is written]"
        choices = (
            f" One of {', '.join(argument['choices'])}." if argument["choices"] and argument["kind"] != "bool" else ""
        )
        text = text.rstrip(".") + "." + choices
        entries.append(
            textwrap.fill(
                f"{keyword(argument)}: {text}",
                118,
                initial_indent="        ",
                subsequent_indent="            ",
                break_on_hyphens=False,
            )
        )
    if words == "apply":
        entries.append("        Without an output the compensated recording comes back as arrays by heading.")
    entries.append(
        "        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command."
    )
    doc.append("    Args:\n" + "\n".join(entries))
    answer = ANSWERS.get(words, "Result")
    body = "\n\n".join(doc)
    return (
        f'@command("{words}")\ndef {name}(\n' + "\n".join(lines) + f"\n) -> {answer}:\n"
        f'    """{body}\n    """\n    raise NotImplementedError\n'
    )


#: What a function may need beside the package, and how that is told.
IMPORTS = {
    "Sequence[": "from collections.abc import Sequence\n",
    "Any": "from typing import Any\n\n",
    "np.": "import numpy as np\n\n",
}
#: What only types need, and takes long to begin.
LATE = "if TYPE_CHECKING:\n    from pathlib import Path\n\n"


def module(title: str, functions: dict[str, str]) -> str:
    """The code of a module: names of functions and the commands behind them."""
    names = "[\n" + "".join(f'    "{name}",\n' for name in sorted(functions)) + "]"
    code = "".join(f"\n\n{function(words, name)}" for name, words in functions.items())
    needed = "".join(line for word, line in IMPORTS.items() if re.search(rf"\b{re.escape(word)}", code))
    needed = needed.rstrip("\n") + "\n\n"
    late = LATE if "Path" in code else ""
    if late:
        typing = (
            "from typing import TYPE_CHECKING, Any"
            if "typing import Any" in needed
            else "from typing import TYPE_CHECKING"
        )
        needed = needed.replace("from typing import Any", typing)
        needed = needed if "TYPE_CHECKING" in needed else f"{needed.strip()}\n{typing}\n\n".lstrip()
    result = "from ._result import Result\n" if re.search(r"-> .*\bResult\b", code) else ""
    return HEAD.format(title=title, names=names, imports=needed, late=late, result=result) + code


def modules() -> dict[str, str]:
    """Every file that is written, by name."""
    grouped: dict[str, dict[str, str]] = {group: {} for group in GROUPS}
    plain: dict[str, str] = {}
    for words in descriptions():
        first, *others = words.split()
        if first in GROUPS and others:
            name = "_".join(others).replace("-", "_")
            grouped[first][RENAMED.get(name, name)] = words
        else:
            name = "_".join([first, *others]).replace("-", "_")
            plain[RENAMED.get(name, name)] = words
    files = {"_commands.py": module("The commands of `proofmass` as functions.", plain)}
    for group, functions in grouped.items():
        files[f"{group}.py"] = module(GROUPS[group], functions)
    return files


def main() -> None:
    for name, text in modules().items():
        place = PACKAGE / name
        if "--check" in sys.argv:
            if not place.is_file() or place.read_text(encoding="utf-8") != text:
                sys.exit(f"{place} is not what the commands declare: python tools/functions.py writes it")
        else:
            place.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
