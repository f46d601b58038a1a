"""Surveys of an object store: a server of S3 on loopback, workers of Dask that fetch what they work on."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import palpate
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from cluster import Cluster
from conftest import TRACES, command

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no file has the name of a URL")

FIT = {"by": "finger", "names": "f{finger}.csv", "terms": 1}
WORDS = ("--by", "finger", "--names", "f{finger}.csv", "--terms", 1)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which files lie by the names that the objects have."""
    folder = tmp_path_factory.mktemp("store")
    inside = folder / "s3:" / "lab" / "grasps"
    (inside / "day=1").mkdir(parents=True)
    (trace,) = palpate.read(TRACES / "table-3.1-row-01.csv")
    long = []
    for finger in range(8):
        columns = {name: values for name, values in trace.to_dict().items() if name != "time_s"}
        columns["force_N"] = columns["force_N"] * (1 + 0.001 * finger)
        made = palpate.DataSet.from_arrays(trace.time, columns=columns, head=trace.head)
        made[0].write(inside / "day=1" / f"f{finger}.csv")
        names = {"trace_id": [f"g{finger}"] * len(trace), "finger": [str(finger)] * len(trace)}
        long.append(pa.table({**names, "time_s": trace.time, **columns}))
    (inside / "f9.csv").write_text("no trace")
    (inside / "notes.txt").write_text("nothing")
    pq.write_table(pa.concat_tables(long), folder / "s3:" / "lab" / "long.parquet", compression="zstd")
    return folder


@pytest.fixture(scope="module")
def store(lab: Path) -> Iterator[None]:
    """The same objects behind a server, which this process and those that it begins find by their environment."""
    import fsspec
    from moto.server import ThreadedMotoServer

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    server.start()
    _, port = server.get_host_and_port()
    known = {
        "AWS_ENDPOINT_URL": f"http://127.0.0.1:{port}",
        "AWS_ACCESS_KEY_ID": "test",
        "AWS_SECRET_ACCESS_KEY": "test",
        "AWS_DEFAULT_REGION": "us-east-1",
    }
    before = {name: os.environ.get(name) for name in known}
    os.environ.update(known)
    s3 = fsspec.filesystem("s3")
    s3.mkdir("lab")
    s3.put(str(lab / "s3:" / "lab") + "/", "lab/", recursive=True)
    yield
    server.stop()
    for name, value in before.items():
        os.environ.pop(name) if value is None else os.environ.update({name: value})


@pytest.fixture
def cluster(store: None, tmp_path: Path) -> Iterator[Cluster]:
    made = Cluster(2, tmp_path)
    try:
        yield made
    finally:
        made.end()


def groups(results: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (results / "groups").iterdir()}


def test_a_survey_of_a_store_has_the_bytes_of_files_of_the_same_names(
    lab: Path, cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(lab)
    command("survey", "fit", "fung", "s3://lab/grasps", *WORDS, "-o", tmp_path / "files")
    monkeypatch.chdir(tmp_path)
    # Nothing of the store lies here: the workers fetch it.
    found = palpate.survey("fit", "s3://lab/grasps", out="store", engine=cluster.address, **FIT)
    assert groups(tmp_path / "store") == groups(tmp_path / "files")
    frame = found.to_frame().set_index("finger")
    assert (frame.status == "done").sum() == 8 and frame.loc["9", "status"] == "refused"
    # What is done is known by name, size and time of the objects: the same call finds nothing to do.
    palpate.survey("fit", "s3://lab/grasps", out="store", engine=cluster.address, **FIT)
    # From a shell, of one object with many traces.
    call = ["fit", "fung", "s3://lab/long.parquet", "--by", "finger", "--terms", "1", "-o", "shell"]
    module = [sys.executable, "-m", "palpate.survey", *call, "--engine", cluster.address]
    done = subprocess.run(module, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "8 groups by finger: 8 done" in done.stdout
    monkeypatch.chdir(lab)
    command("survey", *call[:-1], tmp_path / "long")
    assert groups(tmp_path / "shell") == groups(tmp_path / "long")


def test_without_an_engine_this_machine_fetches(store: None, lab: Path, tmp_path: Path) -> None:
    palpate.survey("segment", "s3://lab/long.parquet", by="trace_id", out=tmp_path / "here")
    found = palpate.survey("segment", lab / "s3:/lab/long.parquet", by="trace_id", out=tmp_path / "files")
    assert groups(tmp_path / "here") == groups(tmp_path / "files")
    assert len(found.to_frame()) == 8


def test_what_a_store_does_not_have_is_told(store: None, tmp_path: Path) -> None:
    for data, words in (
        ("s3://nobody/grasps", "s3://nobody/grasps: "),
        ("s3://lab/none", "s3://lab/none: no traces in it"),
        ("nothing://lab", "nothing://lab: "),
        (["s3://lab/grasps", str(TRACES)], "of files or of URLs, not of both"),
    ):
        with pytest.raises(palpate.Error, match=words):
            palpate.survey("segment", data, by="trace", out=tmp_path / "no")
    assert not (tmp_path / "no").exists()
