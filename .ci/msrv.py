#!/usr/bin/env python3
"""`rust-version` of a workspace must be at least that of every dependency, or it is a promise nobody can keep."""

import json
import subprocess
import sys


def version(text):
    parts = [int(p) for p in (text or "0").split(".")]
    return tuple(parts + [0] * (3 - len(parts)))


def check(manifest):
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--all-features", "--manifest-path", manifest]
    metadata = json.loads(subprocess.check_output(command, text=True))
    members = set(metadata["workspace_members"])
    packages = metadata["packages"]
    promised = {p["rust_version"] for p in packages if p["id"] in members and p["rust_version"]}
    if len(promised) != 1:
        sys.exit(f"{manifest}: the packages promise different versions: {sorted(promised)}")
    promised = promised.pop()
    newer = [
        f"{p['name']} {p['version']} needs {p['rust_version']}"
        for p in packages
        if p["id"] not in members and version(p["rust_version"]) > version(promised)
    ]
    if newer:
        sys.exit(f"{manifest}: rust-version = {promised} cannot hold:\n  " + "\n  ".join(newer))
    print(f"{manifest}: rust-version {promised} holds for all {len(packages)} packages")


check("Cargo.toml")
check("apps/certificate/Cargo.toml")
