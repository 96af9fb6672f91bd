"""Jobs on a Ray cluster of two nodes on this machine."""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path

import cluster_jobs
import numpy as np
import pytest
from cluster_jobs import Nap, die, lack_a_module, sleep

from circumspect.cli.main import main
from circumspect.datasets import ObjectSet
from circumspect.datasets.gathered_set import GatheredScan, read_manifest
from circumspect.datasets.gathered_verification import verify_gathered
from circumspect.datasets.point_pack import write_point_pack
from circumspect.errors import InputError, MissingExtraError
from circumspect.evaluation.predictor import load_predictor
from circumspect.furniture import make_furniture
from circumspect.gathering import GatherSettings, ray_pool
from circumspect.gathering.ray_pool import RayPool
from circumspect.gathering.simulated_task import SimulatedTask, scanned

pytestmark = [
    pytest.mark.xdist_group("ray"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning"),
]
STORE = 100 << 20


@pytest.fixture(scope="module")
def cluster() -> Iterator[object]:
    pytest.importorskip("ray", reason="Ray has no wheel for this Python")
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    os.environ["PYTHONPATH"] = os.pathsep.join(
        [str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
    )
    from ray.cluster_utils import Cluster

    handler = signal.getsignal(signal.SIGTERM)
    # The loss of a node is detected within a second.
    quick = {"health_check_period_ms": 200, "health_check_failure_threshold": 3}
    made = Cluster(
        initialize_head=True,
        head_node_args={
            "num_cpus": 1, "include_dashboard": False, "object_store_memory": STORE,
            "_system_config": quick,
        },
    )  # fmt: skip
    made.add_node(num_cpus=1, object_store_memory=STORE)
    yield made
    made.shutdown()
    # The nodes' own handler would stay.
    signal.signal(signal.SIGTERM, handler)


@pytest.fixture(scope="module")
def pool(cluster: object) -> Iterator[RayPool]:
    with RayPool.connected(cluster.address) as connected:
        yield connected


def naps(folder: Path, count: int, seconds: float = 0.0) -> list[Nap]:
    return [Nap(f"nap-{number}", seconds, folder) for number in range(count)]


def test_every_job_is_done_once(pool: RayPool, tmp_path: Path) -> None:
    jobs = naps(tmp_path, 12, 0.05)
    done = list(pool.outcomes(iter(jobs), sleep))
    assert pool.name == "2 nodes, 2 cores"
    assert sorted(job.key for job, _ in done) == sorted(job.key for job in jobs)
    assert all(outcome["key"] == job.key for job, outcome in done)
    assert len(list(tmp_path.iterdir())) == 12


def test_a_job_that_fails_is_reported_and_the_others_are_done(
    pool: RayPool, tmp_path: Path
) -> None:
    jobs = [*naps(tmp_path, 2), Nap("broken", 0.0, tmp_path)]
    outcomes = {job.key: outcome for job, outcome in pool.outcomes(jobs, sleep)}
    assert isinstance(outcomes["broken"], ValueError)
    assert outcomes["nap-1"]["key"] == "nap-1"


def test_a_job_whose_process_is_lost_is_restarted(pool: RayPool, tmp_path: Path) -> None:
    done = list(pool.outcomes(naps(tmp_path, 1), die))
    assert sorted(outcome["key"] for _, outcome in done) == ["nap-0"]


def test_a_lost_node_loses_only_its_running_jobs(
    cluster: object, pool: RayPool, tmp_path: Path
) -> None:
    third = cluster.add_node(num_cpus=1, object_store_memory=STORE)
    jobs, done = naps(tmp_path, 12, 0.5), []
    for job, outcome in pool.outcomes(jobs, sleep):
        done.append((job.key, outcome))
        if len(done) == 3:
            cluster.remove_node(third, allow_graceful=False)
    assert sorted(key for key, _ in done) == sorted(job.key for job in jobs)
    assert all(outcome["key"] == key for key, outcome in done)
    # At most the jobs that it ran or had been given are started again.
    assert len(list(tmp_path.iterdir())) <= 12 + ray_pool.IN_FLIGHT


def test_a_node_of_another_version_is_reported(
    pool: RayPool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ray_pool, "__version__", "0.0.9")
    ((_, outcome),) = pool.outcomes(naps(tmp_path, 1), sleep)
    assert isinstance(outcome, InputError)
    assert "has circumspect" in str(outcome)
    assert "not 0.0.9" in str(outcome)
    assert not list(tmp_path.iterdir())


def test_a_node_without_the_program_is_reported(pool: RayPool, tmp_path: Path) -> None:
    ((_, outcome),) = pool.outcomes(naps(tmp_path, 1), lack_a_module)
    assert isinstance(outcome, InputError)
    assert "no circumspect" in str(outcome)


def test_a_set_is_gathered_on_a_cluster(
    pool: RayPool, tmp_path: Path, capsys: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A process can be connected once at a time.
    monkeypatch.setattr(RayPool, "connected", lambda address: nullcontext(pool))
    # Nodes have another working directory.
    monkeypatch.chdir(tmp_path)
    out = Path("set")
    flags = ["--classes", "chair", "--train-objects", "2", "--test-objects", "0"]
    flags += ["--frames", "3", "--out", str(out), "--cluster", "auto"]
    assert main(["gather", *flags]) == 0
    scans = read_manifest(out)
    assert sorted(scan.object for scan in scans) == ["chair-200000", "chair-200001"]
    assert verify_gathered(out).complete
    assert main(["gather", *flags]) == 0
    assert read_manifest(out) == scans


def test_a_set_is_converted_and_evaluated_on_a_cluster(
    pool: RayPool, tmp_path: Path, capsys: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(RayPool, "connected", lambda address: nullcontext(pool))
    monkeypatch.chdir(tmp_path)
    rng, classes = np.random.default_rng(0), load_predictor("modelnet10").classes
    for split in ("train", "test"):
        points = rng.random((20, 300, 3)).astype(np.float32)
        names = np.array([f"{split}_{number}" for number in range(20)])
        objects = ObjectSet(points, np.arange(20) % 10, names, classes)
        write_point_pack(tmp_path / "packs" / f"{split}.npz", objects)
    there = ["--cluster", "auto", "--json"]
    flags = ["--out", "shards", "--net", "modelnet10", "--replicas", "1", "--shard-size", "6"]
    assert main(["data", "convert", "packs", *flags, *there]) == 0
    assert json.loads(capsys.readouterr().out)["test"] == 20
    assert main(["evaluate", "--data", "shards", "--split", "test", "--out", "out", *there]) == 0
    sharded = json.loads(capsys.readouterr().out)
    words = ["evaluate", "--data", "packs", "--split", "test", "--out", "whole", "--yaw", "0"]
    assert main([*words, "--json"]) == 0
    whole = json.loads(capsys.readouterr().out)
    assert sharded["confusion"] == whole["confusion"]


def test_a_node_that_does_not_see_the_folder_is_reported(pool: RayPool, tmp_path: Path) -> None:
    settings = GatherSettings(("chair",), 1, 0)
    scan = GatheredScan("chair-1@000", "chair-1", "chair", "train", 0.0)
    task = SimulatedTask(scan, make_furniture("chair", 1), 0, settings, str(tmp_path / "elsewhere"))
    ((_, outcome),) = pool.outcomes([task], scanned)
    assert isinstance(outcome, InputError)
    assert "give a folder that all nodes share" in str(outcome)


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--cluster", "127.0.0.1:9"], "no Ray cluster at 127.0.0.1:9"),
        (["--cluster", "nonsense"], "no Ray cluster at nonsense"),
        (["--cluster", "auto", "--workers", "2"], "--workers is for this machine"),
    ],
)
def test_a_missing_cluster_is_reported_in_one_line(
    flags: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    pytest.importorskip("ray", reason="Ray has no wheel for this Python")
    flags = [*flags, "--classes", "chair", "--train-objects", "1", "--test-objects", "0"]
    assert main(["gather", "--out", str(tmp_path / "set"), *flags]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert len(error.splitlines()) == 1
    assert not (tmp_path / "set").exists()


def test_ray_that_is_not_installed_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with (
        pytest.raises(MissingExtraError, match=r"circumspect\[cluster\]"),
        RayPool.connected("auto"),
    ):
        pass


def test_the_jobs_of_these_tests_are_seen_by_nodes() -> None:
    assert Path(cluster_jobs.__file__).parent == Path(__file__).parent
