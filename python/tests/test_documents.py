"""The code that the documents show is run, block by block."""

import json
import re
import warnings

import pytest
from conftest import ROOT

import proofmass

# Pages whose blocks stand each by itself, and those that are read from the beginning.
PAGES = [ROOT / "python" / "README.md", ROOT / "docs" / "python.md"]
TUTORIALS = [ROOT / "docs" / "tutorials" / "notebook.md"]


def blocks(page):
    return re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


BLOCKS = [pytest.param(block, id=f"{page.name}-{k}") for page in PAGES for k, block in enumerate(blocks(page))]


@pytest.mark.parametrize("block", BLOCKS)
def test_a_block_of_code(block, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", proofmass.ProofmassWarning)
        exec(compile(block, "document", "exec"), {})


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda p: p.stem)
def test_a_tutorial(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    assert blocks(page)
    names = {"__name__": "__main__"}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", proofmass.ProofmassWarning)
        for k, block in enumerate(blocks(page)):
            exec(compile(block, f"{page.name}, block {k + 1}", "exec"), names)


@pytest.mark.parametrize("notebook", sorted((ROOT / "python" / "notebooks").glob("*.ipynb")), ids=lambda p: p.stem)
def test_a_notebook(notebook, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    names = {"__name__": "__main__"}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", proofmass.ProofmassWarning)
        for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
            assert not cell.get("outputs"), "outputs are not kept: they would go out of date"
            if cell["cell_type"] == "code":
                exec(compile("".join(cell["source"]), notebook.name, "exec"), names)


def test_every_function_says_what_it_does():
    for name in proofmass.__all__:
        assert getattr(proofmass, name).__doc__, name
