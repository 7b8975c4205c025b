"""Map of a task as SVG: ground, obstacles, global path, start, goal and trajectories."""

from __future__ import annotations

import base64
import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from ..datasets._world import CLASSES, Obstacle, World
from . import relief
from .places import Task

#: Colours of several runs, in order, as in replays.
RUN_COLOURS = ("#2a6fb3", "#d07a1d", "#2c8c5a", "#8057b8", "#c0412b", "#168a92", "#8a6636", "#b94888")
#: Colours of speeds, from slow to fast, distinguishable from each other and from the ground with every type of colour vision.
_SPEEDS = ("#2b0a56", "#5b1a86", "#8f2a81", "#c43c6e", "#f0605d", "#fd9567", "#fdc527", "#fcfdbf")
#: Longer side of the map, its margin, width of the column next to it, and their distance, in units of the picture.
_MAP, _TOP, _SIDE, _GAP = 520.0, 10.0, 262.0, 18.0
#: Maximum number of drawn points of a trajectory.
_POINTS = 1500
_GOOD, _BAD = "#1d7a46", "#b3261e"
#: Points in the world: x and y of each, m.
Points = Sequence[tuple[float, float]] | np.ndarray


@dataclass(frozen=True)
class Driven:
    """Trajectory and outcome of a run."""

    label: str
    outcome: str
    reason: str
    time_s: float
    x: np.ndarray  #: m, shape (samples,)
    y: np.ndarray  #: m, shape (samples,)
    speed: np.ndarray  #: m/s, shape (samples,)


class _Map:
    """Transformation from world to picture coordinates."""

    def __init__(self, world: World):
        self.size_x, self.size_y = world.size
        self.per_m = _MAP / max(self.size_x, self.size_y)
        self.width, self.height = self.size_x * self.per_m, self.size_y * self.per_m

    def at(self, x: float, y: float) -> tuple[float, float]:
        return (_TOP + (x + self.size_x / 2) * self.per_m, _TOP + (self.size_y / 2 - y) * self.per_m)

    def points(self, xy: Points) -> str:
        return " ".join(f"{u:.1f},{v:.1f}" for u, v in (self.at(x, y) for x, y in xy))


def svg(task: Task, runs: Sequence[Driven] = (), goal_radius: float | None = None) -> str:
    """Returns the picture as SVG.

    The trajectory of a single run is coloured by speed; several runs have one colour each. A circle of `goal_radius`
    (m), if given, surrounds the goal.
    """
    place = _Map(task.world)
    x0, x1, y0 = _TOP, _TOP + place.width, _TOP
    image = base64.b64encode(relief.png(task.world)).decode()
    parts = [
        f'<image x="{x0}" y="{y0}" width="{place.width:.1f}" height="{place.height:.1f}" preserveAspectRatio="none" '
        f'href="data:image/png;base64,{image}"/>',
        '<g fill="#4a4744" stroke="#211f1d" stroke-width="0.8">',
        *(_obstacle(o, place) for o in task.world.obstacles),
        "</g>",
        _line(task.path, place, "#1c1c1c", 3.4, 0.45),
        _line(task.path, place, "#ffffff", 1.8, 1.0, 'stroke-dasharray="5 4"', "the global path"),
    ]
    top = max((float(d.speed.max()) for d in runs if len(d.speed)), default=0.0)
    for k, driven in enumerate(runs):
        parts += _trajectory(driven, place, top if len(runs) == 1 else None, RUN_COLOURS[k % len(RUN_COLOURS)])
    parts += [_goal(task, place, goal_radius), _start(task, place)]
    parts += [
        _end(d, place, RUN_COLOURS[k % len(RUN_COLOURS)] if len(runs) > 1 else None)
        for k, d in enumerate(runs)
        if len(d.x)
    ]
    height = place.height + 2 * _TOP
    frame = (
        f'<rect x="{x0}" y="{y0}" width="{place.width:.1f}" height="{place.height:.1f}" fill="none" stroke="#8a8f94"/>'
    )
    beside, needed = _beside(task, runs, top, x1 + _GAP)
    height = max(height, needed + _TOP)
    total = x1 + _GAP + _SIDE
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {total:.0f} {height:.0f}" width="{total:.0f}" '
        f'style="max-width:100%;height:auto;background:#fff" role="img" aria-label="{escape(f"{task.name} of {task.suite} from above")}" '
        f'font-family="system-ui,-apple-system,\'Segoe UI\',Roboto,sans-serif" font-size="12.5" fill="#1f2326">'
        f'<rect width="100%" height="100%" fill="#fff"/>'
        f'<clipPath id="map"><rect x="{x0}" y="{y0}" width="{place.width:.1f}" height="{place.height:.1f}"/></clipPath>'
        f'<g clip-path="url(#map)">{"".join(parts)}{_scale(place)}</g>{frame}{beside}</svg>'
    )


def _obstacle(o: Obstacle, place: _Map) -> str:
    u, v = place.at(o.x, o.y)
    a, b = (place.per_m * s for s in o.size[:2])
    title = f"<title>{escape(o.kind)}, {o.size[2]:.1f} m high, {o.buried:.1f} m of it below the ground</title>"
    turned = f'transform="translate({u:.1f} {v:.1f}) rotate({-math.degrees(o.yaw):.1f})"'
    if o.kind == "box":
        return f'<rect {turned} x="{-a / 2:.1f}" y="{-b / 2:.1f}" width="{a:.1f}" height="{b:.1f}">{title}</rect>'
    return f'<ellipse {turned} rx="{a / 2:.1f}" ry="{b / 2:.1f}">{title}</ellipse>'


def _line(xy: Points, place: _Map, colour: str, width: float, opacity: float, more: str = "", title: str = "") -> str:
    told = f"<title>{escape(title)}</title>" if title else ""
    return (
        f'<polyline points="{place.points(xy)}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-opacity="{opacity}" '
        f'stroke-linecap="round" stroke-linejoin="round" {more}>{told}</polyline>'
    )


def _trajectory(driven: Driven, place: _Map, top: float | None, colour: str) -> list[str]:
    """Returns the line of a trajectory, coloured by speed up to `top` if this is given."""
    keep = np.arange(0, len(driven.x), max(1, -(-len(driven.x) // _POINTS)))
    if len(driven.x) and keep[-1] != len(driven.x) - 1:
        keep = np.append(keep, len(driven.x) - 1)
    xy = np.column_stack([driven.x[keep], driven.y[keep]])
    if len(xy) < 2:
        return []
    lines = [_line(xy, place, "#ffffff", 6.0, 0.9)]
    if top is None:
        return [*lines, _line(xy, place, colour, 3.6, 1.0, "", f"{driven.label}: {driven.outcome}")]
    bins = np.minimum((driven.speed[keep] / max(top, 1e-9) * len(_SPEEDS)).astype(int), len(_SPEEDS) - 1)
    lines.append(_line(xy, place, "#15171a", 4.6, 1.0))
    changes = [0, *(np.flatnonzero(np.diff(bins)) + 1).tolist(), len(xy) - 1]
    for first, last in zip(changes, changes[1:]):
        if last > first:
            lines.append(_line(xy[first : last + 1], place, _SPEEDS[bins[first]], 3.2, 1.0))
    return lines


def _start(task: Task, place: _Map) -> str:
    u, v = place.at(*task.start[:2])
    turn = -math.degrees(task.start[2])
    return (
        f'<path transform="translate({u:.1f} {v:.1f}) rotate({turn:.1f})" d="M11,0 L-7,7 L-3.5,0 L-7,-7 Z" fill="#ffffff" '
        f'stroke="#15171a" stroke-width="1.8" stroke-linejoin="round"><title>start</title></path>'
    )


def _goal(task: Task, place: _Map, radius: float | None) -> str:
    u, v = place.at(*task.goal)
    circle = ""
    if radius is not None:
        circle = (
            f'<circle cx="{u:.1f}" cy="{v:.1f}" r="{radius * place.per_m:.1f}" fill="#ffd23f" fill-opacity="0.22" stroke="#15171a" '
            f'stroke-width="3" stroke-opacity="0.5"/><circle cx="{u:.1f}" cy="{v:.1f}" r="{radius * place.per_m:.1f}" fill="none" '
            f'stroke="#ffd23f" stroke-width="1.8"><title>success within {radius:g} m of the goal</title></circle>'
        )
    return f'{circle}<polygon points="{_star(u, v, 9.0)}" fill="#ffd23f" stroke="#15171a" stroke-width="1.4"><title>goal</title></polygon>'


def _star(u: float, v: float, size: float) -> str:
    corners = enumerate([size, 0.42 * size] * 5)
    return " ".join(
        f"{u + r * math.sin(k * math.pi / 5):.1f},{v - r * math.cos(k * math.pi / 5):.1f}" for k, r in corners
    )


def _end(driven: Driven, place: _Map, colour: str | None) -> str:
    u, v = place.at(float(driven.x[-1]), float(driven.y[-1]))
    good = driven.outcome == "success"
    mark = f"M{u - 3.4:.1f},{v + 0.3:.1f} l2.6,3 l4.4,-5.6" if good else f"M{u - 3:.1f},{v - 3:.1f} l6,6 m0,-6 l-6,6"
    fill = colour or (_GOOD if good else _BAD)
    return (
        f'<circle cx="{u:.1f}" cy="{v:.1f}" r="7.5" fill="{fill}" stroke="#fff" stroke-width="1.6">'
        f"<title>{escape(f'{driven.label}: {driven.reason}')}</title></circle>"
        f'<path d="{mark}" fill="none" stroke="#fff" stroke-width="1.9" stroke-linecap="round" stroke-linejoin="round" pointer-events="none"/>'
    )


def _scale(place: _Map) -> str:
    """Returns a scale bar of round length and a north arrow."""
    length = next(
        m for m in (50, 20, 10, 5, 2, 1, 0.5, 0.2, 0.1, 0.01) if m * place.per_m <= 0.3 * place.width or m == 0.01
    )
    long, u, v = length * place.per_m, _TOP + 14, _TOP + place.height - 14
    right = _TOP + place.width - 20
    return (
        f'<g font-size="11.5" font-weight="600" paint-order="stroke" stroke-linejoin="round">'
        f'<path d="M{u},{v - 5} v5 h{long:.1f} v-5" fill="none" stroke="#fff" stroke-width="4.5"/>'
        f'<path d="M{u},{v - 5} v5 h{long:.1f} v-5" fill="none" stroke="#15171a" stroke-width="1.8"/>'
        f'<text x="{u + long / 2:.1f}" y="{v - 7}" text-anchor="middle" stroke="#fff" stroke-width="3">{length:g} m</text>'
        f'<path d="M{right},{_TOP + 34} v-16 m-5,6 l5,-7 l5,7" fill="none" stroke="#fff" stroke-width="4.5"/>'
        f'<path d="M{right},{_TOP + 34} v-16 m-5,6 l5,-7 l5,7" fill="none" stroke="#15171a" stroke-width="1.8"/>'
        f'<text x="{right}" y="{_TOP + 47}" text-anchor="middle" stroke="#fff" stroke-width="3">N</text></g>'
    )


def _beside(task: Task, runs: Sequence[Driven], top: float, x: float) -> tuple[str, float]:
    """Returns the column next to the map, and its lower end."""
    parts: list[str] = []
    y = _TOP + 16.0

    def text(told: str, style: str = "", step: float = 18.0, indent: float = 0.0) -> None:
        nonlocal y
        parts.append(f'<text x="{x + indent:.1f}" y="{y:.1f}" {style}>{escape(told)}</text>')
        y += step

    soft = 'fill="#5d666d"'
    text(task.name, 'font-size="19" font-weight="650"', 19)
    world = task.world
    text(f"{task.suite} · {world.elevation} · {world.terrain} · {world.density}", soft, 24)
    for k, driven in enumerate(runs):
        colour = RUN_COLOURS[k % len(RUN_COLOURS)]
        name = textwrap.shorten(driven.label, 34, placeholder=" …")
        if len(runs) > 1:
            parts.append(f'<rect x="{x:.1f}" y="{y - 10:.1f}" width="12" height="12" rx="2" fill="{colour}"/>')
        text(name, 'font-weight="600"', 17, 18 if len(runs) > 1 else 0)
        shade = _GOOD if driven.outcome == "success" else _BAD
        text(f"{driven.outcome} after {driven.time_s:.2f} s", f'fill="{shade}" font-weight="600"', 17)
        for line in textwrap.wrap(driven.reason, 38)[:3]:
            text(line, soft, 16)
        y += 8
    if len(runs) == 1 and top > 0:
        text("speed, m/s", soft, 8)
        wide = 180.0 / len(_SPEEDS)
        parts += [
            f'<rect x="{x + k * wide:.1f}" y="{y:.1f}" width="{wide + 0.3:.1f}" height="10" fill="{c}"/>'
            for k, c in enumerate(_SPEEDS)
        ]
        parts.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="180" height="10" fill="none" stroke="#8a8f94" stroke-width="0.6"/>'
        )
        y += 24
        parts.append(f'<text x="{x:.1f}" y="{y:.1f}" {soft}>0</text>')
        parts.append(f'<text x="{x + 180:.1f}" y="{y:.1f}" text-anchor="end" {soft}>{top:.1f}</text>')
        y += 24
    signs = [
        ("start", '<path d="M8,0 L-5,5 L-2.5,0 L-5,-5 Z" fill="#fff" stroke="#15171a" stroke-width="1.5"/>'),
        ("goal", f'<polygon points="{_star(0, 0, 7.5)}" fill="#ffd23f" stroke="#15171a" stroke-width="1.2"/>'),
        ("global path", '<path d="M-7,0 h14" stroke="#6c747a" stroke-width="2" stroke-dasharray="4 3"/>'),
    ]
    if world.obstacles:
        signs.append((f"obstacles ({len(world.obstacles)})", '<circle r="5" fill="#4a4744" stroke="#211f1d"/>'))
    for told, sign in signs:
        parts.append(f'<g transform="translate({x + 7:.1f} {y - 4:.1f})">{sign}</g>')
        text(told, "", 18, 22)
    y += 6
    counts = np.bincount(world.classes.ravel(), minlength=len(CLASSES))
    for k in np.argsort(-counts, kind="stable"):
        if counts[k]:
            colour = relief.COLOURS[CLASSES[k]]
            parts.append(
                f'<rect x="{x + 1:.1f}" y="{y - 10:.1f}" width="12" height="12" rx="2" fill="{colour}" stroke="#8a8f94" stroke-width="0.6"/>'
            )
            share = 100 * counts[k] / counts.sum()
            text(f"{CLASSES[k]}  {share:.0f} %" if share >= 0.5 else f"{CLASSES[k]}  < 1 %", "", 17, 22)
    low, high = float(world.heights.min()), float(world.heights.max())
    y += 5
    text(f"relief {high - low:.1f} m, {world.size[0]:g} m × {world.size[1]:g} m", soft, 16)
    return "".join(parts), y
