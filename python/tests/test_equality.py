"""What a function gives is what the command writes, byte for byte."""

import numpy as np
import pytest
from conftest import quiet, same_folders

import proofmass


@pytest.mark.parametrize("campaign", ["hand-held", "published-triaxial"])
def test_a_campaign(campaign, examples, command_line, tmp_path):
    result = quiet(proofmass.calibrate, examples / campaign)
    ours = result.write(tmp_path / "ours")
    command_line("calibrate", examples / campaign, "-o", tmp_path / "theirs")
    same_folders(ours, tmp_path / "theirs")


@pytest.mark.parametrize("model", ["end-gauge", "gauge-block", "impedance", "mass"])
def test_a_model_of_measurement(model, examples, command_line, tmp_path):
    file = examples / "uncertainty" / f"{model}.toml"
    result = quiet(proofmass.uncertainty, file, trials=20_000)
    result.write(tmp_path / "ours")
    command_line("uncertainty", file, "--trials", 20_000, "-o", tmp_path / "theirs")
    same_folders(tmp_path / "ours", tmp_path / "theirs")


def recordings(simulated):
    noise = next((simulated / "noise").glob("*.csv"))
    axis = next((simulated / "axis").glob("*.csv"))
    return noise, axis


def test_noise_of_a_file(simulated, command_line, tmp_path):
    noise, _ = recordings(simulated)
    quiet(proofmass.noise, noise, terms=["Q", "N", "B", "K", "R"], probability=0.9).write(tmp_path / "ours")
    command_line("noise", noise, "--probability", 0.9, "-o", tmp_path / "theirs")
    same_folders(tmp_path / "ours", tmp_path / "theirs")


def test_an_output_is_the_same_folder(examples, command_line, tmp_path):
    quiet(proofmass.calibrate, examples / "hand-held", output=tmp_path / "ours")
    command_line("calibrate", examples / "hand-held", "-o", tmp_path / "theirs")
    same_folders(tmp_path / "ours", tmp_path / "theirs")


def test_every_export(simulated, command_line, tmp_path):
    result = quiet(proofmass.calibrate, simulated / "positions")
    folder = result.write(tmp_path / "result")
    for form in ("c", "rust", "python"):
        ours = proofmass.export(folder / "calibration.json", **{form: True})
        assert ours == command_line("export", folder / "calibration.json", f"--{form}")


def test_arrays_and_the_file_they_came_from(rest, tmp_path):
    """The numbers of an array are those of a file with the same numbers."""
    np.save(tmp_path / "rest.npy", rest)
    array = quiet(proofmass.noise, rest, rate=100.0)
    file = quiet(proofmass.noise, tmp_path / "rest.npy", rate=100.0, unit="m/s²", columns=[1, 2, 3])
    assert [q.value for q in array.estimate.values()] == [q.value for q in file.estimate.values()]
    named = {f"{axis} (m/s²)": rest[:, k] for k, axis in enumerate("xyz")}
    table = quiet(proofmass.noise, named, rate=100.0)
    assert table.to_dict()["quantities"] == array.to_dict()["quantities"]


def test_a_campaign_in_memory(examples):
    text = (examples / "hand-held" / "campaign.toml").read_text()
    recording = (examples / "hand-held" / "recording.csv").read_bytes()
    memory = quiet(proofmass.calibrate_campaign, {"campaign.toml": text, "recording.csv": recording})
    folder = quiet(proofmass.calibrate, examples / "hand-held")
    assert memory.to_dict()["quantities"] == folder.to_dict()["quantities"]
    columns = np.genfromtxt(recording.decode().splitlines(), delimiter=",", names=True, comments="#", deletechars="")
    assert len(columns) > 1000


def test_the_functions_are_those_of_the_commands():
    """Names, defaults and texts come from the options; a difference names the file that has to be written anew."""
    import subprocess
    import sys

    from conftest import ROOT

    tool = ROOT / "python" / "tools" / "functions.py"
    done = subprocess.run([sys.executable, tool, "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_every_function_is_offered():
    from proofmass import _commands

    assert set(_commands.__all__) < set(proofmass.__all__)


def test_every_command_has_a_function():
    from proofmass._description import descriptions

    for words in descriptions():
        first, *others = words.split()
        groups = ("records", "simulate", "test", "velocity")
        group = {name: getattr(proofmass, name) for name in groups}
        where = group[first] if first in group and others else proofmass
        name = "_".join(others if first in group and others else [first, *others]).replace("-", "_")
        assert callable(getattr(where, {"import": "import_"}.get(name, name))), words
