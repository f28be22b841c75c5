#!/usr/bin/env python3
"""JSON schemas against the program: `schemas.py PROGRAM TAKES FILE…`.

Every file is taken by its schema. Each is then changed in many places (a key less, a key more, another type, another word), documents are made
from each schema, and schema and program have to agree about every one. Where only the program can refuse, the reason stands in PROGRAM_ALONE.
The validator is that of others (jsonschema, draft 2020-12).
"""

import copy
import datetime
import json
import pathlib
import random
import subprocess
import sys
import tomllib

from jsonschema import Draft202012Validator
from referencing import Registry, Resource

# What no schema says, by words of what the program answers to a document that its schema takes: the last test is the program's.
PROGRAM_ALONE = [
    "unknown unit",
    "is not between 9.7 and 9.9",
    "elements, 2 are needed",
    "is not as long as the table is wide",
]
# What a schema refuses and the program passes over: keys of requests that take those of another beside their own.
SCHEMA_ALONE = {"certificate-request": "no_such_key", "convert-request": "no_such_key"}
# Changes of a document beyond this many are drawn by chance, with a fixed seed; of a large one beyond the second.
MOST, MOST_OF_LARGE, LARGE = 200, 25, 20_000


def main():
    program, takes, *files = sys.argv[1:]
    names = [line.split()[0] for line in run([program, "schema"]).splitlines()]
    schemas = {name: json.loads(run([program, "schema", name])) for name in names}
    registry = Registry().with_resources((s["$id"], Resource.from_contents(s)) for s in schemas.values())
    validators = {}
    for name, schema in schemas.items():
        Draft202012Validator.check_schema(schema)
        validators[name] = Draft202012Validator(schema, registry=registry)

    documents = []
    for file in files:
        name, document = read(pathlib.Path(file))
        documents.append((name, file, document))
        if document.get("kind") == name:
            documents.append(("campaign", file, document))
    for name, schema in schemas.items():
        if name in ("campaign", "request"):
            continue
        for full in (False, True):
            made = example(schema, schema, full)
            documents.append((name, f"made from its schema, {'all keys' if full else 'the keys it needs'}", made))

    asked, given = [], len(documents)
    for name, where, document in documents:
        asked.append((name, where, document, "as it is"))
    for name, where, document in documents:
        if name == "campaign":
            continue
        # Of which kind a campaign is has been decided before its schema is asked.
        changes = [c for c in changes_of(document) if not (document.get("kind") == name and c[0] == ("kind",))]
        most = MOST if len(json.dumps(document)) < LARGE else MOST_OF_LARGE
        if len(changes) > most:
            changes = random.Random(1).sample(changes, most)
        asked.extend((name, where, changed(document, *change), change[-1]) for change in changes)
    lines = "".join(json.dumps({"schema": n, "document": d}) + "\n" for n, _, d, _ in asked)
    answers = subprocess.run([takes, "--take"], input=lines, capture_output=True, text=True, check=True).stdout.split("\n")

    alone, wrong = {}, []
    both = neither = 0
    for (name, where, document, what), why in zip(asked, answers):
        error = next(iter(validators[name].iter_errors(document)), None)
        if (error is None) == (why == ""):
            both += error is None
            neither += error is not None
        elif error is None and any(why.find(begin) >= 0 for begin in PROGRAM_ALONE):
            reason = next(begin for begin in PROGRAM_ALONE if why.find(begin) >= 0)
            alone[reason] = alone.get(reason, 0) + 1
        elif why == "" and what == "/" + SCHEMA_ALONE.get(name, ""):
            alone["keys that a schema alone refuses"] = alone.get("keys that a schema alone refuses", 0) + 1
        else:
            wrong.append(f"{name}: {where}: {what}: schema: {error.json_path + ' ' + error.message[:150] if error else 'takes it'}; program: {why or 'takes it'}")
    for line in wrong[:40]:
        print(line)
    if len(wrong) > 40:
        print(f"… and {len(wrong) - 40} more")
    print(f"{len(schemas)} schemas, {given} documents, {len(asked)} questions: both take {both}, both refuse {neither}, "
          f"one alone refuses {sum(alone.values())} by the rules below, they disagree {len(wrong)}")
    for reason, count in sorted(alone.items()):
        print(f"  {count:5} {reason}")
    sys.exit(bool(wrong))


def run(command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def read(path):
    """The name of the schema of a file, and what it holds."""
    if path.suffix == ".toml":
        document = plain(tomllib.loads(path.read_text()))
    else:
        document = json.loads(path.read_text())
    form = document.get("schema")
    if isinstance(form, dict):
        return form["name"].removeprefix("proofmass."), document
    if "job" in document:
        return document["job"] + "-request", document
    if "kind" in document:
        return document["kind"], document
    for key, name in [("wedge", "modes"), ("mesh", "modes"), ("limit", "limits"), ("output", "model"), ("input", "budget")]:
        if key in document:
            return name, document
    return "laboratory", document


def plain(value):
    """As JSON has it: days as text."""
    if isinstance(value, dict):
        return {k: plain(v) for k, v in value.items()}
    if isinstance(value, list):
        return [plain(v) for v in value]
    if isinstance(value, (datetime.date, datetime.datetime)):
        return value.isoformat()
    return value


def changes_of(document):
    """For every place of a document what can be put there (None: nothing), and what is changed by it."""
    for path, value in places(document):
        where = "/".join(map(str, path))
        if isinstance(value, dict):
            yield (*path, "no_such_key"), 1, f"{where}/no_such_key"
        if path and isinstance(path[-1], str):
            yield path, None, f"without {where}"
        if isinstance(value, str):
            yield path, 17, f"a number at {where}"
            yield path, value + "_no_such_word", f"another word at {where}"
        elif isinstance(value, (bool, int, float)):
            yield path, "word", f"a word at {where}"
            yield path, [value], f"a list at {where}"
        elif isinstance(value, (dict, list)):
            yield path, "word", f"a word at {where}"
            yield path, True, f"true at {where}"


def changed(document, path, value, _):
    if not path:
        return value
    new = copy.deepcopy(document)
    inside = new
    for key in path[:-1]:
        inside = inside[key]
    if value is None:
        del inside[path[-1]]
    else:
        inside[path[-1]] = value
    return new


def places(value, path=()):
    yield path, value
    items = value.items() if isinstance(value, dict) else enumerate(value[:3]) if isinstance(value, list) else ()
    for key, inner in items:
        yield from places(inner, (*path, key))


def example(schema, root, full, depth=0):
    """A document that a schema takes: with the keys that it needs, or with all of them."""
    if schema is True or schema == {}:
        return 1
    if "$ref" in schema:
        name = schema["$ref"].removeprefix("#/$defs/")
        target = root if name == "#" else root["$defs"][name]
        return example(target, root, full, depth + 1)
    for key in ("const", "default"):
        if key in schema and schema[key] is not None and key == "const":
            return schema[key]
    if "enum" in schema:
        return schema["enum"][0]
    made = None
    for key in ("oneOf", "anyOf"):
        if key in schema:
            made = example(schema[key][0], root, full, depth + 1)
    if "allOf" in schema:
        made = made or {}
        for part in schema["allOf"]:
            made.update(example(part, root, full, depth + 1))
    kind = schema.get("type")
    kind = kind[0] if isinstance(kind, list) else kind
    if kind == "object" or "properties" in schema:
        made = made if isinstance(made, dict) else {}
        needed = schema.get("required", [])
        for key, inner in schema.get("properties", {}).items():
            if key in needed or (full and depth < 8):
                made[key] = example(inner, root, full, depth + 1)
        more = schema.get("additionalProperties")
        if full and isinstance(more, dict):
            made["name"] = example(more, root, full, depth + 1)
        return made
    if made is not None:
        return made
    if kind == "array":
        if "prefixItems" in schema:
            return [example(inner, root, full, depth + 1) for inner in schema["prefixItems"]]
        count = schema.get("minItems", 1 if full else 0)
        return [example(schema.get("items", True), root, full, depth + 1) for _ in range(count)]
    return {"number": 1.5, "integer": 2, "string": "word", "boolean": True, "null": None}.get(kind)


if __name__ == "__main__":
    main()
