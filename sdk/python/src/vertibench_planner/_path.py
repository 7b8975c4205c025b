"""Progress along a path."""

import numpy as np


class Follower:
    """Progress of a vehicle along a path.

    The progress never decreases. It increases by at most ``window`` per call of :meth:`update`, so it can't jump to a
    later section of the path that passes nearby.

    Args:
        path: Path points, an array of shape (n, 2): x and y, m, at least one finite point. Repeated points are removed.
        window: Maximum progress per call, m.

    Attributes:
        points: Path points, shape (n, 2), m.
        arcs: Arc length of each point from the start, shape (n,), m.
        arc: Arc length of the present progress, m; initially 0.

    Raises:
        ValueError: If the path is empty or has a number that is not finite.
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
        """Returns the path point at an arc length.

        Args:
            arc: Arc length from the start of the path, m; limited to the path.

        Returns:
            Array of x and y, m.
        """
        return np.array([np.interp(arc, self.arcs, self.points[:, axis]) for axis in (0, 1)])

    def update(self, x, y):
        """Advances to the closest path point within the window.

        Args:
            x: Position of the vehicle to the east, m.
            y: Position of the vehicle to the north, m.

        Returns:
            Arc length of the new progress, m.
        """
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
        """Returns the path point at a distance ahead of the progress.

        Args:
            distance: Distance along the path, m.

        Returns:
            Array of x and y, m; the end of the path if it is nearer.
        """
        return self.point_at(self.arc + distance)
