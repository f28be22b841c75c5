"""Many devices in one table."""

import numpy as np
import pytest

import proofmass


def readings(rng, bias, count=18, noise=1e-3):
    """Means in count attitudes, g."""
    up = rng.normal(size=(count, 3))
    up /= np.linalg.norm(up, axis=1)[:, None]
    return up * 1.01 + bias + rng.normal(0, noise, up.shape)


@pytest.fixture(scope="module")
def table():
    rng = np.random.default_rng(4)
    blocks, serials = [], []
    for k in range(5):
        count = 18 if k != 3 else 2
        blocks.append(readings(rng, [0.01 * k, 0, 0], count))
        serials += [f"S{4 - k}"] * count
    rows = np.concatenate(blocks)
    return {"serial": np.array(serials), "x_g": rows[:, 0], "y_g": rows[:, 1], "z_g": rows[:, 2]}


def options():
    return {"rows": "readings", "columns": "x,y,z", "gravity": 9.80665, "gravity_uncertainty": 1e-4}


def test_one_row_for_each_device(table):
    batch = proofmass.calibrate_batch(table, **options())
    assert list(batch) == ["S4", "S3", "S2", "S1", "S0"]
    assert set(batch.errors) == {"S1"} and len(batch.results) == 4
    rows = batch.to_dict()
    assert rows["serial"] == list(batch)
    k = next(name for name in rows if name.startswith("bias.x"))
    assert rows[k][3] is None and rows["error"][3] and rows["error"][0] is None
    alone = {name: column[table["serial"] == "S2"] for name, column in table.items() if name != "serial"}
    assert proofmass.calibrate(alone, **options()).to_dict()["quantities"] == batch["S2"].to_dict()["quantities"]
    truth = [0.0, 0.01, 0.02, None, 0.04]
    for serial, bias in zip(batch, truth, strict=True):
        if bias is not None:
            q = batch[serial].estimate["bias.x"]
            assert abs(q.value - bias * 9.80665) < 5 * q.u


def test_rows_in_any_order_and_any_number_of_threads(table):
    mixed = np.random.default_rng(1).permutation(len(table["serial"]))
    order = np.argsort(table["serial"][mixed], kind="stable")
    shuffled = {name: column[mixed][order] for name, column in table.items()}
    a = proofmass.calibrate_batch(shuffled, threads=1, **options())
    b = proofmass.calibrate_batch(shuffled, threads=8, **options())
    assert a.to_dict() == b.to_dict()


def test_data_frames(table):
    pandas = pytest.importorskip("pandas")
    polars = pytest.importorskip("polars")
    first = proofmass.calibrate_batch(pandas.DataFrame(table), **options())
    assert first.to_dict() == proofmass.calibrate_batch(polars.DataFrame(table), **options()).to_dict()
    assert first.to_pandas()["error"].isna().sum() == 4
    assert first.to_polars().height == 5


def test_tables_that_are_none(table):
    for wrong in ({"x": np.zeros(3)}, np.zeros((3, 3)), {**table, "y_g": np.zeros(3)}, {"serial": np.zeros(0)}):
        with pytest.raises(proofmass.RequestError):
            proofmass.calibrate_batch(wrong, **options())


def test_serials_of_every_kind(table):
    for wrong, says in ((None, "missing"), (float("nan"), "missing"), ([1], "names nothing")):
        serials = list(table["serial"])
        serials[5] = wrong
        column = np.empty(len(serials), object)
        column[:] = serials
        with pytest.raises(proofmass.RequestError, match=says):
            proofmass.calibrate_batch({**table, "serial": column}, **options())
    with pytest.raises(proofmass.RequestError, match="folder"):
        proofmass.calibrate_batch(table, output="out", **options())


def test_a_mask_is_refused_for_its_device(table):
    masked = np.ma.masked_array(table["x_g"], mask=np.arange(len(table["x_g"])) == 0)
    batch = proofmass.calibrate_batch({**table, "x_g": masked}, **options())
    assert "masked" in str(batch["S4"])
