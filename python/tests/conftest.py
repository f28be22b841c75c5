"""What the tests share: the repository, the command line, recordings whose truth is known."""

import filecmp
import os
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import proofmass


def quiet(function, *args, **kwargs):
    """The answer without warnings of what it says."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", proofmass.ProofmassWarning)
        return function(*args, **kwargs)


def same_folders(ours, theirs):
    """Both folders hold the same files, byte for byte."""
    names = sorted(p.name for p in theirs.iterdir())
    assert sorted(p.name for p in ours.iterdir()) == names
    _, different, missing = filecmp.cmpfiles(ours, theirs, names, shallow=False)
    assert (different, missing) == ([], [])


ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session", autouse=True)
def same_date():
    """Results of today and of the command line are of one day."""
    os.environ["SOURCE_DATE_EPOCH"] = "1790000000"


@pytest.fixture(scope="session")
def examples():
    return ROOT / "examples"


@pytest.fixture(scope="session")
def command_line():
    """Runs the command line in a folder; without the program the test is skipped with the reason."""
    named = os.environ.get("PROOFMASS_PROGRAM")
    suffix = ".exe" if sys.platform == "win32" else ""
    places = (
        [Path(named)] if named else [ROOT / "target" / kind / f"proofmass{suffix}" for kind in ("debug", "release")]
    )
    program = next((p for p in places if p.is_file()), None)
    if program is None:
        pytest.skip("the command line is not built: cargo build, or name it in PROOFMASS_PROGRAM")

    def run(*arguments, cwd=None):
        arguments = [str(a) for a in arguments]
        done = subprocess.run([program, *arguments], cwd=cwd, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture(scope="session")
def simulated(tmp_path_factory):
    """Recordings whose truth is known, a folder for each kind."""
    folder = tmp_path_factory.mktemp("simulated")
    proofmass.simulate.multi_position(output=folder / "positions")
    proofmass.simulate.noise(output=folder / "noise", duration=600.0, rate=50.0)
    proofmass.simulate.axis(output=folder / "axis")
    proofmass.simulate.shaker(output=folder / "shaker")
    return folder


@pytest.fixture
def rest():
    """Three channels of white noise, m/s²."""
    return np.random.default_rng(3).normal(0, 1e-3, (20_000, 3)) + [0, 0, 9.8]
