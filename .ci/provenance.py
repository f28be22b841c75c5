#!/usr/bin/env python3
"""Data of others: a folder of `reference`, or one that a crate packs, says where its recordings and tables are from, and on what ground they are here.

It does so in its PROVENANCE.md or README.md, in paragraphs that begin with "Source:" and "Licence:"; or all in it is ours, and it is listed below. Links
are followed, as cargo follows them.
"""

import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKED = ["apps/cli", *sorted(f"crates/{folder.name}" for folder in (ROOT / "crates").iterdir())]
OURS = {
    "apps/certificate/tests/sheets": "made by the tests of the certificates",
    "apps/cli/schemas": "written by the example `schemas`",
    "apps/cli/src/certificate": "a laboratory that does not exist",
    "crates/documents/tests/data": "calibrations of simulated recordings, as earlier versions wrote them",
    "crates/jobs/tests/data": "a result of invented numbers, as an earlier version wrote it",
    "examples/encoder": "options of a command",
    "examples/hand-held": "simulated",
    "fuzz/corpus/streams": "a few invented samples in each format",
}
# What is no data: sources, text and pictures of the pages, and what cargo reads.
SUFFIXES = {".rs", ".py", ".md", ".html", ".css", ".js", ".svg", ".png", ".snap"}
NAMES = {"Cargo.toml", "LICENSE-APACHE", "LICENSE-MIT"}


def folders():
    """Every folder that holds data, by its own name where links lead to it."""
    found = set()
    for top in ["reference", *PACKED]:
        for folder, _, names in os.walk(ROOT / top, followlinks=True):
            for name in names:
                path = Path(folder, name).resolve()
                if path.suffix not in SUFFIXES and path.name not in NAMES:
                    found.add(path.parent.relative_to(ROOT))
    return sorted(found)


def lacks(folder):
    """What the page of a folder does not say; nothing where it says all."""
    pages = [page for page in (ROOT / folder / "PROVENANCE.md", ROOT / folder / "README.md") if page.is_file()]
    if not pages:
        return "it has neither a PROVENANCE.md nor a README.md"
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    missing = [word for word in ("Source", "Licence") if not re.search(rf"^{word}: *\S", text, re.MULTILINE)]
    return f"{pages[0].name} has no paragraph that begins with {' or '.join(word + ':' for word in missing)}" if missing else ""


def ours(folder):
    return any(str(folder) == known or str(folder).startswith(known + "/") for known in OURS)


found = folders()
wrong = [f"{folder}: {what}" for folder in found if not ours(folder) and (what := lacks(folder))]
wrong += [f"{known}: listed as ours, but holds no data" for known in OURS if Path(known) not in found]
if wrong:
    sys.exit("data of others need their source and the ground for their use; what is ours is listed in .ci/provenance.py:\n  " + "\n  ".join(wrong))
print(f"{len(found)} folders with data, {sum(not ours(folder) for folder in found)} of them with data of others: source and licence stated")
