#!/usr/bin/env python3
"""What is linked into the program: `linked.py TARGET FEATURES sbom` writes CycloneDX 1.5, `… list` name, version and licence of each crate."""

import json
import re
import subprocess
import sys

TARGET, FEATURES, FORM = sys.argv[1:]
# Neither what tests and builds need, nor macros, which end with the compiler.
command = ["cargo", "tree", "--locked", "-p", "proofmass-cli", "--target", TARGET, "--features", FEATURES]
command += ["-e", "normal,no-proc-macro", "--no-dedupe", "--prefix", "depth", "--format", "\t{p}\t{l}"]
crates, edges, above = {}, {}, []
for line in subprocess.check_output(command, text=True).splitlines():
    depth, package, licence = line.split("\t")
    name, version = package.split()[:2]
    crate = (name, version.removeprefix("v"))
    crates[crate] = re.sub(r"\s*/\s*", " OR ", licence)
    del above[int(depth) :]
    if above:
        edges.setdefault(above[-1], set()).add(crate)
    above.append(crate)
root = ("proofmass-cli", next(version for name, version in crates if name == "proofmass-cli"))
missing = [name for (name, _), licence in crates.items() if not licence]
if missing:
    sys.exit(f"no licence is stated by {', '.join(missing)}")


def reference(crate):
    return f"pkg:cargo/{crate[0]}@{crate[1]}"


def component(crate, kind):
    name, version = crate
    stated = [{"expression": crates[crate]}]
    return {"type": kind, "bom-ref": reference(crate), "name": name, "version": version, "licenses": stated, "purl": reference(crate)}


listed = sorted(crate for crate in crates if crate != root)
if FORM == "list":
    for name, version in listed:
        if not name.startswith("proofmass"):
            print(f"{name} {version}: {crates[name, version]}")
else:
    document = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": component(root, "application")},
        "components": [component(crate, "library") for crate in listed],
        "dependencies": [
            {"ref": reference(crate), "dependsOn": sorted(reference(d) for d in edges.get(crate, ()))} for crate in [root, *listed]
        ],
    }
    print(json.dumps(document, indent=1))
