"""Makes neural_weights.npz: a network of 4-16-16-1 neurons learns the curvature of pure pursuit.

    python3 train_neural.py [FILE]

The same seed gives the same weights, up to the rounding of the linear algebra library. It takes some seconds.
"""

import sys
from pathlib import Path

import numpy as np
from neural import AHEAD, network

SAMPLES, ROUNDS, RATE = 1024, 2000, 5e-3


def samples(rng):
    """Poses of a vehicle near circular paths, with the steering commands of pure pursuit."""
    bend = rng.uniform(-0.12, 0.12, SAMPLES)  # 1/m
    offset, heading = rng.uniform(-3.0, 3.0, SAMPLES), rng.uniform(-0.8, 0.8, SAMPLES)
    points = []
    for s in AHEAD:
        # The path begins at the origin towards x; the sine quotients are finite at bend 0.
        x, y = s * np.sinc(bend * s / np.pi), s * np.sinc(bend * s / 2 / np.pi) * np.sin(bend * s / 2)
        y = y - offset
        points += [np.cos(heading) * x + np.sin(heading) * y, np.cos(heading) * y - np.sin(heading) * x]
    features = np.stack(points, axis=1)
    # Pure pursuit on the point half-way between the two.
    target = (features[:, :2] + features[:, 2:]) / 2
    curvature = 2.0 * target[:, 1] / np.maximum(np.sum(target**2, axis=1), 1.0)
    return features / 10.0, np.clip(curvature, -0.3, 0.3)


def train(seed=0):
    rng = np.random.default_rng(seed)
    x, y = samples(rng)
    sizes = [4, 16, 16, 1]
    w = {}
    for i, (a, b) in enumerate(zip(sizes, sizes[1:]), 1):
        w[f"w{i}"], w[f"b{i}"] = rng.normal(0.0, a**-0.5, (a, b)), np.zeros(b)
    moments = {k: (np.zeros_like(v), np.zeros_like(v)) for k, v in w.items()}
    for n in range(1, ROUNDS + 1):
        h1 = np.tanh(x @ w["w1"] + w["b1"])
        h2 = np.tanh(h1 @ w["w2"] + w["b2"])
        e3 = 2.0 * ((h2 @ w["w3"] + w["b3"])[:, 0] - y)[:, None] / len(y)
        e2 = (e3 @ w["w3"].T) * (1.0 - h2**2)
        e1 = (e2 @ w["w2"].T) * (1.0 - h1**2)
        slopes = {"w3": h2.T @ e3, "b3": e3.sum(0), "w2": h1.T @ e2, "b2": e2.sum(0), "w1": x.T @ e1, "b1": e1.sum(0)}
        # Adam (Kingma and Ba, 2015) with its usual constants.
        for k, g in slopes.items():
            m, v = moments[k]
            m += 0.1 * (g - m)
            v += 0.001 * (g**2 - v)
            w[k] -= RATE * (m / (1 - 0.9**n)) / (np.sqrt(v / (1 - 0.999**n)) + 1e-8)
    return {k: v.astype(np.float32) for k, v in w.items()}, float(np.sqrt(np.mean((network(w, x) - y) ** 2)))


if __name__ == "__main__":
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("neural_weights.npz")
    weights, error = train()
    np.savez(out, **weights)
    print(f"{out}: rms error of the curvature {error:.4f} 1/m")
