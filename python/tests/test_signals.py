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


def test_scipy_agrees():
    optimize = pytest.importorskip("scipy.optimize")
    t = np.arange(2000) / 1000
    x = 2 * np.cos(2 * np.pi * 16.01 * t + 0.5) + 0.1 + np.random.default_rng(1).normal(0, 0.01, t.size)
    ours = proofmass.fit_sine(x, 1000.0)

    def sine(t, f, a, b, c):
        return a * np.cos(2 * np.pi * f * t) + b * np.sin(2 * np.pi * f * t) + c

    found, covariance = optimize.curve_fit(sine, t, x, (16.0, 1.0, 1.0, 0.0), xtol=1e-14, ftol=1e-14)
    # The search ends a thousandth of u from the minimum.
    assert abs(found[0] - ours.frequency) < 2e-3 * ours.frequency_u
    assert abs(found[1] - 1j * found[2] - ours.amplitude) < 5e-3 * ours.modulus_u
    # Both take four degrees of freedom.
    assert np.sqrt(covariance[0, 0]) == pytest.approx(ours.frequency_u, rel=1e-4)
    assert np.allclose(np.sqrt(np.diag(covariance)[1:3]), np.sqrt(np.diag(ours.covariance)), rtol=1e-2)


def test_filterpy_agrees():
    """The velocity that white noise of an acceleration drifts: prediction of a filter without measurements."""
    kalman = pytest.importorskip("filterpy.kalman")
    density, step = 1e-3, 0.01
    filter_ = kalman.KalmanFilter(dim_x=1, dim_z=1)
    # One-sided density N: the variance of a velocity grows by N²/2 a second.
    filter_.P, filter_.Q, filter_.F = np.zeros((1, 1)), np.array([[density**2 / 2 * step]]), np.eye(1)
    table = proofmass.velocity.drift(noise_density=density).table("drift")
    for seconds, u in zip(table["time_s"][:2], table["u_noise_m/s"][:2], strict=True):
        while filter_.P[0, 0] < density**2 / 2 * (seconds - step / 2):
            filter_.predict()
        assert np.sqrt(filter_.P[0, 0]) == pytest.approx(u, rel=1e-9)
