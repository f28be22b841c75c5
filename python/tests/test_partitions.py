"""Batches in the partitions of others: Dask and Spark give the rows that a loop gives, to the last bit."""

import os
import sys

import numpy as np
import pytest
from test_batch import options, readings

import proofmass

pandas = pytest.importorskip("pandas")
DEVICES = 7


@pytest.fixture(scope="module")
def frame():
    rng = np.random.default_rng(8)
    blocks = [readings(rng, [0.01 * k, 0, 0], 18 if k != 3 else 2) for k in range(DEVICES)]
    serials = [f"S{k}" for k, block in enumerate(blocks) for _ in block]
    rows = np.concatenate(blocks)
    columns = {"serial": serials, "row": np.arange(len(rows))}
    return pandas.DataFrame({**columns, "x_g": rows[:, 0], "y_g": rows[:, 1], "z_g": rows[:, 2]})


def rows_of(table):
    """Bias and scale of every device of a table, NaN and the error where one is refused.

    What shuffles rows changes the order of sums: they are put in order first.
    """
    batch = proofmass.calibrate_batch(table.sort_values("row").drop(columns="row"), threads=1, **options())
    names = [f"{kind}.{axis}" for kind in ("bias", "scale") for axis in "xyz"]
    found = []
    for serial, answer in batch.items():
        estimate = getattr(answer, "estimate", None)
        values = [np.nan if estimate is None else estimate[name].value for name in names]
        sizes = [np.nan if estimate is None else estimate[name].u for name in names]
        found.append([serial, *values, *sizes, str(answer) if estimate is None else ""])
    columns = ["serial", *names, *(f"u({name})" for name in names), "error"]
    return pandas.DataFrame(found, columns=[c.replace(".", "_") for c in columns])


@pytest.fixture(scope="module")
def expected(frame):
    return pandas.concat([rows_of(part) for _, part in frame.groupby("serial")], ignore_index=True)


def same(found, expected):
    found = found.sort_values("serial").reset_index(drop=True)
    for name in expected:
        ours, theirs = found[name].to_numpy(), expected[name].to_numpy()
        assert ours.tobytes() == theirs.tobytes() if ours.dtype == float else list(ours) == list(theirs), name
    assert found["error"].astype(bool).sum() == 1


def test_all_at_once(frame, expected):
    same(rows_of(frame), expected)


@pytest.mark.parametrize("partitions", [1, 2, 5])
def test_dask(frame, expected, partitions):
    dataframe = pytest.importorskip("dask.dataframe")
    # The rows of one device lie in one partition: it is the index.
    parts = dataframe.from_pandas(frame.set_index("serial"), npartitions=partitions)
    made = parts.map_partitions(lambda part: rows_of(part.reset_index()), meta=expected.iloc[:0])
    same(made.compute(scheduler="threads"), expected)


@pytest.fixture(scope="module")
def spark():
    sql = pytest.importorskip("pyspark.sql")
    from pyspark import cloudpickle

    # Its workers do not find the modules of tests.
    for name in (__name__, "test_batch"):
        cloudpickle.register_pickle_by_value(sys.modules[name])
    os.environ.setdefault("PYSPARK_PYTHON", sys.executable)
    os.environ.setdefault("SPARK_LOCAL_IP", "127.0.0.1")
    builder = sql.SparkSession.builder.master("local[2]").config("spark.ui.enabled", "false")
    try:
        session = builder.config("spark.sql.shuffle.partitions", "3").getOrCreate()
    except Exception as error:
        pytest.skip(f"Spark does not start here: {error}")
    yield session
    session.stop()


@pytest.mark.parametrize("partitions", [1, 4])
def test_spark(spark, frame, expected, partitions):
    kinds = ", ".join(f"`{name}` {'string' if name in ('serial', 'error') else 'double'}" for name in expected)
    table = spark.createDataFrame(frame).repartition(partitions)
    made = table.groupBy("serial").applyInPandas(rows_of, kinds).toPandas()
    same(made, expected)
    # The rows of a partition as batches of Arrow.
    pyarrow = pytest.importorskip("pyarrow")

    def partition(batches):
        if batches := list(batches):
            whole = pyarrow.Table.from_batches(batches).to_pandas()
            yield from pyarrow.Table.from_pandas(rows_of(whole), preserve_index=False).to_batches()

    by_device = spark.createDataFrame(frame).repartition(partitions, "serial")
    same(by_device.mapInArrow(partition, kinds).toPandas(), expected)
