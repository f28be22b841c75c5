"""Uncertain numbers and arrays, against closed forms and against each other."""

import copy
import math
import pickle

import numpy as np
import pytest

import proofmass
from proofmass import DataError, RequestError, UncertainArray, uarray, ufloat


def test_the_gum_ohm():
    """R = V/I: u(R)² = (u(V)/I)² + (V u(I)/I²)²."""
    r = ufloat(5.0, 0.01) / ufloat(0.02, 0.0001)
    assert r.value == 250
    assert r.u == pytest.approx(math.hypot(0.5, 1.25))
    assert str(r) == "250.0(1.3)"
    assert r.text("Ω") == "250.0(1.3) Ω"


def test_what_is_common_cancels():
    x = ufloat(2, 0.1)
    assert (x - x).u == 0
    assert ufloat(1, 0.1, "gain").correlation(ufloat(3, 0.2, "gain")) == pytest.approx(1)
    assert ufloat(1, 0.1).correlation(ufloat(3, 0.2)) == 0
    y = pickle.loads(pickle.dumps(x))
    assert (y - x).u == 0 and copy.copy(x) == x


def test_degrees_of_freedom():
    """Welch–Satterthwaite: (0.3² + 0.4²)²/(0.3⁴/4 + 0.4⁴/9)."""
    y = ufloat(1, 0.3, dof=4) + ufloat(1, 0.4, dof=9)
    assert y.dof == pytest.approx(0.5**4 / (0.3**4 / 4 + 0.4**4 / 9))
    assert y.U(0.95) > 2 * y.u


@pytest.mark.parametrize(
    "name", ["exp", "log", "log10", "sqrt", "sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh"]
)
def test_functions_of_numbers_and_arrays(name):
    function = getattr(np, name)
    h = 1e-6
    slope = (function(0.4 + h) - function(0.4 - h)) / (2 * h)
    number, array = function(ufloat(0.4, 0.01, "x")), function(uarray([0.4], 0.01, "x"))
    assert number.value == pytest.approx(function(0.4), rel=1e-14)
    assert number.u == pytest.approx(abs(slope) * 0.01, rel=1e-8)
    assert array.value[0] == pytest.approx(number.value, rel=1e-14)
    assert array.u[0] == pytest.approx(number.u, rel=1e-12)


def test_operators_of_arrays_are_those_of_numbers():
    rng = np.random.default_rng(5)
    a, b = rng.uniform(1, 2, (2, 40))
    x, y = uarray(a, 0.01), uarray(b, 0.02)
    g = ufloat(1.5, 0.003, "gain")
    array = (x * g + y**2 / x + 3) ** 1.5 + np.arctan2(x, y) + 2**x
    for k in range(40):
        p, q = x[k], y[k]
        one = (p * g + q**2 / p + 3) ** 1.5 + p.arctan2(q) + 2**p
        assert array[k].value == pytest.approx(one.value, rel=1e-13)
        assert array[k].u == pytest.approx(one.u, rel=1e-12)
        assert array[k].covariance(g) == pytest.approx(one.covariance(g), rel=1e-12)


def test_sums_and_products_keep_correlation():
    x = uarray([1.0, 2.0, 3.0], [0.1, 0.2, 0.3])
    g = ufloat(1, 0.01, "gain")
    y = x * g
    # var Σ = Σ u² + (Σ x)² u(g)²
    assert y.sum().u == pytest.approx(math.sqrt(0.14 + 36 * 1e-4))
    assert y.mean().u == pytest.approx(y.sum().u / 3)
    expected = np.diag([0.01, 0.04, 0.09]) + 1e-4 * np.outer([1, 2, 3], [1, 2, 3])
    assert np.allclose(y.covariance(), expected)
    m = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, -1.0]])
    assert np.allclose((m @ y).covariance(), m @ expected @ m.T)
    assert (np.ones(3) @ y).u == pytest.approx(y.sum().u)
    back = (y[::-1])[::-1] - y
    assert np.all(back.u == 0)
    shifted = y[1:] - y[:-1]
    steps = np.array([[-1.0, 1, 0], [0, -1, 1]])
    assert np.allclose(shifted.covariance(), steps @ expected @ steps.T)


def test_shapes():
    x = uarray(np.arange(1.0, 7).reshape(2, 3), 0.1)
    assert (x + np.ones(3)).shape == (2, 3)
    assert x.T.shape == (3, 2) and np.array_equal(x.T.value, x.value.T)
    assert np.array_equal((x - x.T.T).u, np.zeros((2, 3)))
    column = uarray([[1.0], [2.0]], 0.5)
    assert np.allclose((x * 0 + column).u[0], 0.5)
    assert (x * 0 + column)[0, 0].correlation((x * 0 + column)[0, 2]) == pytest.approx(1)
    assert len(list(iter(x))) == 2 and x.ndim == 2 and x.size == 6
    assert isinstance(x[0], UncertainArray)
    assert "uarray" in repr(x)


def test_nothing_passes_that_is_no_number():
    with pytest.raises(DataError):
        ufloat(float("nan"), 1)
    with pytest.raises(DataError):
        ufloat(1, -1)
    with pytest.raises(DataError):
        uarray([1, np.inf], 0.1)
    with pytest.raises(DataError, match="index 1"):
        np.log(uarray([1.0, -1.0], 0.1))
    with pytest.raises(DataError):
        uarray([1.0], 0.1) / 0
    with pytest.raises(ValueError):
        ufloat(1, 0.1) / 0
    with pytest.raises(DataError):
        np.sqrt(uarray([0.0], 0.1))
    with pytest.raises(TypeError):
        np.asarray(uarray([1.0], 0.1))
    with pytest.raises(RequestError):
        uarray([1.0, 2.0], 0.1) @ np.ones(3)
    with pytest.raises(TypeError):
        ufloat(1, 0.1) + "x"


def test_uncertainties_agrees():
    uncertainties = pytest.importorskip("uncertainties")
    unumpy = pytest.importorskip("uncertainties.unumpy")
    rng = np.random.default_rng(8)
    a, b = rng.uniform(1, 2, (2, 30))
    ours = np.sin(uarray(a, 0.01)) * uarray(b, 0.02) / uarray(a, 0.01)
    theirs = unumpy.sin(unumpy.uarray(a, 0.01)) * unumpy.uarray(b, 0.02) / unumpy.uarray(a, 0.01)
    assert np.allclose(ours.value, unumpy.nominal_values(theirs), rtol=1e-14)
    assert np.allclose(ours.u, unumpy.std_devs(theirs), rtol=1e-12)
    assert uncertainties


def test_gtc_agrees():
    gtc = pytest.importorskip("GTC")
    v, i, phi = gtc.ureal(5, 0.01, 4), gtc.ureal(0.02, 0.0001, 9), gtc.ureal(1.04, 0.001, 12)
    theirs = v / i * gtc.cos(phi)
    ours = ufloat(5, 0.01, dof=4) / ufloat(0.02, 0.0001, dof=9) * np.cos(ufloat(1.04, 0.001, dof=12))
    assert ours.value == pytest.approx(theirs.x, rel=1e-14)
    assert ours.u == pytest.approx(theirs.u, rel=1e-13)
    assert ours.dof == pytest.approx(theirs.df, rel=1e-12)


def test_functions_of_numpy_on_arrays():
    x = uarray(np.arange(1.0, 7).reshape(2, 3), 0.1) * ufloat(1, 0.01, "gain")
    whole = x.covariance()
    rows = np.array([[1, 1, 1, 0, 0, 0], [0, 0, 0, 1, 1, 1]])
    assert np.allclose(np.sum(x, axis=1).covariance(), rows @ whole @ rows.T)
    assert np.allclose(np.mean(x, axis=0).value, [2.5, 3.5, 4.5])
    assert np.sum(x).u == pytest.approx(x.sum().u) and np.mean(x).value == 3.5
    both = np.concatenate([x.reshape(6), x.reshape(6)])
    assert np.allclose(both.covariance(), np.block([[whole, whole], [whole, whole]]))
    assert np.allclose(np.stack([x, x]).value[1], x.value)
    steps = np.array([[-1.0, 1, 0], [0, -1, 1]])
    assert np.allclose(np.diff(x[0]).covariance(), steps @ whole[:3, :3] @ steps.T)
    assert np.all((x.copy() - x).u == 0)
    with pytest.raises(TypeError):
        np.max(x)


def test_numbers_beside_arrays():
    g = ufloat(2.0, 0.1, "g")
    for y in (g * np.arange(3), np.arange(3) * g, np.arange(3.0) * g):
        assert isinstance(y, UncertainArray) and np.allclose(y.u, [0, 0.1, 0.2])
    assert np.hypot(g, ufloat(3.0, 0.1)).value == pytest.approx(13**0.5)
    assert np.log2(g).u == pytest.approx(0.05 / np.log(2))
    with pytest.raises(TypeError):
        math.sqrt(g)
    with pytest.raises(TypeError):
        np.array([g, g], dtype=float)
    kept = uarray([g, ufloat(3.0, 0.2)], 0)
    assert np.allclose(kept.u, [0.1, 0.2]) and kept[0].correlation(g) == pytest.approx(1)


def test_a_budget_has_a_line_for_each_array():
    x = uarray(np.ones(20), 0.1, "readings") * ufloat(1, 0.01, "gain")
    assert [name for name, _ in x.mean().budget()] == ["readings", "gain"]
    assert x.mean().budget()[0][1] == pytest.approx(0.1 / math.sqrt(20))


def test_complex_numbers():
    gtc = pytest.importorskip("GTC")
    from proofmass import ucomplex

    z = ucomplex(1 + 2j, (0.1, 0.2), correlation=0.5, dof=9)
    ref = gtc.ucomplex(1 + 2j, (0.01, 0.01, 0.01, 0.04), 9)
    w, ref_w = z * z.conjugate() / (3 + 1j), ref * ref.conjugate() / (3 + 1j)
    assert w.value == pytest.approx(complex(ref_w.x))
    assert w.real.u == pytest.approx(ref_w.real.u) and w.imag.u == pytest.approx(ref_w.imag.u)
    assert abs(z).u == pytest.approx(gtc.magnitude(ref).u)
    assert z.phase().u == pytest.approx(gtc.phase(ref).u)
    assert (z - z).real.u == 0 and (z**2).value == (1 + 2j) ** 2
    assert pickle.loads(pickle.dumps(z)) == z
    assert (ufloat(2, 0.1) * z).value == 2 + 4j
    with pytest.raises(DataError):
        ucomplex(1, (0.1, -0.1))


def test_operands_that_are_none():
    x = uarray([1.0, 2.0], 0.1)
    for wrong in (None, object(), 1j, "2", np.datetime64("2026-01-01"), np.ma.masked_array([1.0, 2.0], mask=[0, 1])):
        with pytest.raises(TypeError):
            x * wrong
    with pytest.raises(TypeError):
        _ = x == 1
    with pytest.raises(ValueError):
        ufloat(1, 0.1).U(95)
    with pytest.raises(ValueError):
        ufloat(0, 0.1) ** (-(2**31))
    big = uarray([1e200], 1e199)
    assert np.arctan2(big, big)[0].u == pytest.approx(0, abs=1e-12)
    assert np.arctan2(big, uarray([1e200], 1e199))[0].u == pytest.approx(0.0707, rel=1e-2)
    named = uarray([1.0, 2.0], 0.1, "a\nb")
    assert (named - named[0]).u[0] == 0
    assert uarray([ufloat(1.0, 0.5)], 0.1)[0].u == pytest.approx(0.26**0.5)


def test_processes_that_were_forked_have_causes_of_their_own():
    import multiprocessing
    import sys

    if sys.platform == "win32":
        pytest.skip("there is no fork here")
    with multiprocessing.get_context("fork").Pool(2) as pool:
        numbers = pool.map(_one_of_its_own, range(2), chunksize=1) + [ufloat(1.0, 0.1)]
    assert sum(numbers, ufloat(0, 0)).u == pytest.approx(0.1 * 3**0.5)


def _one_of_its_own(_):
    import time

    time.sleep(0.2)
    return ufloat(1.0, 0.1)


def test_masks_are_refused():
    masked = np.ma.masked_array([1.0, 2.0], mask=[0, 1])
    for call in (lambda: uarray(masked, 0.1), lambda: uarray([1.0, 2.0], masked)):
        with pytest.raises(RequestError, match="masked"):
            call()
    assert uarray(3.0, 0.1).shape == () and uarray(3.0, 0.1)[()].u == 0.1


@pytest.mark.parametrize(
    "value, u, spec, text",
    [
        (1.23456, 0.00123, "", "1.2346(12)"),
        (1.23456, 0.00123, ".2u", "1.2346±0.0012"),
        (1.23456, 0.00123, ".1uS", "1.235(1)"),
        (1.23456, 0.00123, ".3f", "1.235±0.001"),
        (1.23456, 0.00123, ".3e", "1.235e+00±1.230e-03"),
        (1.23456, 0.00123, "+.2u", "+1.2346±0.0012"),
        (1.23456, 0.00123, ">20.2u", "       1.2346±0.0012"),
        (1234.0, 123.0, ".2u", "1230±120"),
        (12.3, 4.5, ".2uS", "12.3(4.5)"),
        (123456789.0, 1234.0, ".2u", "(1.234568±0.000012)e+08"),
        (1e-9, 1e-11, ".2uS", "1.000(10)e-09"),
        (0.0, 0.0096, ".1u", "0.00±0.01"),
        (2.5, 0.0, ".2u", "2.5±0"),
    ],
)
def test_formats(value, u, spec, text):
    assert f"{proofmass.ufloat(value, u):{spec}}" == text


def test_formats_that_are_none():
    for spec in (".0u", "d", ".2uQ", "abc"):
        with pytest.raises(ValueError, match="format"):
            format(proofmass.ufloat(1, 0.1), spec)
    assert f"{proofmass.ucomplex(1 + 2j, (0.1, 0.2)):.2u}" == "(1.00±0.10)+(2.00±0.20)j"


@pytest.mark.parametrize("scale", [1e-300, 1e-100, 1e100, 1e300])
def test_large_and_small_uncertainties(scale):
    """Squares leave the range of numbers long before u does."""
    sum_ = proofmass.ufloat(0, 3 * scale, dof=5) + proofmass.ufloat(0, 4 * scale, dof=9)
    array = proofmass.uarray([0.0, 0.0], 3 * scale, dof=5) + proofmass.uarray([0.0, 0.0], 4 * scale, dof=9)
    assert sum_.u == pytest.approx(5 * scale, rel=1e-12)
    assert np.allclose(array.u / scale, 5, rtol=1e-12)
    assert np.allclose(array.nu, sum_.nu, rtol=1e-12)


def test_overflow_is_refused():
    for call in (
        lambda: proofmass.ufloat(1, 1e308) * 1e10,
        lambda: proofmass.uarray([1.0], 1e308) * 1e10,
        lambda: (proofmass.ufloat(1, 1.5e308) + proofmass.ufloat(1, 1.5e308)).u,
        lambda: (proofmass.uarray([1.0], 1.5e308) + proofmass.uarray([1.0], 1.5e308)).u,
        lambda: proofmass.allan_deviation(np.tile([1e308, -1e308], 50), 1.0),
        lambda: proofmass.fit_sine(np.tile([1e308, -1e308, 0.0], 50), 1.0),
    ):
        with pytest.raises(ValueError, match="finite|number"):
            call()


def test_an_order_is_refused():
    with pytest.raises(TypeError):
        _ = proofmass.ufloat(1, 0.1) < proofmass.ufloat(2, 0.1)
