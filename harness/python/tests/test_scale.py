"""Many machines: Ray with several worker processes, a real Slurm, Kubernetes' own schema. What isn't installed is skipped."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from vertibench import harness_path
from vertibench._program import environment
from vertibench.scale import ScaleError, ShardEnd, Work, run_shard
from vertibench.scale import _shard, cost
from vertibench.scale import kubernetes as on_kubernetes
from vertibench.scale import ray as on_ray
from vertibench.scale import slurm as on_slurm

RUN = ["--plugin", "pid.wasm", "--param", "speed=6", "--suite", "smoke"]


def files(run: Path) -> dict[str, bytes]:
    """The files of a run, without the time of its start, which run.json has, and the checksum of it."""
    found = {str(p.relative_to(run)): p.read_bytes() for p in run.rglob("*") if p.is_file()}
    for name, no in (("run.json", b'"started_at"'), ("checksums.txt", b"  run.json")):
        found[name] = b"\n".join(line for line in found[name].splitlines() if no not in line)
    return found


@pytest.fixture(scope="module")
def one(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The files of the run that one machine makes."""
    out = tmp_path_factory.mktemp("one") / "run"
    subprocess.run([str(harness_path()), "run", *RUN, "--out", str(out)], env=environment(), check=True, capture_output=True)
    return files(out)


def same(run: Path, expected: dict[str, bytes]) -> None:
    found = files(run)
    assert found.keys() == expected.keys()
    assert [name for name in found if found[name] != expected[name]] == []


def test_a_command_line_becomes_those_of_its_shards(tmp_path: Path) -> None:
    work = Work.of(["run", *RUN], tmp_path, 8)
    assert work.shard(3, 2) == ["run", *RUN, "--out", str(tmp_path / "shards"), "--resume", "--shard", "3/8", "--jobs", "2"]
    assert work.shard(None)[-2:] == ["--shard", "auto"]
    assert work.joined() == ["merge", str(tmp_path / "shards"), "--out", str(tmp_path / "run")]
    sweep = Work.of(["sweep", "sweep.yaml"], tmp_path, 8)
    file = str(Path("sweep.yaml").absolute())
    assert sweep.shard(3) == ["sweep", "run", file, "--out", str(tmp_path), "--resume", "--shard", "3/8"]
    assert sweep.joined() == ["sweep", "report", file, "--out", str(tmp_path)]
    assert Work.from_json(json.loads(json.dumps(work.to_json()))) == work
    assert Work.of(["pid.wasm", "--seed", "1"], tmp_path, 2).shard(1)[:4] == ["run", "pid.wasm", "--seed", "1"]


@pytest.mark.parametrize(
    ("arguments", "shards", "told"),
    [
        (["--plugin", "pid.wasm", "--shard", "1/2"], 2, "--shard: the option is set per shard automatically"),
        (["--plugin", "pid.wasm", "--out=x"], 2, "--out=x: the option is set"),
        (["--plugin", "pid.wasm"], 0, "--shards: 0 is not a number of shards"),
        (["--suite", "smoke"], 2, "the command line: no planner"),
        (["sweep"], 2, "sweep: one file and no options"),
        (["sweep", "a.yaml", "--jobs"], 2, "--jobs: the option is set"),
    ],
)
def test_what_makes_no_sense_is_told_before_anything_begins(arguments: list[str], shards: int, told: str, tmp_path: Path) -> None:
    with pytest.raises(ScaleError) as e:
        Work.of(arguments, tmp_path, shards)
    assert told in str(e.value)


def test_an_exit_code_says_whether_another_try_helps(tmp_path: Path) -> None:
    def kind(code: int) -> tuple[bool, bool]:
        end = ShardEnd(1, code, "")
        return end.is_done, end.is_worth_another_try

    assert [kind(c) for c in (0, 5)] == [(True, False)] * 2
    assert [kind(c) for c in (1, 2, 3, 10)] == [(False, False)] * 4
    assert [kind(c) for c in (4, 7, 130, 137, 143, -9)] == [(False, True)] * 6
    # And what the program really gives.
    end = run_shard(Work.of(["--plugin", "pid.wasm", "--param", "spede=6", "--suite", "smoke"], tmp_path, 2), 1)
    assert (end.code, end.is_worth_another_try) == (2, False) and "spede" in end.said


def test_a_shard_that_works_on_a_disk_of_its_own_goes_on_and_brings_its_results(one: dict[str, bytes], tmp_path: Path) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    work = Work.of(RUN, tmp_path / "out", 2)
    assert [run_shard(work, k, 1, scratch).code for k in (1, 2)] == [0, 0]
    # As if it had been stopped after its first task.
    tasks = work.folders(2)[0] / "tasks.jsonl"
    tasks.write_bytes(tasks.read_bytes().splitlines(keepends=True)[0])
    assert run_shard(work, 2, 1, scratch).code == 0
    assert list(scratch.iterdir()) == []
    assert _shard.join(work) == 0
    same(work.result(), one)


def test_a_cost_is_that_of_the_slowest_step() -> None:
    # A run of 1000 tasks in 100 worlds, 0.5 s each: 10 shards of 10 worlds, each with 0.2 s to begin.
    few = cost.cost(1, 1000, 100, 0.5, 10, 10)
    assert (few.core_seconds, few.driving, few.limit) == (502.0, pytest.approx(50.2), "the cores")
    # 200 shards: 100 of one world and others empty, on 10 cores in 20 rounds.
    assert cost.cost(1, 1000, 100, 0.5, 10, 200).driving == pytest.approx(20 * (0.2 + 5))
    # 27 worlds a shard, each of another run.
    many = cost.cost(2700, 1000, 100, 0.15, 10_000, 10_000)
    assert many.driving == pytest.approx(27 * (0.2 + 10 * 0.15))
    assert (many.limit, many.writing) == ("the file system", pytest.approx((270_000 * 50 + 2.7e6 * 14) / 5000))
    copied = cost.cost(2700, 1000, 100, 0.15, 10_000, 10_000, traces=False, scratch=True)
    assert copied.writing == pytest.approx(270_000 * 30 / 5000)
    with pytest.raises(ValueError, match="above 0"):
        cost.cost(1, 1000, 100, float("nan"), 10, 10)


@pytest.mark.parametrize("wrong", ["--runs=0", "--seconds=nan", "--seconds=-1", "--cores=0", "--shards=0", "--operations=inf"])
def test_costs_of_nothing_are_refused(wrong: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cost.main(["--runs", "1", "--seconds", "1", "--cores", "1", wrong])
    assert ended.value.code == 2 and f"argument {wrong.split('=')[0]}: " in capsys.readouterr().err


@pytest.fixture(scope="module")
def ray_cluster() -> Iterator[str]:
    """A cluster of two nodes, each with processes of its own."""
    pytest.importorskip("ray", reason="ray is not installed")
    from ray.cluster_utils import Cluster

    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    # Workers find the package as this process does.
    path = os.pathsep.join([str(Path(on_ray.__file__).parent.parent.parent), os.environ.get("PYTHONPATH", "")])
    os.environ["PYTHONPATH"] = path
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    cluster.add_node(num_cpus=1)
    yield cluster.address
    cluster.shutdown()


def workers_of(shards: Path) -> list[int]:
    """The workers of Ray that drive a shard below a folder now."""
    found = []
    for process in Path("/proc").iterdir():
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
            if str(shards).encode() in words and b"--shard" in words:
                status = (process / "status").read_text()
                found.append(int(next(line.split()[1] for line in status.splitlines() if line.startswith("PPid"))))
        except (OSError, StopIteration):
            continue
    return found


def test_ray_makes_the_run_of_one_machine_though_a_worker_is_killed(ray_cluster: str, one: dict[str, bytes], tmp_path: Path) -> None:
    killed: list[int] = []

    def kill() -> None:
        # The first worker that has done a task of its shard.
        while not killed:
            time.sleep(0.02)
            if any(f.stat().st_size for f in tmp_path.glob("shards/*/tasks.jsonl")):
                killed.extend(workers_of(tmp_path / "shards")[:1])
        os.kill(killed[0], signal.SIGKILL)

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    # Of three shards one is begun again by another worker.
    code = on_ray.run(Work.of(RUN, tmp_path, 3), address=ray_cluster)
    killer.join(1)
    assert code == 0 and len(killed) == 1
    same(tmp_path / "run", one)


def test_a_shard_that_fails_for_good_ends_all_on_ray(ray_cluster: str, tmp_path: Path) -> None:
    work = Work.of(["--plugin", "pid.wasm", "--suite", "nowhere"], tmp_path, 3)
    with pytest.raises(ScaleError, match=r"shard \d: it ended with code 3: .*nowhere"):
        on_ray.run(work, address=ray_cluster)


@pytest.fixture(scope="module")
def slurm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Slurm on this machine: munged, slurmctld, slurmd."""
    pytest.importorskip("submitit", reason="submitit is not installed")
    if any(shutil.which(p) is None for p in ("munged", "slurmctld", "slurmd", "sbatch")) or os.geteuid() != 0:
        pytest.skip("Slurm is not installed (Debian: slurmctld, slurmd, slurm-client, munge), or only root may start it")
    # Sockets have short names.
    root = Path("/tmp") / f"vb-slurm-{os.getpid()}"
    for folder in ("munge", "state", "spool"):
        (root / folder).mkdir(parents=True)
    root.chmod(0o755)
    key = root / "munge/key"
    key.write_bytes(os.urandom(1024))
    key.chmod(0o600)
    host = socket.gethostname().split(".")[0]
    ports = iter(range(21000 + os.getpid() % 20000, 65000))
    conf = root / "slurm.conf"
    conf.write_text(
        f"""ClusterName=test
SlurmctldHost={host}(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket={root}/munge/socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SlurmctldPort={next(ports)}
SlurmdPort={next(ports)}
StateSaveLocation={root}/state
SlurmdSpoolDir={root}/spool
SlurmctldPidFile={root}/slurmctld.pid
SlurmdPidFile={root}/slurmd.pid
SlurmctldLogFile={root}/slurmctld.log
SlurmdLogFile={root}/slurmd.log
SlurmUser=root
SlurmdUser=root
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
# A job that was requeued begins again at once.
SchedulerParameters=batch_sched_delay=1,sched_interval=2,requeue_delay=1
NodeName={host} NodeAddr=127.0.0.1 CPUs={os.cpu_count()} State=UNKNOWN
PartitionName=debug Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""
    )
    munge = root / "munge"
    daemons = [
        ["munged", "--foreground", "--force", f"--key-file={key}", f"--socket={munge}/socket", f"--pid-file={munge}/pid",
         f"--log-file={munge}/log", f"--seed-file={munge}/seed"],
        ["slurmctld", "-D", "-f", str(conf)],
        ["slurmd", "-D", "-f", str(conf), "-N", host],
    ]  # fmt: skip
    running = []
    for daemon in daemons:
        running.append(subprocess.Popen(daemon, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        time.sleep(1.0)
    os.environ["SLURM_CONF"] = str(conf)
    try:
        for _ in range(60):
            if "idle" in subprocess.run(["sinfo"], capture_output=True, text=True, check=False).stdout:
                break
            time.sleep(0.5)
        else:
            pytest.fail(f"Slurm doesn't come up: see {root}/*.log")
        yield root
    finally:
        del os.environ["SLURM_CONF"]
        for daemon in reversed(running):
            daemon.terminate()
            daemon.wait(10)
        shutil.rmtree(root, ignore_errors=True)


def test_slurm_makes_the_run_of_one_machine_though_a_job_is_requeued(slurm: Path, one: dict[str, bytes], tmp_path: Path) -> None:
    work = Work.of(RUN, tmp_path, 2)
    first = on_slurm.submit(work, 1, 5, {"partition": "debug"}, 1)[0]
    with pytest.raises(ScaleError, match="an array has been submitted for it"):
        on_slurm.submit(work, 1, 5, {}, 1)
    # Slurm's own warning that the job's time is nearly over; submitit puts it back into the queue.
    for _ in range(600):
        if any(f.stat().st_size for f in tmp_path.glob("shards/*/tasks.jsonl")):
            break
        time.sleep(0.05)
    subprocess.run(["scancel", "--signal=USR2", first], check=False)
    assert on_slurm.collect(tmp_path) == 0
    logs = "".join(f.read_text() for f in tmp_path.glob("slurm/*log*"))
    assert "requeue" in logs.lower(), logs
    same(tmp_path / "run", one)


def test_a_shard_that_fails_for_good_is_told_of_by_slurm(slurm: Path, tmp_path: Path) -> None:
    on_slurm.submit(Work.of(["--plugin", "pid.wasm", "--suite", "nowhere"], tmp_path, 1), 1, 5, {}, 1)
    with pytest.raises(ScaleError, match=r"shard 1: it ended with code 3: .*nowhere"):
        on_slurm.collect(tmp_path)
    with pytest.raises(ScaleError, match="no array has been submitted"):
        on_slurm.collect(tmp_path / "elsewhere")


def test_the_jobs_for_kubernetes_are_valid_and_map_exit_codes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--shards", "64", "--out", "/results/mine", "--cpus", "4", "--image", "lab/vertibench:1", "--claim", "results"]
    assert on_kubernetes.main([*options, "--", *RUN]) == 0
    jobs = json.loads(capsys.readouterr().out)["items"]
    drive, joined = jobs
    spec = drive["spec"]
    assert (spec["completions"], spec["completionMode"], spec["backoffLimitPerIndex"]) == (64, "Indexed", 3)
    container = spec["template"]["spec"]["containers"][0]
    assert container["env"] == [{"name": "VB_SHARDS", "value": "64"}]
    assert container["command"] == ["vertibench", "run", *RUN, "--out", "/results/mine/shards", "--resume", "--shard", "auto", "--jobs", "4"]
    rules = {r["action"]: r.get("onExitCodes", {}).get("values") for r in spec["podFailurePolicy"]["rules"]}
    assert rules == {"FailJob": [1, 2, 3, 10], "Ignore": None, "Count": [4, 7, 130]}
    assert joined["spec"]["template"]["spec"]["containers"][0]["command"][:2] == ["vertibench", "merge"]
    assert on_kubernetes.main([*options[:3], str(tmp_path), *options[4:], "--", *RUN]) == 2
    assert "is not on the volume" in capsys.readouterr().err
    validate = pytest.importorskip("kubernetes_validate", reason="kubernetes-validate is not installed").validate
    for job in jobs:
        for version in ("1.31", "1.33"):
            validate(job, version, strict=True)
    del drive["spec"]["template"]["spec"]["containers"][0]["image"]
    drive["spec"]["completion"] = 3
    with pytest.raises(Exception, match="completion"):
        validate(drive, "1.33", strict=True)


@pytest.mark.skipif(sys.platform != "linux", reason="processes end with their parents on Linux alone")
def test_a_shard_ends_with_who_began_it(tmp_path: Path) -> None:
    code = f"from vertibench.scale import Work, run_shard\nrun_shard(Work.of({RUN!r}, __import__('pathlib').Path({str(tmp_path)!r}), 1), 1)"
    parent = subprocess.Popen([sys.executable, "-c", code], env={**environment(), "PYTHONPATH": os.pathsep.join(sys.path)})
    for _ in range(600):
        if workers_of(tmp_path / "shards"):
            break
        time.sleep(0.02)
    parent.kill()
    parent.wait()
    for _ in range(100):
        if not workers_of(tmp_path / "shards"):
            return
        time.sleep(0.05)
    pytest.fail("the shard goes on")
