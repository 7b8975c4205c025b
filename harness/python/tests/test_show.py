"""What is shown is what was driven, where it was driven."""

import base64
import dataclasses
import html
import io
import json
import re
import shutil
import xml.etree.ElementTree as xml

import numpy as np
import PIL.Image
import pytest

import vertibench
from vertibench._runs import picture, places, relief

SVG = "{http://www.w3.org/2000/svg}"


def _titles(root, name):
    """The elements of a picture with this title."""
    return [e for e in root.iter() if any(t.text == name for t in e.findall(f"{SVG}title"))]


def _points(element):
    return np.array([[float(v) for v in p.split(",")] for p in element.get("points").split()])


def _on_the_map(world, x, y):
    """Where a place is: the map is 520 wide for the longer side, 10 from the corner, north up."""
    size_x, size_y = world.size
    per_m = 520 / max(size_x, size_y)
    return np.column_stack([10 + (np.asarray(x) + size_x / 2) * per_m, 10 + (size_y / 2 - np.asarray(y)) * per_m])


def _task(run, task):
    return places.read_task(places.suite_of(run, None), task, run.header["scale"])


def test_the_picture_has_path_start_goal_and_the_way(driven):
    run = vertibench.Run(driven / "slow")
    trace, task = run.trace("w003/t00"), _task(run, "w003/t00")
    root = xml.fromstring(run.show("w003/t00", replay=False).svg)
    (path,) = _titles(root, "the global path")
    assert np.allclose(_points(path), _on_the_map(task.world, *np.transpose(task.path)), atol=0.06)
    (goal,) = _titles(root, "success within 10 m of the goal")
    at = _on_the_map(task.world, *np.transpose([task.goal]))[0]
    assert np.allclose([float(goal.get("cx")), float(goal.get("cy"))], at, atol=0.06)
    assert float(goal.get("r")) == pytest.approx(10 * 520 / max(task.world.size), abs=0.06)
    (start,) = _titles(root, "start")
    u, v, turn = (float(n) for n in re.findall(r"-?[\d.]+", start.get("transform")))
    assert np.allclose([u, v], _on_the_map(task.world, *np.transpose([task.start[:2]]))[0], atol=0.06)
    assert turn == pytest.approx(-np.degrees(task.start[2]), abs=0.06), "pictures turn clockwise"
    # The pieces of the way by speed are the whole way, each in the colour of its speed.
    way = _on_the_map(task.world, trace["x"], trace["y"])
    pieces = [e for e in root.iter(f"{SVG}polyline") if e.get("stroke") in picture._SPEEDS]
    drawn = [_points(e) for e in pieces]
    assert all(np.array_equal(a[-1], b[0]) for a, b in zip(drawn, drawn[1:])) and len(pieces) > 3
    assert np.allclose(np.vstack([drawn[0][:1], *(d[1:] for d in drawn)]), way, atol=0.06)
    speed = np.sqrt(sum(trace[k] ** 2 for k in ("vx", "vy", "vz")))
    k = 0
    for piece, points in zip(pieces, drawn):
        share = speed[k] / speed.max() * len(picture._SPEEDS)
        assert picture._SPEEDS.index(piece.get("stroke")) == min(int(share), len(picture._SPEEDS) - 1)
        k += len(points) - 1
    told = " ".join(e.text or "" for e in root.iter(f"{SVG}text"))
    record = run.record("w003/t00")
    for text in (
        "w003/t00",
        record["reason"],
        f"{record['outcome']} after {record['time_s']:.2f} s",
        f"{speed.max():.1f}",
        "mud",
    ):
        assert text in told, text


def _pixels(data):
    with PIL.Image.open(io.BytesIO(data)) as image:
        assert (image.format, image.mode) == ("PNG", "RGB")
        return np.asarray(image)


def test_the_ground_is_coloured_and_lit_from_the_north_west(program):
    task = places.read_task(places.suite_folder("smoke"), "w006/t03")
    picture_of = vertibench.show_task("smoke", "w006/t03").svg
    data = base64.b64decode(re.search(r"data:image/png;base64,([^\"]+)", picture_of)[1])
    assert data == relief.png(task.world)
    pixels = _pixels(data)
    rows, cols = pixels.shape[:2]
    size_x, size_y = task.world.size
    rng = np.random.default_rng(1)
    for row, col in zip(rng.integers(0, rows, 200), rng.integers(0, cols, 200)):
        x, y = (col + 0.5) / cols * size_x - size_x / 2, size_y / 2 - (row + 0.5) / rows * size_y
        colour = list(relief.COLOURS.values())[int(task.world.class_at(x, y))]
        whole = 0.8 * np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) + 38
        light = (pixels[row, col] / whole)[pixels[row, col] < 255]
        assert not light.size or np.ptp(light) < 0.03, "shade leaves the hue"
    # A dome is bright where it faces the light.
    n = np.linspace(-1, 1, 33)
    dome = 8 * np.exp(-2 * (n[:, None] ** 2 + n[None] ** 2))
    world = dataclasses.replace(
        task.world,
        heights=dome,
        classes=np.zeros((4, 4), np.uint8),
        friction=np.ones((4, 4)),
        patch=8.0,
        resolution=1.0,
    )
    seen = _pixels(relief.png(world)).astype(float).sum(axis=2)
    quarter = len(seen) // 4
    assert seen[quarter, quarter] > 1.3 * seen[-quarter, -quarter], "rows begin in the north, columns in the west"


def test_obstacles_are_where_they_stand(program):
    task = places.read_task(places.suite_folder("smoke"), "w008/t00")
    root = xml.fromstring(vertibench.show_task("smoke", "w008/t00").svg)
    drawn = [e for e in root.iter() if e.tag in (f"{SVG}ellipse", f"{SVG}rect") and "rotate" in e.get("transform", "")]
    assert len(drawn) == len(task.world.obstacles) > 5
    for element, o in zip(drawn, task.world.obstacles):
        u, v, turn = (float(n) for n in re.findall(r"-?[\d.]+", element.get("transform")))
        assert np.allclose([u, v], _on_the_map(task.world, [o.x], [o.y])[0], atol=0.06)
        wide = 2 * float(element.get("rx")) if element.tag.endswith("ellipse") else float(element.get("width"))
        assert wide == pytest.approx(o.size[0] * 520 / max(task.world.size), abs=0.11)
        assert turn == pytest.approx(-np.degrees(o.yaw), abs=0.06)


def test_a_notebook_gets_picture_and_replay(driven, harness, tmp_path):
    run = vertibench.Run(driven / "slow")
    shown = run.show("w001/t00", height=400)
    harness("replay", str(run.path), "--task", "w001/t00", "--out", str(tmp_path / "by-hand.html"))
    assert shown.replay == (tmp_path / "by-hand.html").read_text()
    page = shown._repr_html_()
    (frame,) = re.findall(r"<iframe [^>]*>", page)
    assert html.unescape(re.search(r'srcdoc="([^"]*)"', frame)[1]) == shown.replay
    assert "height:400px" in frame and 'sandbox="allow-scripts"' in frame, "it can't reach the notebook"
    assert page.index("<svg") < page.index("<iframe")
    assert shown._repr_mimebundle_() == {"text/html": page, "text/plain": repr(shown)} and "success after" in repr(
        shown
    )
    assert shown.save(tmp_path / "page.html").read_text().startswith("<!doctype html>")
    assert page in (tmp_path / "page.html").read_text()
    assert shown.save(str(tmp_path / "picture.svg")).read_text() == shown.svg
    with pytest.raises(vertibench.VertibenchError, match="cannot be written"):
        shown.save(tmp_path / "none/page.html")
    assert "<iframe" not in run.show("w001/t00", replay=False)._repr_html_()


def test_several_runs_have_a_colour_each(driven):
    runs = [vertibench.Run(driven / name) for name in ("slow", "fast")]
    shown = vertibench.show(runs, "w003/t01")
    root = xml.fromstring(shown.svg)
    for run, colour, label in zip(runs, picture.RUN_COLOURS, ("pid (speed 3)", "pid (speed 5)")):
        trace, record = run.trace("w003/t01"), run.record("w003/t01")
        (line,) = _titles(root, f"{label}: {record['outcome']}")
        way = _on_the_map(_task(run, "w003/t01").world, trace["x"], trace["y"])
        assert line.get("stroke") == colour and np.allclose(_points(line), way, atol=0.06)
        assert label in repr(shown)
        assert label in shown.replay


def test_a_scaled_world_is_drawn_to_its_scale(program, tmp_path):
    run = vertibench.run(
        "pid.wasm",
        suite="smoke",
        tasks="w001/t00",
        vehicle="verti4wheeler",
        scale="1/6",
        out=tmp_path / "r",
        progress=False,
    )
    svg = run.show("w001/t00", replay=False).svg
    goal = re.search(r"success within ([\d.]+) m of the goal", svg)
    assert float(goal[1]) == pytest.approx(10 / 6, abs=1e-4) and "21.3333 m × 21.3333 m" in svg
    assert vertibench.show_task("smoke", "w001/t00", scale=1 / 6).svg.count("21.3333 m") == 2


def test_texts_are_no_markup(driven, tmp_path):
    shutil.copytree(driven / "slow", tmp_path / "r")
    (tmp_path / "r/checksums.txt").unlink()
    header = json.loads((tmp_path / "r/run.json").read_text())
    header["plugin"]["name"] = '<script>"&'
    (tmp_path / "r/run.json").write_text(json.dumps(header))
    records = vertibench.Run(tmp_path / "r").records()
    records[0]["reason"] = "<img src=x> & so on"
    (tmp_path / "r/tasks.jsonl").write_text("".join(json.dumps(r) + "\n" for r in records))
    page = vertibench.show(tmp_path / "r", "w001/t00", replay=False)._repr_html_()
    assert "<script" not in page and "<img" not in page and "&lt;script&gt;" in page
    xml.fromstring(re.search(r"<svg.*</svg>", page, re.S)[0])
    (tmp_path / "r/tasks.jsonl").write_text(json.dumps(records[0]) + "\n")
    assert vertibench.show(tmp_path / "r", replay=False)._repr_html_() == page, "the only task needs no name"


def test_what_cannot_be_shown_is_told(driven, tmp_path, monkeypatch):
    run = vertibench.Run(driven / "slow")
    other = places.suite_folder("vb-100")
    cases = [
        (
            lambda: vertibench.show_task("none", "w001/t00"),
            "suite none: not a folder or a shipped suite",
        ),
        (
            lambda: vertibench.show_task("smoke", "w099/t00"),
            "there is no task w099/t00 (give one of its 100 tasks, e.g. w001/t00)",
        ),
        (lambda: vertibench.show_task(tmp_path, "w001/t00"), "suite.yaml: cannot be read"),
        (lambda: run.show("w003/t00", suite=other), "its task w003/t00 differs from that of"),
        *((lambda s=s: vertibench.show_task("smoke", "w001/t00", scale=s), "scale is ") for s in (0, -1, float("nan"), "1/6")),
        (lambda: vertibench.show([], "w001/t00"), "no run is given"),
        (lambda: run.show(), "finished tasks (name the task, e.g. show(run, 'w0"),
        (lambda: vertibench.show(tmp_path, "w001/t00"), "run.json is missing"),
    ]
    for do, told in cases:
        with pytest.raises(vertibench.VertibenchError) as caught:
            do()
        assert told in str(caught.value) and "\n" not in str(caught.value), str(caught.value)
    shutil.copytree(places.suite_folder("smoke"), tmp_path / "smoke")
    heights = tmp_path / "smoke/worlds/w001/elevation.png"
    heights.write_bytes(heights.read_bytes()[:-99])
    with pytest.raises(vertibench.RunError, match=r"elevation.png: the image is truncated or damaged.*restore the suite's folder"):
        vertibench.show_task(tmp_path / "smoke", "w001/t00")
    # The program knows the suite by its hash.
    (tmp_path / "smoke/worlds/w003/obstacles.yaml").write_text("obstacles: []\n")
    with pytest.raises(vertibench.InputError):
        run.show("w003/t00", suite=tmp_path / "smoke")


def test_a_suite_that_moved_is_looked_for_by_its_name(driven, tmp_path, monkeypatch):
    shutil.copytree(driven / "slow", tmp_path / "r")
    (tmp_path / "r/checksums.txt").unlink()
    header = json.loads((tmp_path / "r/run.json").read_text())
    header["suite"]["path"] = str(tmp_path / "gone")
    (tmp_path / "r/run.json").write_text(json.dumps(header))
    run = vertibench.Run(tmp_path / "r")
    assert run.show("w001/t00", replay=False).svg == vertibench.Run(driven / "slow").show("w001/t00", replay=False).svg
    monkeypatch.setenv("VB_TASKS", str(tmp_path))
    with pytest.raises(vertibench.RunError, match=r"gone, its folder in .*, is not a suite .*give the folder as suite="):
        run.show("w001/t00")
