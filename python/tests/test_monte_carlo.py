"""Distributions through a function of Python, against closed forms and the model files of the program."""

import json
import threading

import numpy as np
import pytest

import proofmass
from proofmass import monte_carlo

UNIT = {"value": 0.0, "half_width": 3**0.5}


def test_a_sum_of_rectangles():
    """JCGM 101, 9.2.3: u = 2, interval ±3.88."""
    names = "abcd"
    found = monte_carlo(lambda a, b, c, d: a + b + c + d, dict.fromkeys(names, UNIT), trials=1_000_000)
    y = found["y"]
    assert y.u == pytest.approx(2, rel=3e-3)
    assert y.interval == pytest.approx((-3.88, 3.88), abs=0.02)
    assert y.shortest[1] - y.shortest[0] <= y.interval[1] - y.interval[0]


def test_a_model_file_gives_the_same_trials(tmp_path):
    inputs = {"voltage": {"value": 5.0, "u": 0.01}, "current": {"observations": [0.01997, 0.02002, 0.02001, 0.02]}}
    text = "".join(
        f'[[input]]\nname = {json.dumps(n)}\nunit = "1"\n' + "".join(f"{k} = {v}\n" for k, v in i.items())
        for n, i in inputs.items()
    )
    file = tmp_path / "m.toml"
    file.write_text(text + '[[output]]\nname = "R"\nunit = "1"\nexpression = "voltage / current"\n')
    ours = monte_carlo(
        lambda voltage, current: {"R": voltage / current},
        {n: {"unit": "1", **i} for n, i in inputs.items()},
        trials=200_000,
        seed=3,
    )
    theirs = proofmass.uncertainty(file, trials=200_000, seed=3, method="monte-carlo")
    assert ours["R"].mean == pytest.approx(theirs.estimate["R"].value, rel=1e-12)
    assert ours["R"].u == pytest.approx(theirs.estimate["R"].u, rel=1e-12)


def test_correlation_and_several_outputs():
    inputs = {"a": {"value": 1.0, "u": 0.1}, "b": {"value": 2.0, "u": 0.2}}
    found = monte_carlo(
        lambda a, b: {"sum": a + b, "difference": a - b}, inputs, correlation={("a", "b"): 0.5}, trials=400_000
    )
    # var(a ± b) = 0.01 + 0.04 ± 2·0.5·0.1·0.2
    assert found["sum"].u == pytest.approx(0.07**0.5, rel=5e-3)
    assert found["difference"].u == pytest.approx(0.03**0.5, rel=5e-3)
    assert found.covariance.between("sum", "difference") == pytest.approx(0.01 - 0.04, abs=5e-4)


def test_the_seed_and_nothing_else_decides():
    def run(seed):
        return monte_carlo(lambda a: a**2, {"a": {"value": 1.0, "u": 0.1}}, trials=50_000, seed=seed)["y"]

    assert run(1) == run(1) != run(2)


def test_an_exception_comes_out_unchanged():
    class Mine(Exception):
        pass

    def wrong(a):
        raise Mine("mine")

    with pytest.raises(Mine, match="mine"):
        monte_carlo(wrong, {"a": UNIT}, trials=1000)
    calls = []

    def later(a):
        calls.append(len(a))
        if len(calls) > 5:
            raise Mine
        return a

    with pytest.raises(Mine):
        monte_carlo(later, {"a": UNIT}, trials=10_000_000)
    assert len(calls) < 500


def test_what_is_no_model():
    for model, inputs, kind in [
        (3, {"a": UNIT}, proofmass.RequestError),
        (lambda a: a, {}, (proofmass.ProofmassError, TypeError)),
        (lambda a: a, {"a": {}}, proofmass.RequestError),
        (lambda a: a, {"a": {"value": 1.0, "u": -1}}, proofmass.ProofmassError),
        (lambda a: a, {"a": {"value": float("nan"), "u": 1}}, proofmass.RequestError),
        (lambda b: b, {"a": UNIT}, TypeError),
        (lambda a: a[:3], {"a": UNIT}, ValueError),
        (lambda a: "text", {"a": UNIT}, ValueError),
    ]:
        with pytest.raises(kind):
            monte_carlo(model, inputs, trials=1000)
    with pytest.raises(proofmass.ProofmassError):
        monte_carlo(lambda a: a, {"a": UNIT}, trials=0)


def test_trials_that_are_no_numbers_are_counted():
    with pytest.warns(proofmass.ProofmassWarning):
        with np.errstate(invalid="ignore"):
            y = monte_carlo(
                lambda a: np.sqrt(np.where(a < 0, np.nan, a)), {"a": {"value": 1.0, "u": 0.5}}, trials=50_000
            )["y"]
    assert 0 < y.invalid < 5_000


def test_threads_of_the_caller_go_on():
    seen = set()

    def model(a):
        seen.add(threading.get_ident())
        return a

    monte_carlo(model, {"a": UNIT}, trials=200_000)
    assert threading.get_ident() not in seen
