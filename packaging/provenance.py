#!/usr/bin/env python3
"""How the packages came to be: `provenance.py FOLDER TARGETS FEATURES` writes an in-toto statement with SLSA provenance 1.0 of every file in the folder.

It holds no time and no name of a machine, so that the same commit gives the same bytes.
"""

import hashlib
import json
import pathlib
import subprocess
import sys
import tomllib

FOLDER, TARGETS, FEATURES = pathlib.Path(sys.argv[1]), sys.argv[2].split(","), sys.argv[3].split(",")


def said(*command):
    return subprocess.check_output(command, text=True).strip()


def digest(file):
    return hashlib.sha256(file.read_bytes()).hexdigest()


package = tomllib.loads(pathlib.Path("Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]
source = f"git+{package['repository']}"
changed = said("git", "status", "--porcelain", "--untracked-files=no")
if changed:
    print(f"files differ from the commit, and the provenance says so:\n{changed}", file=sys.stderr)
statement = {
    "_type": "https://in-toto.io/Statement/v1",
    "subject": [{"name": f.name, "digest": {"sha256": digest(f)}} for f in sorted(FOLDER.iterdir())],
    "predicateType": "https://slsa.dev/provenance/v1",
    "predicate": {
        "buildDefinition": {
            "buildType": f"{package['repository']}/blob/main/docs/packages.md",
            "externalParameters": {
                "source": source,
                "script": "packaging/build",
                "targets": TARGETS,
                "features": FEATURES,
                "sourceChanged": bool(changed),
            },
            "internalParameters": {"rustc": said("rustc", "-vV").splitlines(), "cargo": said("cargo", "-V")},
            "resolvedDependencies": [
                {"uri": source, "digest": {"gitCommit": said("git", "rev-parse", "HEAD")}},
                {"uri": "Cargo.lock", "digest": {"sha256": digest(pathlib.Path("Cargo.lock"))}},
            ],
        },
        "runDetails": {"builder": {"id": f"{package['repository']}/blob/main/packaging/build"}},
    },
}
print(json.dumps(statement, indent=1))
