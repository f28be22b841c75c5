#!/usr/bin/env python3
"""Every dependency must offer a licence that MIT OR Apache-2.0 work can use. Works without network."""

import json
import re
import subprocess
import sys

ALLOWED = {
    "MIT", "MIT-0", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause",
    "Zlib", "ISC", "Unicode-3.0", "Unlicense", "CC0-1.0", "0BSD", "BSL-1.0",
}


def allowed(expression):
    """An SPDX expression: one alternative of OR must be allowed in all its AND parts."""
    expression = expression.replace("/", " OR ").replace("(", " ").replace(")", " ")
    alternatives = re.split(r"\s+OR\s+", expression.strip())
    return any(
        all(part.strip() in ALLOWED for part in re.split(r"\s+AND\s+", alternative))
        for alternative in alternatives
    )


# The workspace, and those apart from it that ship something.
LOCKS = ["Cargo.toml", "apps/certificate/Cargo.toml"]


def packages(manifest):
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--all-features", "--manifest-path", manifest]
    return json.loads(subprocess.check_output(command, text=True))["packages"]


found = {(p["name"], p["version"]): p["license"] for manifest in LOCKS for p in packages(manifest)}
refused = [f"{name} {version}: {licence}" for (name, version), licence in found.items() if not (licence and allowed(licence))]
if refused:
    sys.exit("licences to decide on:\n  " + "\n  ".join(refused))
print(f"{len(found)} packages, licences good")
