"""Fits what the kinematic bicycle gets wrong about a second of driving. Usage: fit_bicycle.py DATASET"""
import glob
import sys

import numpy as np
import pandas as pd

AHEAD, WHEELBASE, LOCK = 10, 3.302, 0.592  # frames of 0.1 s; m and rad of the HMMWV

frames = pd.concat(pd.read_parquet(f) for f in sorted(glob.glob(f"{sys.argv[1]}/data/*/*.parquet")))
episodes = pd.read_parquet(f"{sys.argv[1]}/meta/episodes").set_index("episode_index")
state, applied = np.stack(frames["observation.state"]), np.stack(frames["action.applied"])
wheels, episode = np.stack(frames["observation.wheels"]), frames["episode_index"].to_numpy()

# Pairs of frames a second apart in the same episode, and the step in axes that turn with the vehicle.
now = np.flatnonzero(episode[AHEAD:] == episode[:-AHEAD])
x, y, yaw, v = (state[now, k] for k in (0, 1, 5, 6))
dx, dy = state[now + AHEAD, 0] - x, state[now + AHEAD, 1] - y
turn = np.angle(np.exp(1j * (state[now + AHEAD, 5] - yaw)))
target = np.stack([np.cos(yaw) * dx + np.sin(yaw) * dy, np.cos(yaw) * dy - np.sin(yaw) * dx, turn], 1)

# The bicycle by the speed now and the steering that is applied; its residual is linear in what is known.
rate = v * np.tan(LOCK * applied[now, 0]) / WHEELBASE
bicycle = np.stack([v * np.cos(rate / 2), v * np.sin(rate / 2), rate], 1)
speed = np.stack(frames["action.speed"]).ravel()[now]
known = np.concatenate([state[now][:, [3, 4, 6, 7, 9, 10, 11, 12]], applied[now], wheels[now], rate[:, None], speed[:, None]], 1)
features = np.concatenate([np.ones((len(now), 1)), known, known * v[:, None], known * speed[:, None]], 1)

# Every fifth world is held out: no model has seen it.
worlds = {w: k for k, w in enumerate(sorted(episodes["world"].unique()))}
held_out = episodes["world"].map(worlds).loc[episode[now]].to_numpy() % 5 == 0
weights = np.linalg.lstsq(features[~held_out], (target - bicycle)[~held_out], rcond=None)[0]
for name, error in [("bicycle", target - bicycle), ("with residual", target - bicycle - features @ weights)]:
    metres, radians = np.hypot(error[held_out, 0], error[held_out, 1]), np.abs(error[held_out, 2])
    print(f"{name:14} {metres.mean():.3f} m {np.degrees(radians.mean()):.2f} deg after a second, in worlds held out")
