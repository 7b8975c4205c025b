"""Fits the errors of the kinematic bicycle over half a second of driving: fit_bicycle.py DATASET"""
import sys

import numpy as np

from vertibench import datasets


def motion(part):  # places are complex numbers: ahead + 1j * left
    now, later = part.pairs(seconds=0.5)
    s, e, applied = now["observation.state"], later["observation.state"], now["action.applied"]
    way, turn = 0.5 * s[:, 6], 0.5 * s[:, 6] * np.tan(np.radians(33.9) * applied[:, 0]) / 3.302
    known = np.c_[np.ones(len(s)), s[:, 3:5], s[:, 6:13], applied, turn]
    moved = np.exp(-1j * s[:, 5]) * ((e - s)[:, 0] + 1j * (e - s)[:, 1])
    return moved, way * np.exp(0.5j * turn), np.c_[known, known * s[:, 6:7]]


(moved, bicycle, known), test = map(motion, datasets.open(sys.argv[1]).split(train=0.8, seed=0))
residual = np.linalg.lstsq(known, moved - bicycle, rcond=None)[0]
errors = [np.abs(test[0] - guess).mean() for guess in (test[1], test[1] + test[2] @ residual)]
print("in worlds held out, the bicycle is off by {:.3f} m, with the residual {:.3f} m".format(*errors))
