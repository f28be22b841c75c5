"""Data in every shape: read, or refused by name."""

import io
import logging
import warnings

import numpy as np
import pytest
from conftest import quiet

import proofmass
from proofmass import DataError, ProofmassError, RequestError


def noise(data, **options):
    return quiet(proofmass.noise, data, **options)


def n_of(result):
    return [q.value for name, q in result.estimate.items() if ".N" in name or name.endswith("N")]


@pytest.fixture(scope="module")
def expected():
    array = np.random.default_rng(3).normal(0, 1e-3, 20_000)
    return array, noise(array, rate=100.0)


def test_forms_of_one_array(expected, tmp_path):
    array, whole = expected
    wide = np.empty((len(array), 2))
    wide[:, 0] = array
    read_only = array.copy()
    read_only.flags.writeable = False
    forms = [
        array[:, None],
        wide[:, 0],
        array.astype(">f8"),
        read_only,
        array.tolist(),
        memoryview(array),
        np.asfortranarray(array[:, None]),
    ]
    for form in forms[:-2]:
        assert n_of(noise(form, rate=100.0)) == n_of(whole), type(form)
    file = io.BytesIO()
    np.save(file, array)
    file.seek(0)
    assert n_of(noise(file, rate=100.0, unit="m/s²")) == n_of(whole)
    assert n_of(noise(file.getvalue(), rate=100.0, unit="m/s²")) == n_of(whole)
    text = io.StringIO("acc_m_s2\n" + "\n".join(map(repr, array.tolist())))
    assert n_of(noise(text, rate=100.0, unit="m/s²")) == n_of(whole)


def test_single_precision_and_integers():
    counts = np.random.default_rng(4).integers(-2000, 2000, 20_000)
    as_float = noise(counts.astype(float), rate=10.0, unit="count")
    for kind in (np.int16, np.int64, np.float32):
        assert n_of(noise(counts.astype(kind), rate=10.0, unit="count")) == n_of(as_float)


def test_units():
    array = np.random.default_rng(3).normal(0, 1e-3, 20_000)
    si, g = noise(array * 9.80665, rate=100.0), noise(array, rate=100.0, unit="g")
    assert n_of(g) == pytest.approx(n_of(si), rel=1e-12)


def test_times_by_name():
    array = np.random.default_rng(3).normal(0, 1e-3, 20_000)
    table = {"time_s": np.arange(20_000) / 100, "acc_x (m/s²)": array}
    assert n_of(noise(table)) == pytest.approx(n_of(noise(array, rate=100.0)), rel=1e-9)
    dates = np.datetime64("2026-01-01") + (np.arange(20_000) * 10).astype("timedelta64[ms]")
    assert n_of(noise({"time": dates, "acc_x (m/s²)": array})) == pytest.approx(n_of(noise(table)), rel=1e-6)


def test_tables_of_others():
    pandas = pytest.importorskip("pandas")
    polars = pytest.importorskip("polars")
    pyarrow = pytest.importorskip("pyarrow")
    columns = {"time_s": np.arange(20_000) / 100, "acc_x (m/s²)": np.random.default_rng(3).normal(0, 1e-3, 20_000)}
    expected = n_of(noise(columns))
    for table in (pandas.DataFrame(columns), polars.DataFrame(columns), pyarrow.table(columns)):
        assert n_of(noise(table)) == expected, type(table)


@pytest.mark.parametrize(
    "data, kind, says",
    [
        (np.zeros((3, 500)), RequestError, "array.T"),
        (np.zeros((0, 3)), DataError, "empty"),
        (np.array([1.0, np.nan, 3.0]), DataError, r"\[1\] is nan"),
        (np.array([[1.0, 2, 3], [4, np.inf, 6]] * 40), DataError, r"\(1, 1\)\] is inf"),
        (np.zeros((2, 3, 4)), RequestError, "shape"),
        (np.array(["a", "b"]), RequestError, "no numbers"),
        (np.array([object(), object()]), RequestError, "no numbers"),
        (np.zeros(100, complex), RequestError, "complex"),
        (np.ma.masked_array(np.zeros(100), mask=np.arange(100) == 5), RequestError, "masked"),
        (np.lib.stride_tricks.as_strided(np.zeros(1), (2**33,), (0,)), RequestError, "less memory"),
        (np.lib.stride_tricks.as_strided(np.zeros(2**16), (2**15, 2**15), (8, 8)), RequestError, "less memory"),
        (None, RequestError, "None"),
        ({}, RequestError, "no columns"),
        ({"a": np.zeros(3), "b": np.zeros(4)}, RequestError, "4 values"),
        ({"a": np.zeros((3, 2))}, RequestError, "one dimension"),
        (b"", ProofmassError, "empty|no"),
        (7, RequestError, "shape|array"),
    ],
)
def test_what_is_no_recording(data, kind, says):
    with pytest.raises(kind, match=says):
        proofmass.noise(data, rate=100.0)


@pytest.mark.parametrize("rate", [0, -1.0, float("nan"), float("inf")])
def test_rates_that_are_none(rate, rest):
    with pytest.raises(ProofmassError):
        proofmass.noise(rest, rate=rate)


def test_an_array_has_no_times(rest):
    with pytest.raises(RequestError, match="rate="):
        proofmass.noise(rest)


def test_times_that_go_back(rest):
    times = np.arange(len(rest)) / 100
    times[500] = 0
    with pytest.raises(ProofmassError):
        with warnings.catch_warnings():
            warnings.simplefilter("error", proofmass.ProofmassWarning)
            try:
                proofmass.noise({"time_s": times, "x (m/s²)": rest[:, 0]})
            except proofmass.ProofmassWarning as warning:
                raise ProofmassError(str(warning)) from warning


def test_a_unit_of_another_dimension(rest):
    with pytest.raises(ProofmassError, match="K|unit|temperature|acceleration"):
        proofmass.calibrate(rest, rate=100.0, unit="V/°C", latitude=45.0)


def test_a_keyword_that_is_none(rest):
    with pytest.raises(TypeError, match="did you mean 'statistic'"):
        proofmass.noise(rest, rate=100.0, statistics="oadev")
    with pytest.raises(TypeError):
        proofmass.noise()


def test_hints_are_in_keywords(rest, tmp_path):
    with pytest.raises(ProofmassError) as caught:
        proofmass.calibrate(rest, rate=100.0)
    assert "--" not in caught.value.hint, caught.value.hint
    with pytest.raises(DataError) as caught:
        proofmass.noise(tmp_path / "there-is-none.csv")
    assert "there-is-none.csv" in str(caught.value)


def test_a_finding_is_a_warning_with_its_code(tmp_path):
    rng = np.random.default_rng(1)
    drifting = rng.normal(0, 1e-3, 20_000) + np.where(np.arange(20_000) > 10_000, 0.05, 0)
    with pytest.warns(proofmass.ProofmassWarning) as caught:
        result = proofmass.noise(drifting, rate=100.0)
    codes = {w.message.code for w in caught}
    assert codes == {f.code for f in result.findings if f.severity != "note"}
    assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for code in codes:
            warnings.filterwarnings("ignore", message=f"{code}:", category=proofmass.ProofmassWarning)
        proofmass.noise(drifting, rate=100.0)


def test_notes_go_to_the_log(examples, caplog, tmp_path):
    with caplog.at_level(logging.INFO, logger="proofmass"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            proofmass.calibrate(examples / "hand-held", output=tmp_path / "r")
    assert any("written" in record.message for record in caplog.records)


def test_errors_are_pickled():
    import pickle

    error = RequestError("what", ["where"], "hint")
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.place, again.hint) == (str(error), ("where",), "hint")


def test_a_warning_is_made_again_from_its_arguments(examples):
    import pickle

    finding = proofmass.calibrate(examples / "hand-held").findings[0]
    warning = proofmass.ProofmassWarning(finding)
    assert str(warning).startswith(f"{finding.code}: ")
    for again in (type(warning)(*warning.args), pickle.loads(pickle.dumps(warning))):
        assert (str(again), again.code) == (str(warning), finding.code)


def test_answers_without_a_result(examples):
    assert any(row["format"] == "npy" for row in proofmass.formats())
    assert proofmass.explain("gaps-in-record")["code"] == "gaps-in-record"
    with pytest.raises(ProofmassError, match="neither"):
        proofmass.explain("no-such-word")
    assert proofmass.inspect(examples / "hand-held" / "recording.csv")["rows"] > 1000


def test_requests_as_json():
    result = proofmass.run(
        {
            "job": "uncertainty",
            "model": {
                "input": [{"name": "m", "unit": "kg", "value": 2.0, "u": 0.1}],
                "output": [{"name": "w", "unit": "kg", "expression": "2 * m"}],
            },
        }
    )
    assert result.estimate["w"].value == 4 and result.estimate["w"].u == pytest.approx(0.2)
    with pytest.raises(RequestError, match="job|request"):
        proofmass.run({"job": "nothing"})


def test_requests_of_commands(rest):
    """The keywords of a function as JSON, its data beside them."""
    asked = quiet(proofmass.run, {"command": "noise", "rate": 100.0, "terms": ["N", "B"]}, rest)
    assert asked.to_dict()["quantities"] == noise(rest, rate=100.0, terms=["N", "B"]).to_dict()["quantities"]
    assert proofmass.run({"command": "velocity drift", "noise_density": 1e-3}).kind == "velocity-drift"


@pytest.mark.parametrize(
    "request_, says",
    [
        ({"job": "uncertainty", "modell": {}}, "no key `modell`[^?]*did you mean `model`"),
        ({"job": "velocity-drift", "ofset": 1.0}, "no key `ofset`"),
        ({"job": "uncertainly"}, "did you mean `uncertainty`"),
        ({"command": "nois"}, "did you mean 'noise'"),
        ({"command": "noise", "rte": 1.0}, "did you mean 'rate'"),
        ({"command": "noise", "job": "noise"}, "not both"),
        ({"command": "noise"}, "missing"),
        ([], "mapping"),
    ],
)
def test_requests_that_are_none(request_, says):
    with pytest.raises(RequestError, match=f"(?s){says}"):
        proofmass.run(request_)


def test_channels_of_an_array_have_names(rest):
    def names(array, **options):
        return {name.split(".")[0] for name in noise(array, rate=100.0, **options).estimate}

    assert names(rest) == {"x", "y", "z"}
    assert names(rest, columns=("a", "b", "c")) == {"a", "b", "c"}
    assert names(rest, columns=(3, 1)) == {"x", "z"}
    assert names(rest[:, 0], columns="axial") == {"axial"}
    assert names(np.hstack([rest, rest * 2])) == {f"column{k + 1}" for k in range(6)}
    with pytest.raises(RequestError, match="in this order"):
        noise(rest, rate=100.0, columns="z,y,x")


def test_a_topic_that_is_none(rest, tmp_path):
    for topic in ("/imu0\nevil: 1", "", "a b", "#"):
        with pytest.raises(RequestError, match="topic"):
            noise(rest, rate=100.0, rostopic=topic, imu_yaml=tmp_path / "imu.yaml")


def test_arrow_without_its_package():
    """Nulls are gaps, units stand in the metadata, text is left out."""
    pyarrow = pytest.importorskip("pyarrow")
    n = 20_000
    noise_of = np.random.default_rng(3).normal(0, 1e-3, n)
    present = np.ones(n, bool)
    # At random: at even distances they would look like stamps of a slower clock.
    present[np.random.default_rng(9).choice(np.arange(100, n), 20, replace=False)] = False
    fields = [
        pyarrow.field("time", pyarrow.timestamp("us")),
        pyarrow.field("acc_x", pyarrow.float64(), metadata={"unit": "g"}),
        pyarrow.field("who", pyarrow.string()),
    ]
    stamps = np.datetime64("2026-01-01", "us") + np.arange(n) * 10_000
    arrays = [pyarrow.array(stamps), pyarrow.array(noise_of, mask=~present), pyarrow.array(["x"] * n)]
    table = pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields))

    class Stream:
        def __arrow_c_stream__(self, requested_schema=None):
            return pyarrow.table(table).slice(7).__arrow_c_stream__(requested_schema)

    from proofmass._arrow import columns_of

    columns, absent = columns_of(Stream())
    assert list(columns) == ["time_s", "acc_x (g)"]
    assert absent == 20
    assert np.array_equal(columns["acc_x (g)"], noise_of[7:][present[7:]])
    assert np.array_equal(columns["time_s"], (np.arange(7, n)[present[7:]] - 7) / 100)
    result = noise(Stream())
    assert any("gap" in f.code or "missing" in f.code for f in result.findings), result.findings
    with pytest.raises(RequestError, match="null"):
        noise(Stream(), rate=100.0)
    with pytest.raises(RequestError, match="no column of numbers"):
        noise(pyarrow.table({"who": ["x"]}))


def test_shapes_and_kinds():
    """Whatever numpy makes of the same numbers is read as the same numbers, or refused by an error of ours."""
    hypothesis = pytest.importorskip("hypothesis")
    from hypothesis import strategies as st
    from hypothesis.extra import numpy as hnp
    from numpy.lib.recfunctions import structured_to_unstructured

    from proofmass._data import recording

    kinds = st.one_of(hnp.floating_dtypes(), hnp.integer_dtypes(), hnp.boolean_dtypes(), hnp.complex_number_dtypes())

    @hypothesis.settings(max_examples=300, deadline=None)
    @hypothesis.given(st.data())
    def every(data):
        array = data.draw(hnp.arrays(data.draw(kinds), hnp.array_shapes(max_dims=3, max_side=9)))
        if array.ndim and data.draw(st.booleans()):
            array = array[
                tuple(
                    data.draw(st.sampled_from([slice(None), slice(None, None, -1), slice(0, None, 2)]))
                    for _ in range(array.ndim)
                )
            ]
        try:
            lent = recording(array, "array").lent
        except ProofmassError:
            return
        records = np.load(io.BytesIO(lent[1] + bytes(lent[2])), allow_pickle=False)
        back = structured_to_unstructured(records).reshape(array.shape)
        assert len(records) == len(array)
        assert np.array_equal(back.astype(float), array.astype(float))

    every()


def test_frames_keep_what_they_say():
    """Names of series, dates of an index, zones, nulls."""
    pandas = pytest.importorskip("pandas")
    polars = pytest.importorskip("polars")
    values = np.random.default_rng(3).normal(0, 1e-3, 20_000)
    stamps = pandas.date_range("2026-01-01", periods=20_000, freq="10ms")
    expected = n_of(noise({"time_s": np.arange(20_000) / 100, "acc_x_g": values}))
    series = pandas.Series(values, name="acc_x_g")
    assert n_of(noise(series, rate=100.0)) == pytest.approx(expected)
    assert n_of(noise(polars.Series("acc_x_g", values), rate=100.0)) == pytest.approx(expected)
    frame = pandas.DataFrame({"acc_x_g": values}, index=stamps)
    assert n_of(noise(frame)) == pytest.approx(expected, rel=1e-6)
    zoned = pandas.DataFrame({"t": stamps.tz_localize("Europe/Berlin"), "acc_x_g": values})
    assert n_of(noise(zoned)) == pytest.approx(expected, rel=1e-6)
    nullable = pandas.DataFrame({"time_s": np.arange(20_000) / 100, "acc_x_g": pandas.array(values, dtype="Float64")})
    nullable.loc[[700, 1234], "acc_x_g"] = pandas.NA
    assert any("gap" in f.code or "missing" in f.code for f in noise(nullable).findings)
    with pytest.raises(RequestError, match="collect"):
        noise(polars.LazyFrame({"acc_x_g": values}), rate=100.0)
    with pytest.raises(RequestError, match="to_datetime"):
        noise(pandas.DataFrame({"t": stamps.astype(str), "acc_x_g": values}))
    with pytest.raises(DataError, match="nan"):
        noise(pandas.DataFrame({"acc_x_g": np.where(np.arange(20_000) == 5, np.nan, values)}), rate=100.0)


def test_objects_in_the_place_of_files(examples, tmp_path):
    """A result or a calibration stands where the command line is given its file."""
    result = quiet(proofmass.calibrate, examples / "hand-held")
    recording = examples / "hand-held" / "recording.csv"
    result.write(tmp_path / "r")
    file = proofmass.apply(tmp_path / "r" / "calibration.json", recording)
    for calibration in (result, result.calibration, result.calibration.to_json()):
        applied = proofmass.apply(calibration, recording)
        assert all(np.array_equal(applied[name], file[name]) for name in file)
    headers = [proofmass.export(given, c=True) for given in (result, tmp_path / "r" / "calibration.json")]
    # Where it came from differs by its folder alone.
    assert headers[0] == headers[1].replace(f"{tmp_path}/r/", "")
    assert proofmass.test.orthogonality(result).estimate
    first, second = (noise(np.random.default_rng(k).normal(0, 1, 5000), rate=10.0) for k in (1, 2))
    assert proofmass.noise_compare([first, second]).kind == "noise-comparison"
    assert proofmass.render(first).estimate.keys() == first.estimate.keys()
    rows = np.loadtxt(recording, delimiter=",", skiprows=1)[:, -3:]
    applied = proofmass.apply(result, rows, rate=100.0, unit="count")
    assert np.allclose(np.column_stack(list(applied.values())[-3:]), result.calibration.apply(rows))


def test_velocity_of_arrays(simulated):
    recording = simulated / "axis" / "recording.csv"
    table = np.genfromtxt(recording, delimiter=",", names=True, deletechars="", encoding="utf-8")
    columns = {name: table[name] for name in table.dtype.names}
    options = dict(position="encoder", counts_per_turn=2000, radius=0.3, acceleration="acceleration")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", proofmass.ProofmassWarning)
        ours = proofmass.velocity.estimate(columns, **options)
        theirs = proofmass.velocity.estimate(recording, **options)
    assert {k: q.value for k, q in ours.estimate.items()} == {k: q.value for k, q in theirs.estimate.items()}
    v = ours.table("velocity")
    assert len(next(iter(v.values()))) == len(table)


def test_gaps_that_are_refused():
    values = np.random.default_rng(3).normal(0, 1e-3, 20_000)
    keep = np.ones(20_000, bool)
    keep[[500, 777, 12_345]] = False
    with pytest.raises(ProofmassError, match="too many gaps"):
        noise({"time_s": (np.arange(20_000) / 100)[keep], "acc_x_g": values[keep]}, refuse_gaps=True)


def test_masks_and_tables_are_not_taken_for_numbers(examples):
    masked = np.ma.masked_array(np.ones(100), mask=np.arange(100) == 5)
    for call in (
        lambda: noise({"acc_x (g)": masked}, rate=10.0),
        lambda: proofmass.allan_deviation(masked, 1.0),
        lambda: proofmass.fit_sine(masked, 1.0),
        lambda: proofmass.allan_deviation(np.ones(100, complex), 1.0),
    ):
        with pytest.raises(RequestError, match="masked|real"):
            call()
    pandas = pytest.importorskip("pandas")
    calibration = quiet(proofmass.calibrate, examples / "hand-held").calibration
    with pytest.raises(RequestError, match="order of its own"):
        calibration.apply(pandas.DataFrame(np.ones((4, 3)), columns=["z", "y", "x"]))


def test_a_stream_of_arrow_that_was_read():
    pyarrow = pytest.importorskip("pyarrow")

    class Kept:
        stream = pyarrow.table({"acc_x (g)": [1.0, 2.0] * 500}).__arrow_c_stream__()

        def __arrow_c_stream__(self, requested_schema=None):
            return self.stream

    pyarrow.table(Kept())
    with pytest.raises(DataError, match="read before"):
        noise(Kept(), rate=1.0)


def test_recordings_of_one_name_are_two(tmp_path):
    """Files in memory are told apart, whatever they are called."""
    for k in (1, 2):
        (tmp_path / str(k)).mkdir()
        (tmp_path / str(k) / "rec.csv").write_text("acc_g\n" + f"{k}.5\n" * 200)
    with open(tmp_path / "1" / "rec.csv", "rb") as a, open(tmp_path / "2" / "rec.csv", "rb") as b:
        out = proofmass.convert([a, b], rate=100.0, output=tmp_path / "o.csv")
    values = np.loadtxt(out, delimiter=",", skiprows=1, ndmin=2)[:, -1]
    assert (values[:200] == 1.5).all() and (values[200:] == 2.5).all()


@pytest.mark.parametrize("columns", [{1: np.ones(9), "1": np.ones(9)}, {"a\0b": np.ones(9)}, {"x" * 2000: np.ones(9)}])
def test_names_that_are_none(columns):
    with pytest.raises(RequestError, match="name"):
        noise(columns, rate=10.0)


def test_names_that_numpy_keeps_for_itself():
    values = np.random.default_rng(1).normal(0, 1, 5000)
    assert len(noise({"file": values, "allow_pickle": values}, rate=10.0, unit="V").estimate) > 0


def test_dates_far_and_fine():
    from proofmass._data import _seconds

    far = np.array(["3026-01-01", "3026-01-02"], "M8[s]")
    assert _seconds(far, "t")[0].tolist() == [0.0, 86_400.0]
    fine = np.datetime64("2026-01-01T00:00:00", "ns") + np.arange(5) * np.timedelta64(100, "ns")
    assert np.array_equal(_seconds(fine, "t")[0], np.arange(5) * 100 / 1e9)
    assert _seconds(np.array([2, -3], "m8[h]"), "t")[0].tolist() == [7200.0, -10_800.0]
    with pytest.raises(RequestError):
        _seconds(np.array([1, 2], "m8"), "t")


def test_places_to_write_to_are_places(rest, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for wrong in (np.zeros(3), b"x", io.BytesIO()):
        with pytest.raises(TypeError, match="place"):
            proofmass.noise(rest, rate=100.0, output=wrong)
    with pytest.raises(RequestError):
        proofmass.noise(rest, rate=100.0, output="-")
    with pytest.raises(TypeError):
        proofmass.init(rest, rate=100.0)
    assert list(tmp_path.iterdir()) == []


def test_numbers_whose_name_ends_like_that_of_dates():
    """A column that is called `speed_m_s` is no date, whatever table it comes from."""
    polars = pytest.importorskip("polars")
    from proofmass._data import recording

    values = np.array([3.0, 4.0, 5.0])
    table = {"speed_m_s": values, "x_s": values}
    for data in (table, polars.DataFrame(table)):
        lent = recording(data, "table").lent
        archive = np.load(io.BytesIO(bytes(lent[2])))
        assert all(np.array_equal(archive[name], values) for name in table)
