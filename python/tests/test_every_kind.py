"""Every command with a result: the function gives the folder that the command line writes, byte for byte.

A row is a call as it is typed; the keywords of the function are made from it. A kind of result without a row fails the last test.
"""

import numpy as np
import pytest
from conftest import quiet, same_folders

import proofmass
from proofmass._description import descriptions, keyword

CALLS = {
    "multi-position": "calibrate {sim}/positions",
    "free-living": "calibrate {sim}/free-living",
    "single-axis": "calibrate {sim}/single-axis",
    "shaker-triaxial": "calibrate {sim}/shaker",
    "shaker-single": "calibrate {sim}/shaker-single",
    "shaker-primary": "calibrate {sim}/shaker-primary",
    "transverse-sensitivity": "calibrate {sim}/transverse-sensitivity",
    "spurious-motion": "calibrate {sim}/spurious",
    "validation": "validate {sim}/calibrated/calibration.json {sim}/positions/recording.csv --gravity 9.80665 --gravity-uncertainty 1e-4",
    "temperature": "test temperature {sim}/oven.csv --columns x,y,z --temperature T",
    "bias": "bias {sim}/level.csv --columns x,y,z --up z --noise {sim}/noise-level/result.json",
    "plan": "plan {sim}/shaker",
    "noise": "noise {sim}/noise/recording.csv --statistic oadev,mdev --probability 0.9",
    "noise-comparison": "noise compare {sim}/noise-1 {sim}/noise-2",
    "device-check": "device check {sim}/calibrated {sim}/noise-1 --sheet {sim}/device.toml",
    "device-plan": "device plan --sheet {sim}/device.toml --noise-result {sim}/noise-1/result.json --rate 50 --gravity-uncertainty 1e-4",
    "uncertainty": "uncertainty {examples}/uncertainty/mass.toml --trials 10000 --seed 3",
    "modes": "modes {sim}/wedge.toml",
    "velocity-estimate": "velocity estimate {sim}/axis/recording.csv {axis}",
    "velocity-comparison": "velocity compare {sim}/axis/recording.csv {axis}",
    "velocity-tuning": "velocity tune {sim}/axis/recording.csv {axis}",
    "velocity-map": "velocity map {sim}/wheel/recording.csv --orders 1,2 --position encoder --counts-per-turn 2000 --radius 0.02 --acceleration acceleration",
    "velocity-drift": "velocity drift --noise-density 1e-3 --offset 1e-4",
    "velocity-integrator": "velocity integrator --band 2,40 --rate 200 --bias 0.02 --noise 1e-3 --speed 0.5",
    "static-test": "test linearity {sim}/levels.csv --output-column V --acceleration a",
    "shock": "test shock {sim}/shock/recording.csv --column output --reference reference",
    "frequency-response-test": "test random {sim}/random/recording.csv --input reference --output-column output",
    "step": "test step {sim}/step/recording.csv --column output",
    "level-linearity": "test levels {sim}/levels.csv --level a --output-column V --output-u u",
    "motion": "test motion {sim}/shock/recording.csv --column reference",
    "comparison": "compare {sim}/certificate-1.csv {sim}/certificate-2.csv",
    "certificate": "certificate {sim}/calibrated/result.json --lab {sim}/LAB.toml --issued 2026-02-01",
    "deconvolution": "test deconvolve {sim}/random/result/result.json {sim}/shock/recording.csv --column output",
}
AXIS = "--position encoder --counts-per-turn 2000 --radius 0.3 --acceleration acceleration"


@pytest.fixture(scope="module")
def world(simulated, command_line, examples):
    """Files for every kind of command."""
    sim = simulated
    for kind in ("free-living", "single-axis", "shaker-single", "shaker-primary", "transverse-sensitivity"):
        proofmass.init(kind=kind, output=sim / kind)
    proofmass.simulate.spurious_motion(output=sim / "spurious")
    for motion in ("shock", "random", "step"):
        proofmass.simulate.transducer(motion=motion, output=sim / motion)
    proofmass.simulate.axis(radius=0.02, eccentricity=0.02, output=sim / "wheel")
    # On a coarse mesh, which takes a second.
    wedge = (examples / "wedge" / "wedge-55.toml").read_text(encoding="utf-8")
    coarse = wedge.replace("[modes]", "[modes]\naccuracy = 0.05\nunknowns = 8000")
    (sim / "wedge.toml").write_text(coarse, encoding="utf-8")
    laboratory = '[laboratory]\nname = "Laboratory"\ntown = "Pisa"\ncountry = "IT"\n'
    (sim / "LAB.toml").write_text(laboratory, encoding="utf-8")
    sheet = '[[limit]]\nterm = "N"\nmost = 160.0\nunit = "µg/√Hz"\n[[limit]]\ncharacteristic = "misalignment"\nmost = 3\nunit = "%"\n'
    (sim / "device.toml").write_text(sheet, encoding="utf-8")
    rng = np.random.default_rng(2)
    seconds = np.arange(3600.0)
    heat = 20 + 20 * np.sin(np.pi * seconds / 3600)
    axes = [rng.normal(g + 1e-3 * k * (heat - 20), 1e-3) for k, g in enumerate((0.0, 0.0, 9.8), 1)]
    table = np.column_stack([seconds, *axes, heat])
    np.savetxt(
        sim / "oven.csv",
        table,
        delimiter=",",
        header="time_s,x_m/s²,y_m/s²,z_m/s²,T_degC",
        comments="",
        encoding="utf-8",
    )
    still = np.where(
        seconds[:, None] % 300 < 100, [0.0, 0.0, 9.8], np.add([0.0, 0.0, 9.8], rng.normal(0, 0.5, (3600, 3)))
    )
    table = np.column_stack([seconds / 50, still + rng.normal(0.02, 1e-3, (3600, 3))])
    np.savetxt(
        sim / "level.csv", table, delimiter=",", header="time_s,x_m/s²,y_m/s²,z_m/s²", comments="", encoding="utf-8"
    )
    turns = rng.normal(size=(180, 3))
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    worn = np.repeat(turns, 60 * 20, axis=0)
    moving = (np.arange(len(worn)) % 1200 > 900)[:, None] * rng.normal(0, 0.3, worn.shape)
    table = np.column_stack(
        [
            np.arange(len(worn)) / 20,
            worn * [1.01, 0.99, 1.0] + [0.01, 0, -0.02] + moving + rng.normal(0, 2e-3, worn.shape),
        ]
    )
    np.savetxt(
        sim / "free-living" / "wrist.csv", table, fmt="%.6f", delimiter=",", header="t_s,x_g,y_g,z_g", comments=""
    )
    level = np.linspace(1, 20, 12)
    table = np.column_stack([level, 0.1 * level + 1e-5 * level**2, np.full(12, 1e-4)])
    np.savetxt(sim / "levels.csv", table, delimiter=",", header="a_m/s²,V_V,u_V", comments="", encoding="utf-8")
    for k in (1, 2):
        rows = [f"{f},{10 + 0.001 * k * f**0.1},0.05,0,0.2" for f in (10, 20, 40, 80, 160)]
        text = (
            "frequency_Hz,sensitivity_mV/(m/s2),u_sensitivity_mV/(m/s2),phase_deg,u_phase_deg\n"
            + "\n".join(rows)
            + "\n"
        )
        (sim / f"certificate-{k}.csv").write_text(text, encoding="utf-8")
    command_line("calibrate", sim / "positions", "-o", sim / "calibrated")
    command_line("noise", sim / "level.csv", "--between", "0", "2", "-o", sim / "noise-level")
    for k in (1, 2):
        command_line(
            "noise", sim / "noise" / "recording.csv", "-o", sim / f"noise-{k}", "--detrend", ("none", "linear")[k - 1]
        )
    command_line(
        "test",
        "random",
        sim / "random" / "recording.csv",
        "--input",
        "reference",
        "--output-column",
        "output",
        "--model",
        "1mode",
        "-o",
        sim / "random" / "result",
    )
    return {"sim": sim, "examples": examples, "axis": AXIS}


def as_function(typed):
    """The function and its arguments of a call as it is typed."""
    words, rest = typed[:1], typed[1:]
    while rest and " ".join([*words, rest[0]]) in {" ".join(w.split()[: len(words) + 1]) for w in descriptions()}:
        words, rest = [*words, rest[0]], rest[1:]
    described = descriptions()[" ".join(words)]
    by_flag = {f"--{a['long']}": a for a in described["arguments"] if a["long"]}
    args, kwargs = [], {}
    while rest:
        word, rest = rest[0], rest[1:]
        if not word.startswith("--"):
            args.append(word)
            continue
        argument = by_flag[word]
        if argument["kind"] == "bool":
            kwargs[keyword(argument)] = True
            continue
        value, rest = rest[0], rest[1:]
        kind = {"float": float, "int": int}.get(argument["kind"], str)
        kwargs[keyword(argument)] = kind(value) if "," not in value else value.split(",")
    if any(a["position"] and (a["several"] or a["repeated"]) for a in described["arguments"]):
        args = [args]
    group = {"velocity": proofmass.velocity, "simulate": proofmass.simulate, "test": proofmass.test}.get(words[0])
    name = "_".join(words[1:] if group and len(words) > 1 else words).replace("-", "_")
    return getattr(group or proofmass, name), args, kwargs


@pytest.mark.parametrize("kind", CALLS)
def test_the_folder_is_the_same(kind, world, command_line, tmp_path):
    typed = CALLS[kind].format(**world).split()
    function, args, kwargs = as_function(typed)
    result = quiet(function, *args, **kwargs)
    results = result if isinstance(result, list) else [result]
    # An example of a single axis gives a result of many positions of that axis.
    assert {r.kind for r in results} <= {kind, "static-test"} or kind == "single-axis", results[0].kind
    command_line(*typed, "-o", tmp_path / "theirs")
    results[0].write(tmp_path / "ours")
    same_folders(tmp_path / "ours", tmp_path / "theirs")


@pytest.mark.parametrize("form", ["csv", "npy", "wav"])
def test_files_are_the_same(form, world, command_line, tmp_path):
    recording = world["sim"] / "shock" / "recording.csv"
    options = {"columns": "output", "without_units": form != "csv"}
    ours = proofmass.convert([recording], output=tmp_path / f"ours.{form}", **options)
    extra = ["--columns=output", *(["--without-units"] if form != "csv" else [])]
    command_line("convert", recording, "-o", tmp_path / f"theirs.{form}", *extra)
    assert ours.read_bytes() == (tmp_path / f"theirs.{form}").read_bytes()


def test_compensated_files_are_the_same(world, command_line, tmp_path):
    calibration, recording = (
        world["sim"] / "calibrated" / "calibration.json",
        world["sim"] / "positions" / "recording.csv",
    )
    ours = proofmass.apply(calibration, recording, output=tmp_path / "ours.csv")
    command_line("apply", calibration, recording, "-o", tmp_path / "theirs.csv")
    assert ours.read_bytes() == (tmp_path / "theirs.csv").read_bytes()
    arrays = proofmass.apply(calibration, recording)
    lines = (tmp_path / "theirs.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0].split(",") == list(arrays)
    assert [float(x) for x in lines[-1].split(",")] == [column[-1] for column in arrays.values()]


def test_no_kind_is_left_out():
    """The kinds of result that the program knows, but those that are written as files."""
    from proofmass import _proofmass

    known = set(_proofmass.result_kinds()) - {"apply", "convert", "inspect", "simulate"}
    assert known - set(CALLS) == set()
