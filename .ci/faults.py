#!/usr/bin/env python3
"""Faults at every call: a run is killed at, or refused by, each rename, write, fsync, unlink and mkdir in turn.

    .ci/faults.py target/debug/proofmass [--all]

Needs strace. After each fault the results are the old ones or the new ones, and the next run leaves the new ones and nothing
else; with `--all` also where the folder holds a file of somebody, which stays. Runs of one command, `uncertainty`, whose way of writing is that of all.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile

PROGRAM = os.path.abspath(sys.argv[1])
ALL = "--all" in sys.argv
MODEL = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../examples/uncertainty/mass.toml")
RENAMES = "rename,renameat,renameat2"
UNLINKS = "unlink,unlinkat,rmdir"
FAULTS = [
    (RENAMES, "signal=KILL"),
    ("write", "signal=KILL"),
    ("fsync", "signal=KILL"),
    (UNLINKS, "signal=KILL"),
    ("mkdir", "signal=KILL"),
    (RENAMES, "error=EIO"),
    ("renameat2", "error=EINVAL"),
    ("write", "error=ENOSPC"),
    ("write", "error=EIO"),
    ("fsync", "error=EIO"),
    (UNLINKS, "error=EIO"),
    ("mkdir", "error=EROFS"),
    ("flock", "error=ENOLCK"),
]
# Calls beyond this belong to no fault that was seen; the loop ends earlier where the call does not come so often.
MOST_CALLS = 60


def run(place, seed, fault=()):
    command = [*fault, PROGRAM, "uncertainty", MODEL, "--trials", "10000", "--seed", seed, "-o", place]
    environment = dict(os.environ, SOURCE_DATE_EPOCH="1790000000")
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


def files(folder):
    found = {}
    for above, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(above, name)
            with open(path, "rb") as file:
                found[os.path.relpath(path, folder)] = hashlib.sha256(file.read()).hexdigest()
    return found


def one(work, calls, fault, number, foreign, old, new):
    """Whether the fault was reached, and what it broke."""
    shutil.rmtree(work, ignore_errors=True)
    os.mkdir(work)
    place = os.path.join(work, "result")
    run(place, "1")
    if foreign:
        with open(os.path.join(place, "notes.txt"), "w", encoding="utf-8") as file:
            file.write("mine")
    log = os.path.join(os.path.dirname(work), "trace")
    inject = f"inject={calls}:{fault}:when={number}"
    told = run(place, "2", ("strace", "-f", "-qq", "-o", log, "-e", f"trace={calls}", "-e", inject))
    with open(log, encoding="utf-8", errors="replace") as file:
        trace = file.read()
    reached = "(INJECTED)" in trace or told.returncode < 0
    wrong = []
    if "panicked" in told.stderr or told.returncode not in (0, 1, -9, 137):
        wrong.append(f"exit {told.returncode}: {told.stderr.strip()[-200:]}")
    there = files(place)
    if foreign:
        if there.pop("notes.txt", None) is None:
            wrong.append("a file of somebody is gone")
    elif there not in (old, new):
        wrong.append(f"neither the old results nor the new ones: {sorted(there)}")
    after = run(place, "2")
    there = files(place)
    there.pop("notes.txt", None)
    if after.returncode != 0 or there != new or os.listdir(work) != ["result"]:
        wrong.append(f"the next run: exit {after.returncode}, {os.listdir(work)}, {sorted(there)}")
    return reached, wrong


def main():
    faults, broken = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        for seed in "12":
            done = run(os.path.join(folder, seed), seed)
            if done.returncode != 0:
                sys.exit(done.stderr)
        old, new = files(os.path.join(folder, "1")), files(os.path.join(folder, "2"))
        work = os.path.join(folder, "work")
        for foreign in (False, True) if ALL else (False,):
            for calls, fault in FAULTS:
                for number in range(1, MOST_CALLS + 1):
                    reached, wrong = one(work, calls, fault, number, foreign, old, new)
                    if not reached:
                        break
                    faults += 1
                    for what in wrong:
                        broken += 1
                        print(f"{calls}, {fault}, call {number}: {what}")
    print(f"{faults} faults, {broken} failed")
    sys.exit(broken > 0 or faults < (50 if ALL else 20))


if __name__ == "__main__":
    main()
