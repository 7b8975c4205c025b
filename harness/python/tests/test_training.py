"""Training: configurations, weights, planners made of them, and learning that can be cut off."""

import hashlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import vertibench
from vertibench.training import TrainingError, Weights, package, read_config, read_weights
from vertibench.training._package import CAPACITY, METADATA, _bytes, _number, metadata, rewrite
from vertibench.training._weights import convolution, dense

PARTS = ["goal", "path", "height", "class"]
NOTES = {
    "parts": " ".join(PARTS),
    "sight": "16 1 4 10 2",
    "labels": "7 10",
    "action": "speed 0 6",
    "control_hz": "10",
}


def weights(notes=NOTES) -> Weights:
    """A policy that steers to the third point of the path, with a little of everything else."""
    draw = np.random.default_rng(3)
    # Three planes of 16 x 16; a kernel of 8 at a stride of 8 leaves 2 x 2.
    eyes = convolution("eyes.0", 16, draw.normal(0, 0.02, (2, 3, 8, 8)), draw.normal(0, 0.1, 2), 8)
    hidden = draw.normal(0, 0.05, (6, 8 + 2 + 20))
    hidden[0, 8 + 2 + 5] = 10.0  # Metres to the left of the third point, which are divided by 10.
    out = np.array([[0.2, 0.01, -0.01, 0.02, 0.0, 0.01], [0.0, 0.0, 0.02, 0.0, -0.01, 0.0]])
    return Weights(dict(notes), [eyes, dense("head.0", hidden, draw.normal(0, 0.1, 6)), dense("head.1", out, np.zeros(2))])


def by_numpy(own: Weights, observation) -> np.ndarray:
    """Actions by the definition of the network, in double precision."""

    def leaky(v):
        return np.where(v < 0, 0.1 * v, v)

    eyes, *layers = own.layers
    height = np.clip(observation["height"] / 2.0, -5, 5)
    planes = np.stack([height, observation["class"] == 7, observation["class"] == 10], 1).astype(np.float64)
    count = len(planes)
    seen = np.zeros((count, 2, 2, 2))
    for row in range(2):
        for col in range(2):
            patch = planes[:, :, 8 * row : 8 * row + 8, 8 * col : 8 * col + 8]
            seen[:, :, row, col] = np.einsum("npij,opij->no", patch, eyes.weights) + eyes.bias
    goal, path = observation["goal"] / 50.0, observation["path"].reshape(count, -1) / 10.0
    values = np.concatenate([leaky(seen).reshape(count, -1), np.clip(goal, -5, 5), np.clip(path, -5, 5)], 1)
    for k, layer in enumerate(layers):
        values = values @ layer.weights.T + layer.bias
        values = leaky(values) if k + 1 < len(layers) else values
    return values


@pytest.fixture
def made(envs, program, tmp_path):
    """Makes a planner of weights."""

    def make(own=None, name="mine", about="Mine"):
        (tmp_path / "mine.vbnn").write_bytes(bytes(own or weights()))
        package(tmp_path / "mine.vbnn", tmp_path / "mine.wasm", name, about)
        return tmp_path / "mine.wasm"

    return make


def test_the_planners_networks_are_those_that_are_written_down(envs):
    own = envs.NavigationVectorEnv(5, suite="smoke", tasks="w001-w005", observation=PARTS, sight={"ahead": 4.0})
    observation, _ = own.reset(seed=1)
    for _ in range(5):
        parts = [observation[name] for name in PARTS]
        actions = vertibench._native.policy_actions(own._setup.arena, bytes(weights()), parts)
        np.testing.assert_allclose(actions, by_numpy(weights(), observation), atol=1e-5)
        observation = own.step(np.clip(actions + 0.3, -1, 1))[0]


@pytest.mark.parametrize("task", ["w001/t01", "w005/t02"])
def test_a_packaged_planner_drives_as_the_policy_does_in_the_environment(envs, made, tmp_path, task):
    own = envs.NavigationVectorEnv(1, autoreset_mode="DISABLED", suite="smoke", observation=PARTS, sight={"ahead": 4.0})
    observation, _ = own.reset(seed=0, options={"task": task, "run_seed": 0})
    over = False
    while not over:
        parts = [observation[name] for name in PARTS]
        action = vertibench._native.policy_actions(own._setup.arena, bytes(weights()), parts)
        observation, _, terminated, truncated, infos = own.step(action)
        over = terminated[0] or truncated[0]
    driven = vertibench.run(made(), suite="smoke", tasks=[task], out=tmp_path / "run", progress=False)
    records = [json.loads(line) for line in (driven.path / "tasks.jsonl").read_text().splitlines()]
    assert records[0]["state_hash"] == infos["record"][0]["state_hash"]


def test_a_packaged_planner_tells_its_name_and_weights(made):
    file = made(name="hill-fox", about="Over the hills")
    done = subprocess.run([vertibench.harness_path(), "inspect", "--plugin", file], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert re.search(r"planner +hill-fox ", done.stdout) and re.search(r"about +Over the hills", done.stdout)
    assert re.search(r"model +mine.vbnn sha256 [0-9a-f]{64}", done.stdout)


def test_what_can_not_be_packaged_is_refused(made, tmp_path):
    with pytest.raises(TrainingError, match="--name My Planner: the name of a planner must consist of a-z"):
        made(name="My Planner")
    large = Weights(NOTES, [dense("head.0", np.zeros((600, 600)), np.zeros(600))])
    with pytest.raises(TrainingError, match=f"bytes exceed the {CAPACITY} bytes"):
        made(large)
    (tmp_path / "text").write_text("no weights")
    with pytest.raises(TrainingError, match="text: not a weight file"):
        read_weights(tmp_path / "text")
    with pytest.raises(TrainingError, match="nowhere: it can't be read: No such file"):
        read_weights(tmp_path / "nowhere")


def test_a_planner_without_weights_says_where_they_come_from(program, tmp_path):
    driven = vertibench.run("learned.wasm", suite="smoke", tasks=["w001/t00"], out=tmp_path / "run", progress=False)
    assert "this planner contains no weights" in (driven.path / "tasks.jsonl").read_text()


def section(kind: int, body: bytes) -> bytes:
    return bytes([kind]) + _bytes(len(body)) + body


def test_the_metadata_is_changed_wherever_it_lies():
    text = "abi: 1.0\nname: learned\nabout: old\n" + "help: long\n" * 20
    module = b"\0asm\x01\0\0\0" + section(0, b"\x0a" + METADATA + text.encode()) + section(11, b"data" * 50)
    component = b"\0asm\x0d\0\x01\0" + section(7, b"types") + section(4, b"\0asm\x0d\0\x01\0" + section(1, module)) + section(0, b"\x03xyz")
    short = metadata(text, {"name": "mine", "about": "two\nlines \\"}, ["pose", "lidar"])
    changed = rewrite(component, lambda _: short)
    assert component.replace(_bytes(len(module)) + module, b"").count(b"xyz") == 1
    assert b"name: mine\n" in changed and b"about: two\\nlines \\\\\n" in changed and b"name: learned" not in changed
    assert changed.endswith(section(0, b"\x03xyz")) and section(11, b"data" * 50) in changed
    assert short.endswith("need: pose\nneed: lidar\n")
    # All sizes are right: nothing changes any more, and the old text comes back.
    assert rewrite(changed, lambda _: text) == component


def test_numbers_as_wasm_writes_them():
    for value, written in ((0, "00"), (127, "7f"), (128, "8001"), (624485, "e58e26")):
        assert _bytes(value).hex() == written and _number(bytes.fromhex(f"ff{written}"), 1) == (value, 1 + len(written) // 2)


def test_configurations_are_read_and_changed():
    own = read_config("policy", {"ppo.batch": "256", "speed_range": "[-1, 4.5]"})
    assert own["ppo.batch"] == 256 and own["speed_range"] == [-1, 4.5] and own["planners"]["acl"] == "learnability"
    assert own.hash == read_config("policy", {"ppo.batch": "256", "speed_range": "[-1, 4.5]"}).hash != read_config("policy").hash


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"ppo.batch": "1"}, "ppo.batch: 1 must lie in 2 to"),
        ({"ppo.batch": "many"}, "ppo.batch: 'many' must lie in"),
        ({"ppo.size": "1"}, "--set ppo.size: there is no such field"),
        ({"algorithm": "dqn"}, "algorithm: 'dqn' must be sac or ppo"),
        ({"sac.mirror": "1"}, "sac.mirror: 1 must be true or false"),
        ({"worlds.seed": "2025"}, "worlds.seed: 2025 must lie in 7000 to 7999"),
        ({"held_out.seed": "7500"}, "held_out.seed: it must differ from worlds.seed"),
        ({"speed_range": "[1]"}, "must be two speeds"),
        ({"action": "pedals"}, "action: 'pedals' must be speed or rate"),
        ({"network.widths": "64"}, "network.widths: 64 must be a list"),
        ({"network.widths": "[-5, 64]"}, "network.widths: [-5, 64] must have entries from 1 to"),
        ({"network.widths": "[64, true]"}, "network.widths: [64, True] must be a list of ints"),
        ({"labels": "[7, 256]"}, "labels: [7, 256] must have entries from 0 to 255"),
        ({"speed_range": "[6, 0]"}, "speed_range: [6, 0] must be two speeds, the lower one first"),
        ({"speed_range": "[0, 100]"}, "speed_range: [0, 100] must have entries from -10 to 30"),
        ({"ppo.batch": "256.5"}, "ppo.batch: 256.5 must be a whole number"),
        ({"network.kernel": "2.5"}, "network.kernel: 2.5 must be a whole number"),
        ({"worlds.count": "2.5"}, "worlds.count: 2.5 must be a whole number"),
        ({"environments": "64.0"}, "environments: 64.0 must be a whole number"),
        ({"time_step": "0.003"}, "time_step: 0.003 must divide 0.01 s"),
        ({"planners": "{rl: 5}"}, "planners: {'rl': 5} must map names of planners to curricula"),
        ({"checkpoint": "1000"}, "checkpoint: 1000 is not a multiple of environments, 64"),
        ({"checkpoint": "64000", "algorithm": "ppo"}, "checkpoint: 64000 is not a multiple of environments times ppo.steps, 8192"),
    ],
)
def test_flaws_of_configurations_are_told(changes, told):
    with pytest.raises(TrainingError, match=re.escape(told)):
        read_config("policy", changes)


def test_the_parts_of_an_observation_are_those_of_environments(envs):
    with pytest.raises(TrainingError, match=re.escape("observation: ['state', 'nope'] must consist of state, pose, ")):
        read_config("policy", {"observation": "[state, nope]"})


@pytest.mark.parametrize("option", ["--until", "--threads"])
def test_a_number_of_nothing_is_refused(option, tmp_path, capsys):
    from vertibench.training.__main__ import main

    for number in ("0", "-5", "1.5"):
        with pytest.raises(SystemExit) as ended:
            main(["train", "rl", "--out", str(tmp_path / "run"), f"{option}={number}"])
        assert ended.value.code == 2 and f"'{number}' must be a whole number, at least 1" in capsys.readouterr().err


@pytest.mark.parametrize("command", [["train", "rl", "--out", "x"], ["evaluate", "x"], ["export", "x", "y"], ["card", "x", "y"]])
def test_without_torch_the_extra_is_told(envs, command, tmp_path):
    code = "import sys; sys.modules['torch'] = None; from vertibench.training.__main__ import main; sys.exit(main(sys.argv[1:]))"
    done = subprocess.run([sys.executable, "-c", code, *command], cwd=tmp_path, capture_output=True, text=True, check=False, env=_path())
    assert done.returncode == 2 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.endswith("(pip install 'verti-bench[train]')\n")


def _path():
    own = str(Path(vertibench.__file__).parents[1])
    return {**os.environ, "PYTHONPATH": os.pathsep.join([own, os.environ.get("PYTHONPATH", "")])}


def test_a_configuration_changes_fields_of_its_base(tmp_path):
    own, base = read_config("onboard"), read_config("policy")
    changed = {field for field in base.values if own[field] != base[field]}
    assert changed == {"name", "planners", "perception", "observation", "ahead"}
    (tmp_path / "a.yaml").write_text("base: b\nname: a\n")
    (tmp_path / "b.yaml").write_text("base: a\nname: b\n")
    with pytest.raises(TrainingError, match="b.yaml: base: 'a' is not a file beside this one without a base"):
        read_config(tmp_path / "a.yaml")


def test_files_of_configurations_are_checked(tmp_path):
    (tmp_path / "mine.yaml").write_text("schema: 1\nname: mine\nppo: {size: 3}\n")
    with pytest.raises(TrainingError, match=r"mine.yaml: ppo.size: there is no such field"):
        read_config(tmp_path / "mine.yaml")
    (tmp_path / "mine.yaml").write_text("schema: 1\nname: mine\n")
    with pytest.raises(TrainingError, match=r"mine.yaml: planners: the field is missing"):
        read_config(tmp_path / "mine.yaml")
    with pytest.raises(TrainingError, match=r"it can't be read: No such file or directory \(give a YAML file, or one of onboard, policy\)"):
        read_config("polici")


# What follows learns, and needs torch.


SMALL = {
    "worlds.count": "6",
    "held_out.count": "3",
    "held_out.tasks": '"w001-w003/t00"',
    "environments": "8",
    "checkpoint": "2048",
    "ppo.steps": "64",
    "ppo.batch": "128",
    # The first steps are forgotten in the second stretch.
    "sac.buffer": "3000",
    "sac.begin": "512",
    "sac.batch": "64",
    "clone.batch": "64",
}
PLANNERS = {"ppo": "replay", "sac": "learnability"}


@pytest.fixture(scope="module", params=sorted(PLANNERS))
def learned(request, tmp_path_factory):
    """A tiny run in two stretches, one that was cut off after the first, and what makes others like it."""
    pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed (it brings torch, which takes gigabytes)")
    from vertibench.training._run import train

    algorithm = request.param
    whole = {**SMALL, "algorithm": algorithm, "planners": "{uniform: uniform, replay: replay, learnability: learnability}"}
    folder = tmp_path_factory.mktemp("training")

    def run(name, until, threads=2, planner=PLANNERS[algorithm], seed=1, changes=whole, demonstrations=None):
        out = io.StringIO()
        train(planner, folder / name, seed, "policy", changes, until, threads, demonstrations, out)
        return out.getvalue()

    run("whole", 4096)
    run("cut", 2048)
    return folder, run


def algorithm_of(run):
    return run.__defaults__[3]["algorithm"]


def test_training_that_was_cut_off_goes_on_as_if_it_had_not_been(learned):
    folder, run = learned
    (folder / "cut/progress.jsonl").open("a").write('{"steps": 3000, "half a li')
    told = run("cut", 4096, threads=1)
    assert "continuing from checkpoint-000000002048" in told
    for file in ("model.pt", "state.json"):
        one, other = ((folder / name / "checkpoint-000000004096" / file).read_bytes() for name in ("whole", "cut"))
        assert one == other, file

    def lines(name):
        read = [json.loads(line) for line in (folder / name / "progress.jsonl").read_text().splitlines()]
        return [{k: v for k, v in line.items() if k != "seconds"} for line in read]

    assert lines("whole") == lines("cut") and [line["steps"] for line in lines("cut") if "held_out" in line] == [2048, 4096]


def test_another_run_is_not_gone_on_with(learned):
    folder, run = learned
    with pytest.raises(TrainingError, match="the folder contains a run with seed 1"):
        run("whole", 8192, seed=2)
    with pytest.raises(TrainingError, match=f"the folder contains a run with planner {PLANNERS[algorithm_of(run)]}"):
        run("whole", 8192, planner="uniform")
    with pytest.raises(TrainingError, match="rl: there is no such planner in the configuration"):
        run("new", 8192, planner="rl")


def test_weights_that_are_exported_drive_as_the_policy_does(learned, program, tmp_path):
    from vertibench.training._export import export
    from vertibench.training._run import evaluate

    folder, run = learned
    told = export(folder / "whole", tmp_path / "own.vbnn")
    assert float(re.search(r"by (\S+) at most", told)[1]) < 1e-5
    notes, _ = read_weights(tmp_path / "own.vbnn")
    assert notes["policy"] == PLANNERS[algorithm_of(run)] and notes["steps"] == "4096" and notes["seed"] == "1"
    assert notes["relief"] == "8" and notes.get("squash") == {"ppo": None, "sac": "tanh"}[algorithm_of(run)]
    package(tmp_path / "own.vbnn", tmp_path / "own.wasm", "own", "Own")
    tasks = ["w001/t00", "w002/t00", "w004/t00"]
    driven = vertibench.run(tmp_path / "own.wasm", suite="smoke", tasks=tasks, out=tmp_path / "run", progress=False)
    outcomes = [json.loads(line)["outcome"] for line in (driven.path / "tasks.jsonl").read_text().splitlines()]
    shares = evaluate(folder / "whole", "smoke", ",".join(tasks))
    assert shares == {"tasks": 3, **{name: round(100 * outcomes.count(name) / 3, 2) for name in sorted(set(outcomes))}}


def test_only_the_last_checkpoint_keeps_what_was_driven(learned):
    folder, run = learned
    kept = {path.parent.name: [file.name for file in path.iterdir()] for path in sorted((folder / "whole").glob("*/memory"))}
    assert kept == {"checkpoint-000000004096": {"ppo": [], "sac": ["buffer.npz"]}[algorithm_of(run)]}


def test_an_algorithm_that_knows_no_surprise_follows_no_replay(learned):
    _, run = learned
    if algorithm_of(run) == "sac":
        with pytest.raises(TrainingError, match="replay: the curriculum replay needs scores of episodes, which sac"):
            run("other", 2048, planner="replay")


def test_returns_do_not_reach_over_a_cut_and_steps_are_seen_in_a_mirror():
    pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed (it brings torch, which takes gigabytes)")
    from gymnasium import spaces

    from vertibench.training._sac import Memory

    box = spaces.Box(-9, 9, (2,), np.float32)
    mirrored = (np.array([1, 0]), np.float32([1, -1]))
    memory = Memory(8, box, box, "cpu", n_steps=3, gamma=0.5, mirrored=mirrored)
    for k in range(4):
        # Steps 0 and 1 before the cut, 2 and 3 after it.
        place = np.float32([[k, 10 + k]])
        memory.add(place, place + 1, np.float32([[0.5, 0.25]]), np.float32([k + 1]), np.array([False]), [{}])
        if k == 1:
            memory.cut()
    drawn = memory._get_samples(np.array([0, 0]))
    # 1 + 2/2; what is left counts by 1/4, after the second step, at which nothing has ended.
    assert drawn.rewards.tolist() == [[2.0], [2.0]] and drawn.discounts.tolist() == [[0.25], [0.25]]
    assert drawn.dones.tolist() == [[0.0], [0.0]]
    assert drawn.observations.tolist() == [[10.0, 0.0], [0.0, 10.0]] and drawn.next_observations.tolist() == [[12.0, -2.0], [2.0, 12.0]]
    assert drawn.actions.tolist() == [[-0.5, 0.25], [0.5, 0.25]]


def test_left_and_right_change_places_in_a_mirror(envs):
    pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed (it brings torch, which takes gigabytes)")
    from vertibench.training._network import mirror, rows

    parts = ["state", "goal", "path", "command", "height", "class"]
    own = envs.NavigationVectorEnv(2, suite="smoke", observation=parts)
    observation, _ = own.reset(seed=3)
    for _ in range(5):
        observation = own.step(np.array([[0.8, 0.5], [-0.4, 1.0]]))[0]
    seen = rows(own._setup.parts, observation)
    indices, signs = mirror(own._setup.parts)
    turned = seen[:, indices] * signs
    assert (turned[:, indices] * signs == seen).all()
    roll, pitch, vx, vy, vz, wx, wy, wz, steering, engine, gear = observation["state"].T
    assert (turned[:, :11].T == [-roll, pitch, vx, -vy, vz, -wx, wy, -wz, -steering, engine, gear]).all()
    assert (turned[:, 11:13] == observation["goal"] * [1, -1]).all()
    assert (turned[:, 13:33].reshape(2, 10, 2) == observation["path"] * [1, -1]).all()
    assert (turned[:, 33:36] == observation["command"] * [-1, 1, 1]).all()
    # Column 0 is the rightmost.
    assert (turned[:, 36:292].reshape(2, 16, 16) == observation["height"][:, :, ::-1]).all()
    assert (turned[:, 292:].reshape(2, 16, 16) == observation["class"][:, :, ::-1]).all()
    with pytest.raises(TrainingError, match="wheels has no mirror augmentation"):
        mirror(envs.NavigationVectorEnv(1, suite="smoke", observation=["wheels"])._setup.parts)


def test_curves_have_a_band_over_seeds(learned, tmp_path):
    from vertibench.training._curves import _interval, curves

    folder, run = learned
    run("other", 2048, seed=2)
    told = curves([folder / "whole", folder / "other"], tmp_path / "curves.svg")
    # The first run went on alone.
    assert told.splitlines()[0].endswith("% with one seed at 4,096 steps")
    table = (tmp_path / "curves.csv").read_text().splitlines()
    assert table[0] == "planner,seed,steps,success_percent"
    assert [row.split(",")[1:3] for row in table[1:]] == [["1", "2048"], ["1", "4096"], ["2", "2048"]]
    assert (tmp_path / "curves.svg").read_text().count("<polygon") == 1
    # What was written goes on with other runs, and says the same again.
    assert curves([tmp_path / "curves.csv", folder / "other"], tmp_path / "again.svg").splitlines()[0] == told.splitlines()[0]
    for name in ("svg", "csv"):
        assert (tmp_path / f"again.{name}").read_text() == (tmp_path / f"curves.{name}").read_text()
    (tmp_path / "other.csv").write_text("planner,steps\nrl,1\n")
    with pytest.raises(TrainingError, match="other.csv: it is no table of curves: KeyError: 'seed'"):
        curves([tmp_path / "other.csv"], tmp_path / "again.svg")
    # Student's t of two degrees of freedom: 4.303 * 1 / sqrt(3).
    assert _interval([1.0, 2.0, 3.0]) == pytest.approx((2.0, 2.0 - 2.4843, 2.0 + 2.4843), abs=1e-3)


def test_a_card_has_what_a_policy_does_beside_what_it_must_beat(learned, program, tmp_path):
    from vertibench.training._card import card
    from vertibench.training._export import export

    folder, run = learned
    run("other", 2048, seed=2)
    told = card(folder / "whole", tmp_path / "card.json", [folder / "other"])
    own = json.loads((tmp_path / "card.json").read_text())
    assert own["planner"] == PLANNERS[algorithm_of(run)] and own["seed"] == 1 and own["steps"] == 4096 and own["seconds"] > 0
    export(folder / "whole", tmp_path / "own.vbnn")
    assert own["weights_sha256"] == hashlib.sha256((tmp_path / "own.vbnn").read_bytes()).hexdigest()
    assert sorted(own["held_out"]) == ["other", "pid", "policy"] and f"pid: {own['held_out']['pid']['all']['success']} %" in told
    for driven in own["held_out"].values():
        assert driven["all"]["tasks"] == 3 == sum(level["tasks"] for level in driven["elevation"].values())
    less = own["success_less_that_of"]
    for name in ("other", "pid"):
        wanted = own["held_out"]["policy"]["all"]["success"] - own["held_out"][name]["all"]["success"]
        assert less[name]["points"] == pytest.approx(wanted, abs=0.11)
    with pytest.raises(TrainingError, match="the card has another run with the name other"):
        card(folder / "whole", tmp_path / "card.json", [folder / "other", folder / "other"])


@pytest.fixture(scope="module")
def demonstrations(harness, program):
    """Two drives of PID in a training world, with crops as the policy sees them."""
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    plugin = str(vertibench.plugin_path("pid.wasm"))
    tasks = ["--worlds", "1", "--world-seed", "7000", "--tasks", "w001/t00-t01", "--keep", "all", "--crops", "16"]
    return harness("dataset", "drive", "--plugin", plugin, *tasks, "--out", "demonstrations") / "demonstrations"


def test_what_a_policy_would_have_seen_is_what_datasets_have(envs, demonstrations):
    data = vertibench.datasets.open(demonstrations)
    own = envs.NavigationVectorEnv(1, suite=demonstrations / "suite", observation=["state", "goal", "command", "height", "class"])
    for k, episode in enumerate(data.episodes):
        frames = data.frames(k)
        state = frames["observation.state"].astype(np.float64)
        held = np.vstack([np.zeros((1, 3)), frames["action"][:-1, :3]]).astype(np.float64)
        seen = dict(zip([p["name"] for p in own._setup.parts], own._setup.arena.recall(episode.task, state, held)))
        np.testing.assert_allclose(seen["state"][:, :2], state[:, 3:5], atol=1e-6)
        np.testing.assert_allclose(seen["state"][:, 2:], state[:, 6:], atol=1e-6)
        np.testing.assert_allclose(seen["goal"], frames["observation.goal"], atol=1e-4)
        np.testing.assert_allclose(seen["command"], held, atol=1e-6)
        # A dataset's places are those of a pose in double precision.
        np.testing.assert_allclose(seen["height"], frames["observation.height_crop"], atol=1e-4)
        # Planners know obstacles from a map of squares, which are larger than the obstacles that datasets have.
        free = seen["class"] != 10
        assert (seen["class"] == frames["observation.class_crop"])[free].all() and free.mean() > 0.9
    with pytest.raises(vertibench.UnknownError, match="there is no task w009/t00"):
        own._setup.arena.recall("w009/t00", state, held)
    with pytest.raises(vertibench.OptionError, match="15 entries of the state and 3 of the command"):
        own._setup.arena.recall(data.episodes[0].task, state[:, :14], held)


def test_a_policy_can_begin_with_demonstrations(learned, demonstrations):
    folder, run = learned
    told = run("cloned", 2048, demonstrations=demonstrations)
    cloned = json.loads(re.search(r"cloned: (.*)", told)[1])
    data = vertibench.datasets.open(demonstrations)
    assert cloned["episodes"] == 2 and cloned["frames"] == sum(e.length for e in data.episodes)
    # Steering is never guessed as badly as by its mean.
    assert cloned["error"][0] < np.std(np.concatenate([data.frames(k)["action"][:, 0] for k in range(2)]))
    assert json.loads((folder / "cloned/checkpoint-000000002048/state.json").read_text())["cloned"] == cloned
    # Only the value has learned until now, so the policy is the one that was cloned.
    import torch

    first, later = (torch.load(folder / f"cloned/checkpoint-{n:012d}/model.pt", weights_only=True)["policy"] for n in (0, 2048))
    own, value = {
        "ppo": (("action_net", "mlp_extractor.policy_net", "features_extractor"), "value_net.weight"),
        "sac": (("actor",), "critic.qf0.0.weight"),
    }[algorithm_of(run)]
    kept = [name for name in first if name.startswith(own)]
    assert len(kept) > 5 and all(torch.equal(first[name], later[name]) for name in kept)
    assert not torch.equal(first[value], later[value])


def test_demonstrations_from_held_out_worlds_are_refused(learned, demonstrations):
    _, run = learned
    config = {**run.__defaults__[3], "held_out.seed": "7000", "held_out.count": "1", "held_out.tasks": '"w001/t00"'}
    with pytest.raises(vertibench.OptionError, match="w001 of the training worlds is world w001 of the suite"):
        run("held-out", 2048, changes=config, demonstrations=demonstrations)


def test_a_checkpoint_that_is_damaged_is_told(learned, tmp_path, capsys):
    from vertibench.training.__main__ import main

    folder, _ = learned
    shutil.copytree(folder / "whole/checkpoint-000000004096", tmp_path / "damaged")
    (tmp_path / "damaged/model.pt").write_bytes(b"PK no zip")
    assert main(["export", str(tmp_path / "damaged"), str(tmp_path / "own.vbnn")]) == 2
    assert main(["export", str(folder / "whole"), str(tmp_path / "nowhere/own.vbnn")]) == 3
    state = json.loads((tmp_path / "damaged/state.json").read_text())
    del state["config"]["ppo.batch"]
    (tmp_path / "damaged/state.json").write_text(json.dumps(state))
    assert main(["evaluate", str(tmp_path / "damaged")]) == 2
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 3 and "model.pt: it can't be read: " in told[0] and "own.vbnn: No such file" in told[1]
    assert told[2].endswith("damaged: ppo.batch: the field is missing (add it)")
