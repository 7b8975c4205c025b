"""Curves of success in held-out worlds over training steps, for several runs."""

from __future__ import annotations

import csv
import json
import math
import statistics
from collections import defaultdict
from pathlib import Path
from xml.sax.saxutils import escape

from ._config import TrainingError

#: Two-sided 95 % quantiles of Student's t by degrees of freedom, from 1.
_T = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262)
#: Okabe and Ito's colours, distinguishable with every type of colour vision.
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM = 720, 400, 56, 120, 16, 48

#: Columns of a table of curves.
_COLUMNS = ("planner", "seed", "steps", "success_percent")

#: Success in percent by planner, steps and seed.
Points = dict[str, dict[int, dict[int, float]]]


def curves(sources: list[Path], out: Path) -> str:
    """Plots success in held-out worlds over training steps as SVG, with a table (CSV) next to it.

    The curve of a planner is the mean over its seeds, with the 95 % interval of Student's t as a band. After the steps
    that all seeds have reached, each seed has a dashed line.

    Args:
        sources: Folders of runs, or tables that an earlier call has written.
        out: SVG file to write; the table has the suffix `.csv`.

    Returns:
        One line per planner with its last points, and a line with the written files.

    Raises:
        TrainingError: If a source can't be read, or contains no measurement.
    """
    points: Points = defaultdict(lambda: defaultdict(dict))
    for source in sources:
        for name, seed, steps, success in _table(source) if source.is_file() else _run(source):
            points[name][steps][seed] = success
    if not points:
        raise TrainingError(sources[0], "no measurement of success", "train until the first checkpoint")
    with out.with_suffix(".csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(_COLUMNS)
        for name, at in sorted(points.items()):
            seeds = sorted({seed for values in at.values() for seed in values})
            writer.writerows((name, k, steps, f"{at[steps][k]:.2f}") for k in seeds for steps in sorted(at) if k in at[steps])
    out.write_text(_picture(points), encoding="utf-8")
    told = []
    for name, at in sorted(points.items()):
        # The last step that all seeds have reached, and the end of the longest run.
        ends = dict.fromkeys([max(steps for steps, values in at.items() if len(values) == _seeds(at)), max(at)])
        told.append(f"{name}: " + "; ".join(_told(steps, list(at[steps].values())) for steps in ends))
    return "\n".join([*told, f"{out} and {out.with_suffix('.csv')}"])


def _seeds(at: dict[int, dict[int, float]]) -> int:
    """Returns the maximum number of seeds of a planner at any step."""
    return max(len(values) for values in at.values())


def _told(steps: int, values: list[float]) -> str:
    mean, low, high = _interval(values)
    seeds = f"[{low:.1f}, {high:.1f}] over {len(values)} seeds" if len(values) > 1 else "with one seed"
    return f"{mean:.1f} % {seeds} at {steps:,} steps"


def _run(run: Path) -> list[tuple[str, int, int, float]]:
    try:
        lines = [json.loads(line) for line in (run / "progress.jsonl").read_text(encoding="utf-8").splitlines()]
        state = json.loads(min(run.glob("checkpoint-*/state.json")).read_text(encoding="utf-8"))
    except (OSError, ValueError) as e:
        what = f"not a run with a checkpoint: {e}"
        raise TrainingError(run, what, "give folders that `train` has written, or tables of `curves`") from None
    measured = [line for line in lines if "held_out" in line]
    return [(state["planner"], state["seed"], line["steps"], line["held_out"].get("success", 0.0)) for line in measured]


def _table(file: Path) -> list[tuple[str, int, int, float]]:
    try:
        with file.open(encoding="utf-8", newline="") as read:
            rows = list(csv.DictReader(read))
        return [(row["planner"], int(row["seed"]), int(row["steps"]), float(row["success_percent"])) for row in rows]
    except (OSError, ValueError, KeyError, TypeError) as e:
        what = f"not a table of curves: {type(e).__name__}: {e}"
        raise TrainingError(file, what, "give a CSV that `curves` has written, or folders of runs") from None


def _interval(values: list[float]) -> tuple[float, float, float]:
    """Returns mean, lower and upper end of the 95 % interval over seeds; three times the mean for a single seed."""
    mean = statistics.fmean(values)
    if len(values) < 2:
        return mean, mean, mean
    t = _T[min(len(values) - 2, len(_T) - 1)]
    half = t * statistics.stdev(values) / math.sqrt(len(values))
    return mean, mean - half, mean + half


def _picture(points: Points) -> str:
    most = max(steps for at in points.values() for steps in at)
    wide, high = _WIDTH - _LEFT - _RIGHT, _HEIGHT - _TOP - _BOTTOM

    def x(steps: float) -> float:
        return round(_LEFT + wide * steps / most, 1)

    def y(percent: float) -> float:
        return round(_TOP + high * (1.0 - min(max(percent, 0.0), 100.0) / 100.0), 1)

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" font-family="sans-serif" font-size="13">',
        f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="#ffffff"/>',
        "<title>Success in held-out worlds over training steps</title>",
    ]
    for percent in range(0, 101, 20):
        parts.append(f'<path d="M{_LEFT} {y(percent)}H{_WIDTH - _RIGHT}" stroke="#dddddd"/>')
        parts.append(f'<text x="{_LEFT - 8}" y="{y(percent) + 4}" text-anchor="end" fill="#333333">{percent}</text>')
    for steps in _ticks(most):
        parts.append(f'<path d="M{x(steps)} {_HEIGHT - _BOTTOM}v5" stroke="#333333"/>')
        label = f"{steps / 1e6:g} M" if most >= 1e6 else f"{steps / 1e3:g} k"
        parts.append(f'<text x="{x(steps)}" y="{_HEIGHT - _BOTTOM + 20}" text-anchor="middle" fill="#333333">{label}</text>')
    parts.append(f'<text x="{_LEFT + wide / 2}" y="{_HEIGHT - 8}" text-anchor="middle" fill="#333333">training steps</text>')
    middle = _TOP + high / 2
    parts.append(
        f'<text x="14" y="{middle}" text-anchor="middle" fill="#333333" transform="rotate(-90 14 {middle})">'
        "success in held-out worlds, %</text>"
    )
    labels: list[tuple[float, str, str]] = []
    for (name, at), colour in zip(sorted(points.items()), _COLOURS * 9):
        seeds = _seeds(at)
        # A mean over fewer seeds would not continue the curve: after the steps that all seeds have reached, each has a thin line.
        whole = [(steps, *_interval(list(values.values()))) for steps, values in sorted(at.items()) if len(values) == seeds]
        if seeds > 1:
            edge = [f"{x(s)},{y(hi)}" for s, _, _, hi in whole] + [f"{x(s)},{y(lo)}" for s, _, lo, _ in reversed(whole)]
            parts.append(f'<polygon points="{" ".join(edge)}" fill="{colour}" fill-opacity="0.18"/>')
        line = " ".join(f"{x(s)},{y(m)}" for s, m, _, _ in whole)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2.5"/>')
        last = whole[-1]
        for seed in sorted({seed for values in at.values() for seed in values}):
            beyond = [(steps, values[seed]) for steps, values in sorted(at.items()) if seed in values and steps >= last[0]]
            if len(beyond) > 1:
                line = " ".join(f"{x(s)},{y(v)}" for s, v in beyond)
                parts.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-dasharray="5 3"/>')
        end = max(at)
        mean = statistics.fmean(at[end].values())
        labels.append((y(mean), f"{name} {mean:.0f} %", colour))
    below = 0.0
    for at_y, text, colour in sorted(labels):
        below = max(at_y + 4, below + 16)
        parts.append(f'<text x="{_WIDTH - _RIGHT + 8}" y="{below}" fill="{colour}">{escape(text)}</text>')
    return "\n".join([*parts, "</svg>", ""])


def _ticks(most: float) -> list[float]:
    """Returns five to ten round numbers from 0 to the maximum."""
    size = 10.0 ** math.floor(math.log10(most))
    step = next(size * f for f in (0.1, 0.2, 0.5, 1.0) if most / (size * f) <= 10)
    return [k * step for k in range(int(most / step) + 1)]
