"""Records from Python: filed, recalled, exported; the commands are those of the command line."""

import pytest

import proofmass
from proofmass import records


@pytest.fixture(scope="module")
def filed(tmp_path_factory, command_line):
    folder = tmp_path_factory.mktemp("records")
    place = str(folder / "lab.records")
    campaign = proofmass.init(kind="shaker-single", output=folder / "single")
    toml = campaign / "campaign.toml"
    toml.write_text(toml.read_text().replace('serial = "…"', 'serial = "0042"'))
    proofmass.calibrate.quiet(campaign).write(folder / "result")
    records.add_standard(records=place, serial="R-7")
    records.add_certificate(
        "R-7", records=place, number="C-1", valid_from="2020-01-01", file=str(campaign / "reference.csv")
    )
    records.add_result(str(folder / "result"), records=place)
    return place, folder


def test_a_recall_has_the_effect_of_the_error(filed):
    place, _ = filed
    recall = records.recall("R-7", error=1.0, since="2020-01-01", records=place)
    (result,) = recall["results"]
    assert len(result["effects"]) == 7
    for effect in result["effects"]:
        assert effect["relative"] == pytest.approx(-0.01, rel=1e-3)


def test_devices_and_histories_are_data(filed):
    place, _ = filed
    assert [d["standard"] for d in records.list(records=place)] == [True, False]
    names = {h["series"]["name"] for h in records.history("0042", records=place)}
    assert "S.modulus[frequency=160]" in names
    assert records.check(records=place)["damage"] == []


def test_tables_are_read_by_pyarrow(filed):
    place, folder = filed
    parquet = pytest.importorskip("pyarrow.parquet")
    records.export(records=place, parquet=True, output=folder / "tables")
    table = parquet.read_table(folder / "tables" / "quantities.parquet").to_pydict()
    (history,) = [
        h for h in records.history("0042", records=place) if h["series"]["name"] == "S.modulus[frequency=160]"
    ]
    row = table["quantity"].index("S.modulus[frequency=160]")
    assert table["value"][row] == history["series"]["points"][0]["value"]


def test_what_is_not_there_is_said(filed):
    place, folder = filed
    with pytest.raises(proofmass.RequestError, match="no device"):
        records.show("nobody", records=place)
    with pytest.raises(proofmass.ProofmassError, match="there are no records"):
        records.list(records=str(folder / "other.records"))
