"""Path following and speed control.

The same formulas in the same order as in the Rust SDK (`path`, `speed` and `math::turn`), so that commands are
identical in both languages.
"""

from bisect import bisect_left, bisect_right
from math import fabs, fmod, pi, sqrt, tau

SPLIT = 134217729.0  # 2^27 + 1


def square(x):
    """x² as a rounded value and the rounding error (Dekker 1971)."""
    c = x * SPLIT
    high = x - c + c
    low = x - high
    value = x * x
    return value, high * high - value + 2.0 * high * low + low * low


def hypot(x, y):
    """Length of (x, y), of ordinary size. `math.hypot` rounds otherwise than the C library's function, which the SDK
    follows, in the last bit."""
    x, y = fabs(x), fabs(y)
    if x < y:
        x, y = y, x
    if y == 0.0:
        return x
    (hx, lx), (hy, ly) = square(x), square(y)
    return sqrt(ly + lx + hy + hx)


def clamp(value, low, high):
    """Clamps a number to [low, high]."""
    return low if value < low else high if value > high else value


def turn(start, end):
    """The turn from direction `start` to direction `end`, rad in [-π, π), positive to the left."""
    a = fmod(end - start + pi, tau)
    if a < 0.0:
        a += tau
    # A tiny negative remainder plus 2π may round to 2π, the excluded end of the interval.
    return -pi if a >= tau else a - pi


def throttle_and_brake(target, speed):
    """Throttle and brake, each in [0, 1], proportional to the speed error (m/s)."""
    u = clamp(target - speed, -1.0, 1.0)
    return (u, 0.0) if u >= 0.0 else (0.0, -u)


class Path:
    """A polyline, measured by arc length (m) from its start. Points are (x, y)."""

    def __init__(self, points):
        self.points = points
        self.arc = [0.0]
        for (ax, ay), (bx, by) in zip(points, points[1:]):
            self.arc.append(self.arc[-1] + hypot(bx - ax, by - ay))

    def length(self):
        """Total length, m."""
        return self.arc[-1]

    def point_at(self, arc):
        """The point at an arc length, clamped to the start and the end."""
        i = bisect_left(self.arc, arc)
        if i == 0:
            return self.points[0]
        if i == len(self.points):
            return self.points[i - 1]
        (ax, ay), (bx, by) = self.points[i - 1], self.points[i]
        t = (arc - self.arc[i - 1]) / (self.arc[i] - self.arc[i - 1])
        return ax + (bx - ax) * t, ay + (by - ay) * t

    def closest_between(self, x, y, start, end):
        """Arc length of the point closest to (x, y) among those from arc length `start` to `end`."""
        start = clamp(start, 0.0, self.length())
        end = clamp(end, start, self.length())

        def distance(arc):
            px, py = self.point_at(arc)
            return hypot(x - px, y - py)

        best, nearest = start, distance(start)
        for i in range(max(bisect_right(self.arc, start), 1), len(self.points)):
            if self.arc[i - 1] > end:
                break
            length = self.arc[i] - self.arc[i - 1]
            if length == 0.0:
                continue
            (ax, ay), (bx, by) = self.points[i - 1], self.points[i]
            along = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length
            arc = clamp(self.arc[i - 1] + clamp(along, 0.0, length), start, end)
            if distance(arc) < nearest:
                best, nearest = arc, distance(arc)
        return best


class Follower:
    """Progress along a path. It never decreases, and advances by at most `window` metres per call, so that it does not
    jump to a later section nearby."""

    def __init__(self, path, window):
        self.path, self.window, self.arc = path, window, 0.0

    def update(self, x, y):
        """Advances to the closest point within the window."""
        self.arc = self.path.closest_between(x, y, self.arc, self.arc + self.window)

    def look_ahead(self, distance):
        """The point so many metres further along the path; its end if that is nearer."""
        return self.path.point_at(self.arc + distance)
