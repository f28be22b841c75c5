#!/usr/bin/env python3
"""Every file of tests is in a program of tests: a file beside main.rs that nothing names would be run by nobody."""

import re
import sys
from pathlib import Path

lost = []
for manifest in sorted([*Path("crates").glob("*/Cargo.toml"), *Path("apps").glob("*/Cargo.toml")]):
    text = manifest.read_text()
    if "autotests = false" not in text:
        continue
    tests = manifest.parent / "tests"
    named = set(re.findall(r'\[\[test\]\]\nname = "([^"]+)"', text))
    named |= set(re.findall(r"^mod (\w+);", (tests / "main.rs").read_text(), re.MULTILINE)) | {"main"}
    lost += [f"{file}: name it in {tests / 'main.rs'}" for file in sorted(tests.glob("*.rs")) if file.stem not in named]
    lost += [
        f"{file}: name it in {manifest}"
        for file in sorted(tests.glob("*/main.rs"))
        if file.parent.name not in named
    ]
sys.exit("\n".join(lost) or 0)
