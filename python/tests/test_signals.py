"""Calls on arrays, against the packages of others and closed forms."""

import numpy as np
import pytest

import proofmass


def test_allantools_agrees():
    allantools = pytest.importorskip("allantools")
    samples = np.random.default_rng(7).normal(0, 1, 4096)
    ours = proofmass.allan_deviation(samples, 10.0)
    for name, function in (("oadev", allantools.oadev), ("mdev", allantools.mdev), ("hdev", allantools.ohdev)):
        name = "ohdev" if name == "hdev" else name
        ours = proofmass.allan_deviation(samples, 10.0, statistic=name)
        taus, theirs, _, _ = function(samples, rate=10.0, data_type="freq", taus=ours.tau)
        common = np.isin(np.round(ours.tau, 9), np.round(taus, 9))
        assert common.sum() >= 5
        assert np.allclose(
            ours.deviation[common], theirs[np.isin(np.round(taus, 9), np.round(ours.tau, 9))], rtol=1e-10
        ), name
    assert np.all((ours.low < ours.deviation) & (ours.deviation < ours.high))


def test_white_noise_falls_as_the_root():
    curve = proofmass.allan_deviation(np.random.default_rng(2).normal(0, 1, 100_000), 1.0)
    assert curve.deviation[0] == pytest.approx(1, rel=0.02)
    assert curve.deviation[4] == pytest.approx(0.25, rel=0.05)


def test_a_sine():
    t = np.arange(1000) / 1000
    x = 2 * np.cos(2 * np.pi * 16.01 * t + 0.5) + 0.1 + np.random.default_rng(1).normal(0, 0.01, 1000)
    known, found = proofmass.fit_sine(x, 1000.0, 16.01), proofmass.fit_sine(x, 1000.0)
    assert known.frequency_u is None and known.frequency == 16.01
    assert abs(known.modulus - 2) < 4 * known.modulus_u and abs(known.phase - 0.5) < 4 * known.phase_u
    assert abs(found.frequency - 16.01) < 4 * found.frequency_u
    # Three parameters, and four where the frequency is found.
    assert (known.dof, found.dof) == (997, 996)
    # u of an amplitude in white noise: σ √(2/n).
    assert known.modulus_u == pytest.approx(0.01 * np.sqrt(2 / 1000), rel=0.1)


@pytest.mark.parametrize("samples", [[], [1.0], [1.0, float("nan"), 2.0], np.zeros((4, 4))])
def test_what_is_no_signal(samples):
    with pytest.raises(proofmass.ProofmassError):
        proofmass.allan_deviation(samples, 1.0)
    with pytest.raises(proofmass.ProofmassError):
        proofmass.fit_sine(samples, 1.0)


def test_words_that_are_none():
    for options in ({"statistic": "adve"}, {"taus": "often"}, {"probability": 2.0}):
        with pytest.raises(proofmass.ProofmassError):
            proofmass.allan_deviation(np.zeros(100) + np.arange(100), 1.0, **options)


def test_u_of_the_phase_where_the_frequency_is_found():
    """Standard deviation of the phase over simulated records; that at a known frequency is half of it."""
    rng = np.random.default_rng(6)
    t = np.arange(200)
    found = []
    for _ in range(400):
        x = np.cos(2 * np.pi * 0.0731 * t + 0.7) + rng.normal(0, 0.1, 200)
        found.append(proofmass.fit_sine(x, 1.0))
    u = np.mean([s.phase_u for s in found])
    assert np.std([s.phase for s in found]) == pytest.approx(u, rel=0.12)
