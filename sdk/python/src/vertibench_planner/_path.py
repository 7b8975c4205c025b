"""Following a path."""

import numpy as np


class Follower:
    """A vehicle's progress along a path of n rows of x, y.

    It never goes back, and it advances by ``window`` metres a call at most, so it can't jump to a later stretch that
    passes nearby.
    """

    def __init__(self, path, window):
        path = np.asarray(path, float)
        if len(path) == 0 or not np.isfinite(path).all():
            raise ValueError("the global path is empty or not finite")
        # Repeated points have no direction.
        moved = np.any(np.diff(path, axis=0) != 0.0, axis=1)
        self.points = path[np.concatenate([[True], moved])]
        steps = np.diff(self.points, axis=0)
        self.arcs = np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])
        self.window = window
        self.arc = 0.0

    def point_at(self, arc):
        """The point at an arc length (m), within the path."""
        return np.array([np.interp(arc, self.arcs, self.points[:, axis]) for axis in (0, 1)])

    def update(self, x, y):
        """Advances to the closest point within the window and returns its arc length."""
        start, end = self.arc, min(self.arc + self.window, self.arcs[-1])
        first = max(np.searchsorted(self.arcs, start, side="right") - 1, 0)
        last = max(np.searchsorted(self.arcs, end, side="left"), first + 1)
        a, b, arcs = self.points[first:last], self.points[first + 1 : last + 1], self.arcs[first:last]
        a, arcs = a[: len(b)], arcs[: len(b)]
        if len(b):
            lengths = np.hypot(*(b - a).T)
            along = np.sum((np.array([x, y]) - a) * (b - a), axis=1) / lengths
            candidates = np.clip(arcs + np.clip(along, 0.0, lengths), start, end)
            points = np.stack([np.interp(candidates, self.arcs, self.points[:, axis]) for axis in (0, 1)])
            self.arc = float(candidates[np.argmin(np.hypot(points[0] - x, points[1] - y))])
        return self.arc

    def look_ahead(self, distance):
        """The point ``distance`` metres further along the path; its end if that is nearer."""
        return self.point_at(self.arc + distance)
