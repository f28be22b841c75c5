"""Instructions per step of every estimator and of the compensation, counted by callgrind.

    cargo build --release -p proofmass-core --example step_cost
    python bench/instructions.py

The count is the difference of two runs of unequal length, less that of a loop that does nothing.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "target/release/examples/step_cost"
SOURCE = ROOT / "crates/core/examples/step_cost.rs"
SHORT, LONG = 1_000, 11_000


def instructions(name, steps):
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run(
            ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out", PROGRAM, name, str(steps)],
            capture_output=True, text=True, check=True,
        )
    return int(re.search(r"Collected : (\d+)", run.stderr).group(1))


def per_step(name):
    return (instructions(name, LONG) - instructions(name, SHORT)) / (LONG - SHORT)


names = re.findall(r'task\.measure\("([^"]+)"', SOURCE.read_text())
loop = per_step("nothing")
print("| step | instructions |\n|---|---|")
for name in names:
    if name != "nothing":
        print(f"| {name} | {per_step(name) - loop:.0f} |")
