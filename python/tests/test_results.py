"""What a result says and how it is kept."""

import copy
import pickle
import warnings

import numpy as np
import pytest

import proofmass


@pytest.fixture(scope="module")
def result(examples):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", proofmass.ProofmassWarning)
        return proofmass.calibrate(examples / "hand-held")


def test_quantities_are_those_of_the_truth(result, examples):
    """Values of the simulation, within their intervals but for what chance allows: 9 parameters, 95 %."""
    import json

    truth = json.loads((examples / "hand-held" / "truth.json").read_text())
    q = result.estimate["bias.x"]
    assert q.U == pytest.approx(q.k * q.u)
    assert q.interval == pytest.approx((q.value - q.U, q.value + q.U))
    assert q.unit == "count"
    assert float(q) == q.value
    assert "bias.x" in str(q)
    assert truth
    with pytest.raises(KeyError, match="bias.x"):
        result.estimate["bias.w"]


def test_covariance_agrees_with_the_quantities(result):
    c = result.covariance
    for k, name in enumerate(c.names):
        assert np.sqrt(c.matrix[k, k]) == pytest.approx(result.estimate[name].u)
    assert c.between("bias.x", "scale.x") == c.matrix[0, c.names.index("scale.x")]
    assert np.asarray(c).shape == (9, 9)


def test_parameters_keep_their_correlation(result):
    x, s = result.uncertain("bias.x"), result.uncertain("scale.x")
    assert x.covariance(s) == pytest.approx(result.covariance.between("bias.x", "scale.x"))
    with pytest.raises(KeyError):
        result.uncertain("nothing")


def test_findings(result):
    assert all(f.severity in ("note", "warning", "decision") for f in result.findings)
    assert result.needs_decision is False


def test_copies_are_equal(result):
    for other in (pickle.loads(pickle.dumps(result)), copy.copy(result), copy.deepcopy(result)):
        assert other == result
        assert other.to_json() == result.to_json()


def test_a_result_is_read_again(result, tmp_path):
    result.write(tmp_path / "r")
    assert proofmass.read(tmp_path / "r") == result
    assert proofmass.read(tmp_path / "r" / "result.json").estimate.keys() == result.estimate.keys()
    with pytest.raises(proofmass.DataError):
        proofmass.read(tmp_path / "nothing")
    (tmp_path / "damaged.json").write_text("{")
    with pytest.raises(proofmass.DataError, match="damaged"):
        proofmass.read(tmp_path / "damaged.json")


def test_a_folder_of_others_is_kept(result, tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(proofmass.OutputError, match="force|holds"):
        result.write(tmp_path)
    result.write(tmp_path, force=True)
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_tables(result):
    assert "standstills.csv" in result.tables
    table = result.table("standstills")
    assert all(len(column) == 24 for column in table.values())
    with pytest.raises(proofmass.DataError, match="standstills"):
        result.table("nothing")


def test_data_frames(result):
    pandas = pytest.importorskip("pandas")
    polars = pytest.importorskip("polars")
    frame = result.to_pandas()
    assert isinstance(frame, pandas.DataFrame)
    assert frame.loc["bias.x", "value"] == result.estimate["bias.x"].value
    frame = result.to_polars()
    assert isinstance(frame, polars.DataFrame)
    assert frame["value"].to_list() == [q.value for q in result.estimate.values()]


def test_the_page_of_a_notebook(result):
    html = result._repr_html_()
    assert "<script" not in html
    assert "<svg" in html and "bias.x" in html


def test_a_plot(result):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    axes = result.plot()
    assert next(label.get_text() for label in axes[0].get_yticklabels()) == "bias.x"


def test_the_summary(result):
    assert "bias.x" in str(result) and "bias.x" in repr(result)


def test_text_stays_text(tmp_path):
    file = tmp_path / "<b>.toml"
    file.write_text(
        'title = "<script>alert(1)</script>"\n[[input]]\nname="m"\nunit="kg"\nvalue=2.0\nu=0.1\n[[output]]\nname="w"\nunit="kg"\nexpression="2*m"\n'
    )
    html = proofmass.uncertainty(file, trials=1000)._repr_html_()
    assert "<script>" not in html


def test_compensation_of_arrays(result, examples, tmp_path):
    calibration = result.calibration
    rows = np.loadtxt(examples / "hand-held" / "recording.csv", delimiter=",", skiprows=1, max_rows=200)
    outputs = rows[:, -3:]
    ours = calibration.apply(outputs)
    result.write(tmp_path / "r")
    theirs = proofmass.apply(tmp_path / "r" / "calibration.json", examples / "hand-held" / "recording.csv")
    columns = list(theirs)[-3:]
    assert np.array_equal(ours, np.column_stack([theirs[c][:200] for c in columns]))
    assert np.allclose(np.linalg.norm(ours[:50], axis=1), 9.8, atol=0.2)
    assert pickle.loads(pickle.dumps(calibration)) == calibration
    assert np.array_equal(proofmass.Calibration(tmp_path / "r" / "calibration.json").apply(outputs[0]), ours[0])
    assert calibration.apply(np.empty((0, 3))).shape == (0, 3)
    for wrong in (np.zeros((3, 5)), np.zeros(4), np.zeros((2, 3, 3))):
        with pytest.raises(proofmass.RequestError):
            calibration.apply(wrong)
    with pytest.raises(proofmass.DataError, match=r"outputs\[\(1, 2\)\]"):
        calibration.apply([[1, 2, 3], [4, 5, np.nan]])


def test_streams_of_arrow(result):
    """Taken by those who read them, and forgotten by those who do not."""
    from proofmass import _arrow

    pyarrow = pytest.importorskip("pyarrow")
    polars = pytest.importorskip("polars")
    before = len(_arrow._held)
    table = pyarrow.table(result)
    assert table["value"].to_pylist() == [q.value for q in result.estimate.values()]
    assert table["name"].to_pylist() == list(result.estimate)
    assert polars.DataFrame(result)["U"].to_list() == [q.U for q in result.estimate.values()]
    result.__arrow_c_stream__()
    del table
    assert len(_arrow._held) == before
