"""A policy that drives in an environment has the record that the benchmark gives it as a planner."""

import json

import pytest
from conftest import pursue

import vertibench


@pytest.mark.parametrize("perception", ["oracle", "degraded"])
def test_the_same_policy_gives_the_same_record_both_ways(envs, program, tmp_path, perception):
    tasks = ["w001/t00", "w002/t01", "w003/t02", "w008/t04"]
    run = vertibench.run(
        "policy.wasm", suite="smoke", tasks=tasks, perception=perception, seed=7, out=tmp_path / "run", progress=False
    )
    env = envs.NavigationEnv(suite="smoke", tasks=tasks, perception=perception, observation=["path"])
    for line in (tmp_path / "run/tasks.jsonl").read_text().splitlines():
        planner = json.loads(line)
        observation, _ = env.reset(options={"task": planner["task"], "run_seed": 7})
        is_over = False
        while not is_over:
            observation, _, terminated, truncated, info = env.step(pursue(observation["path"]))
            is_over = terminated or truncated
        policy = info["record"]
        assert policy["state_hash"] == planner["state_hash"], planner["task"]
        # Only a plugin has fuel, and a log.
        del planner["fuel"], policy["fuel"]
        planner.pop("log", None), policy.pop("log", None)
        assert policy == planner
    assert len(run.records()) == len(tasks)
