"""The module against hand-made messages: what docs/worker-protocol.md says is what it does."""

import io
import os
import select
import struct
import subprocess
import sys
from pathlib import Path

import msgpack
import numpy as np
import pytest
import vertibench_planner
from vertibench_planner import Command, Follower, Grid, Planner, serve

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))


def frame(kind, fields):
    payload = msgpack.packb({kind: fields})
    return struct.pack("<I", len(payload)) + payload


def grid(data):
    rows, cols = data.shape
    frame = {"rows": rows, "cols": cols, "resolution": 0.5, "origin_x": -1.0, "origin_y": 2.0}
    return {"frame": frame, "data": data.tobytes()}


VEHICLE = {
    "name": "v", "scale": 1.0, "mass": 1.0, "length": 1.0, "width": 1.0, "height": 1.0, "wheelbase": 3.0, "track": 1.0,
    "wheel_radius": 0.5, "wheels": 4, "ground_clearance": 0.3, "max_steer_angle": 0.5, "max_steer_rate": 1.0,
    "min_turn_radius": 7.0, "effective_track": 0.0, "turn_rate_in_place": 0.0, "max_speed": 30.0, "max_reverse_speed": 5.0, "direction_change_speed": 0.5,
    "direction_change_time": 0.6, "later": "ignored",
}  # fmt: skip
TASK = {
    "id": "w001/t00", "vehicle": VEHICLE, "elevation": grid(np.array([[0, 1, 2], [3, 4, 5]], "<f4")),
    "semantics": grid(np.zeros((2, 3), "u1")), "occupancy": grid(np.eye(2, 3, dtype="u1")),
    "path": [[0.0, 0.0], [10.0, 0.0]], "start": [0.0, 0.0, 0.5], "goal": [10.0, 0.0], "goal_radius": 8.0,
    "time_limit": 60.0, "control_period": 0.1, "seed": 2**64 - 1, "half_extent": [64.0, 64.0],
    "params": [{"key": "speed", "value": "2"}], "perception": "oracle", "depth": None,
    "lidar": {
        "period": 0.1, "rows": 2, "cols": 4, "lowest": 0.0, "highest": 0.5, "min_range": 0.5, "max_range": 50.0,
        "mount": {"position": [0.5, 0.0, 2.0], "roll": 0.0, "pitch": 0.0, "yaw": np.pi / 2},
    }, "later": 1,
}  # fmt: skip
OBSERVATION = {
    "time": 0.1, "wheels": [{"spin": 2.0, "travel": 0.01}] * 4, "imu": [], "gnss": None, "depth": None, "local_map": None,
    "pose": {
        "position": [1.0, 2.0, 3.0], "roll": 0.0, "pitch": 0.0, "yaw": 0.25, "linear_velocity": [1.0, 0.0, 0.0],
        "angular_velocity": [0.0, 0.0, 0.0],
    },
    "lidar": {"time": 0.1, "ranges": np.array([0, 0, 2, 0, 0, 0, 0, 0], "<f4").tobytes()},
    "gear": "forward", "engine_speed": 80.0, "steering": 0.0, "last_steering": 0.0, "last_throttle": 0.0, "last_brake": 0.0,
}  # fmt: skip


def talk(planner, *requests):
    out = io.BytesIO()
    serve(planner, io.BytesIO(b"".join(frame(*r) for r in requests)), out)
    data, replies = out.getvalue(), []
    while data:
        (length,) = struct.unpack("<I", data[:4])
        replies += msgpack.unpackb(data[4 : 4 + length]).items()
        data = data[4 + length :]
    return replies


class Probe(Planner):
    name = "probe"
    params = {"speed": (3.0, "m/s")}

    def init(self, task):
        self.log("started")
        self.speed, self.task = task.number("speed"), task

    def step(self, obs):
        if obs.time > 1.0:
            raise RuntimeError("too late")
        spins = [wheel.spin for wheel in obs.wheels]
        points = self.task.lidar.points(obs.lidar)
        return Command(obs.pose.yaw, np.float32(self.speed), 0, "reverse", debug={"wheels": spins, "points": points})


def test_a_conversation_from_hello_to_bye():
    late = dict(OBSERVATION, time=2.0)
    replies = talk(
        Probe, ("hello", {"protocol": 1, "abi": "1.0"}), ("init", TASK), ("step", OBSERVATION), ("step", late),
        ("drop", {}), ("init", TASK), ("bye", {}), ("hello", {}),
    )  # fmt: skip
    hello = replies[0][1]
    assert (hello["protocol"], hello["abi"], hello["name"], hello["control_period"]) == (1, "1.0", "probe", 0.1)
    assert hello["params"] == [{"key": "speed", "default": "3.0", "help": "m/s"}]
    log = ("log", {"level": "info", "message": "started"})
    # Column 2 of 4 looks 45 degrees to the left of the sensor's x axis, which is turned to the left by 90 degrees.
    (wheels, points) = replies[3][1].pop("debug")
    assert wheels == {"name": "wheels", "values": [2.0] * 4}
    assert points["values"] == pytest.approx([0.5 - 2.0**0.5, 2.0**0.5, 2.0])
    command = {"steering": 0.25, "throttle": 2.0, "brake": 0.0, "gear": "reverse"}
    assert replies[1:4] == [log, ("ready", {}), ("command", command)]
    kind, error = replies[4]
    assert kind == "error" and error["kind"] == "error"
    assert error["message"].startswith("RuntimeError: too late (test_planner.py:")
    assert replies[5:] == [("dropped", {}), log, ("ready", {})]


def test_maps_are_arrays_with_row_0_in_the_south():
    seen = []

    class Keep(Planner):
        def init(self, task):
            seen.append(task)

    talk(Keep, ("init", TASK))
    elevation = seen[0].elevation
    assert elevation.data.dtype == np.float32 and elevation.data.tolist() == [[0, 1, 2], [3, 4, 5]]
    # By the frame: columns are at x = -1, -0.5, 0 and rows at y = 2, 2.5.
    assert elevation.at(-0.5, 2.5) == 4 and elevation.at(100.0, -100.0) == 2
    assert elevation.at(np.array([-1.0, 0.0]), np.array([2.0, 2.5])).tolist() == [0, 5]
    assert seen[0].seed == 2**64 - 1 and seen[0].path.shape == (2, 2)


def test_half_a_cell_goes_up():
    grid = Grid(np.zeros((9, 9)), 1.0, 0.0, 0.0)
    assert [int(grid.cell(x, 0.0)[1]) for x in (0.5, 1.5, 2.5)] == [1, 2, 3]


def test_every_bit_of_a_number_crosses():
    odd = np.array([-0.0, 5e-324, np.inf, 1.0 + 2.0**-52])
    for x in odd:
        out = talk(Probe, ("init", TASK), ("step", dict(OBSERVATION, pose=dict(OBSERVATION["pose"], yaw=float(x)))))
        assert struct.pack("<d", out[-1][1]["steering"]) == struct.pack("<d", x)


def test_a_parameter_that_is_no_number_is_an_error():
    kind, error = talk(Probe, ("init", dict(TASK, params=[{"key": "speed", "value": "nan"}])))[-1]
    assert kind == "error" and "parameter `speed`: `nan` is not a number" in error["message"]


def test_a_parameter_that_is_not_declared_is_an_error_that_names_those_that_are():
    class Typo(Probe):
        def init(self, task):
            task.number("sped")

    kind, error = talk(Typo, ("init", TASK))[-1]
    wanted = "ValueError: parameter `sped` is not declared in the planner's params, which have speed (test_planner.py:"
    assert kind == "error" and error["message"].startswith(wanted), error


def test_parameters_without_a_help_text_say_how_to_declare_them():
    class Numbers(Probe):
        params = {"speed": 4.0}

    kind, error = talk(Numbers, ("hello", {"protocol": 1, "abi": "1.0"}))[-1]
    wanted = 'TypeError: params["speed"] is 4.0; write {"speed": (4.0, "what it is for")}'
    assert (kind, error["message"]) == ("error", wanted)


def in_step(planner):
    """Where this file has the planner's step."""
    return f" (step in test_planner.py:{planner.step.__code__.co_firstlineno})"


@pytest.mark.parametrize("answer", [None, {"steering": 0.0}, (0.0, 1.0, 0.0)])
def test_a_step_that_returns_no_command_is_told_so(answer):
    class Mute(Probe):
        def step(self, obs):
            return answer

    kind, error = talk(Mute, ("init", TASK), ("step", OBSERVATION))[-1]
    told = f"TypeError: step returned {answer!r}; return a Command, as Command(steering, throttle, brake)"
    assert (kind, error["message"]) == ("error", told + in_step(Mute))


def test_a_field_of_a_command_that_is_no_number_is_named():
    class Words(Probe):
        def step(self, obs):
            bad = [Command("left"), Command(debug={"cost": "high"}), Command(gear="sideways")]
            return bad[int(obs.time)]

    later = [("step", dict(OBSERVATION, time=t)) for t in (1.0, 2.0)]
    replies = talk(Words, ("init", TASK), ("step", OBSERVATION), *later)
    told = "ValueError: the command's gear is 'sideways'; it must be one of forward, neutral, reverse"
    place = in_step(Words)
    assert replies.pop()[1]["message"] == told + place
    assert replies[-2][1]["message"] == "TypeError: the command's steering is 'left'; it must be a number" + place
    assert replies[-1][1]["message"] == "TypeError: the command's debug[\"cost\"] is 'high'; it must be numbers" + place


PRINTS = """
from vertibench_planner import Command, Planner, main

class Prints(Planner):
    def init(self, task):
        print("init of", task.id)

    def step(self, obs):
        print("step at", obs.time)
        return Command(brake=1.0)

main(Prints)
"""


def test_what_a_planner_prints_is_there_before_the_answer():
    # Where this is set, Python buffers nothing at all.
    env = {key: value for key, value in os.environ.items() if key != "PYTHONUNBUFFERED"}
    env["PYTHONPATH"] = os.pathsep.join([str(Path(vertibench_planner.__file__).parents[1]), *sys.path])
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    told = []
    with subprocess.Popen([sys.executable, "-c", PRINTS], env=env, **pipes) as process:
        for request in [("hello", {"protocol": 1, "abi": "1.0"}), ("init", TASK), ("step", OBSERVATION)]:
            process.stdin.write(frame(*request))
            process.stdin.flush()
            (length,) = struct.unpack("<I", process.stdout.read(4))
            process.stdout.read(length)
            there, _, _ = select.select([process.stderr], [], [], 0)
            told.append(os.read(process.stderr.fileno(), 1000).decode() if there else "")
    assert told == ["", "init of w001/t00\n", "step at 0.1\n"]


def test_a_level_of_the_log_that_there_isnt_is_refused_with_those_that_there_are():
    class Warns(Probe):
        def init(self, task):
            self.log("fine", level="warn")
            self.log("not fine", level="warning")

    replies = talk(Warns, ("init", TASK))
    assert replies[0] == ("log", {"level": "warn", "message": "fine"})
    told = "ValueError: the level of a line of the log is 'warning'; it must be one of error, warn, info, debug"
    assert replies[1][1]["message"].startswith(told), replies[1:]


def test_sensors_and_models_are_part_of_the_introduction():
    class Learned(Probe):
        needs = ("pose", "lidar 10")
        needs_without_maps = ("local-map",)
        models = ("weights 00ff",)

    hello = talk(Learned, ("hello", {"protocol": 1, "abi": "1.0"}))[0][1]
    assert hello["needs"] == ["pose", "lidar 10"] and hello["needs_without_maps"] == ["local-map"]
    assert hello["models"] == ["weights 00ff"]
    assert talk(Probe, ("hello", {"protocol": 1, "abi": "1.0"}))[0][1]["models"] == []


def test_what_pip_leaves_behind_is_not_part_of_the_checkout():
    """`pip install sdk/python` builds in the folder itself."""
    folder = Path(__file__).parents[1]
    left = ["build/lib/vertibench_planner/__init__.py", "src/vertibench_planner.egg-info/PKG-INFO"]
    try:
        inside = subprocess.run(["git", "rev-parse"], cwd=folder, capture_output=True).returncode == 0
    except FileNotFoundError:
        inside = False
    if not inside:
        pytest.skip("this is no checkout")
    found = subprocess.run(["git", "check-ignore", *left], cwd=folder, capture_output=True, text=True)
    assert found.stdout.split() == left


def test_a_follower_goes_ahead_only_and_within_its_window():
    # Out along y = 0 and back along y = 1.
    path = [[0, 0], [5, 0], [5, 0], [10, 0], [10, 1], [0, 1]]
    follower = Follower(path, 4.0)
    assert follower.update(2.0, 0.6) == pytest.approx(2.0)
    assert follower.look_ahead(5.0) == pytest.approx([7.0, 0.0])
    assert follower.update(0.0, 0.0) == pytest.approx(2.0)
    assert follower.update(20.0, 0.0) == pytest.approx(6.0)
    for x in range(7, 14):
        follower.update(min(x, 10), 0.0)
    assert follower.update(9.0, 1.0) == pytest.approx(12.0)
    assert follower.look_ahead(100.0) == pytest.approx([0.0, 1.0])


def test_the_weights_are_those_that_the_script_makes():
    import train_neural

    weights, error = train_neural.train()
    stored = np.load(Path(train_neural.__file__).with_name("neural_weights.npz"))
    x, y = train_neural.samples(np.random.default_rng(7))
    for w in (weights, stored):
        # 1/m, of curvatures up to 0.3. Weights differ a little from one linear algebra library to the next.
        assert np.sqrt(np.mean((train_neural.network(w, x) - y) ** 2)) < 0.01
    assert error < 0.01
    assert {k: v.shape for k, v in weights.items()} == {k: stored[k].shape for k in stored}
