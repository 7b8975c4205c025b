"""Readers and writers of YAML and PNG files."""

import io
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
import yaml

import vertibench
from vertibench import _image, _yaml

def test_yaml_of_all_forms_that_suites_have():
    text = """
# A comment.
schema: 1
name: "quoted: \\"#1\\""   # another
words: two of them
empty:
range: [0.0, -1.5e-3, .5]
grid: {rows: 129, "key": [1, {a: b}], on: true}
worlds:
  - id: w001
    tasks: [t00,
      t01]   # over two lines

  - {id: w002, none: null}
  -
    id: w003
same:
- 'it''s'
- -3
"""
    assert _yaml.parse(text) == {
        "schema": 1,
        "name": 'quoted: "#1"',
        "words": "two of them",
        "empty": None,
        "range": [0.0, -0.0015, 0.5],
        "grid": {"rows": 129, "key": [1, {"a": "b"}], "on": True},
        "worlds": [{"id": "w001", "tasks": ["t00", "t01"]}, {"id": "w002", "none": None}, {"id": "w003"}],
        "same": ["it's", -3],
    }


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *((text, text) for text in ("on", "off", "yes", "no", "y", "n", "1_000", "12:30", "2024-01-01", "0b1", "<<", "=", ".")),
        *(("010", 10), ("-08", -8), ("+5", 5), ("0o17", 15), ("0x1F", 31), ("1e3", 1000.0), ("-1.5E+2", -150.0), ("1.", 1.0)),
        *((".5", 0.5), ("-.inf", -np.inf), ("True", True), ("FALSE", False), ("~", None), ("Null", None), ("", None), ("'1'", "1")),
    ],
)
def test_types_are_those_of_yaml_1_2(text, value):
    # An int and a float are equal in Python, but not in the types of fields.
    read = _yaml.parse(f"a: {text}")["a"]
    assert read == value and type(read) is type(value)


@pytest.mark.parametrize(
    ("text", "line", "what"),
    [
        ("a: 1\na: 2", 2, "duplicate field a"),
        ("a: {b: 1, b: 2}", 1, "duplicate field b"),
        ("a: [1\nb: 2", 2, "did not find expected"),
        ("a: 1\n   b: 2", 2, "mapping values are not allowed"),
        ("a: 1\nb: *x", 2, "found undefined alias"),
        ("a: 1\nb: &x [1]\nc: [*x, *x]", 2, "aliases"),
        ("a: &x [*x]", 1, "aliases"),
        ("a: 1\n---\na: 2", 2, "expected a single document"),
        ("a: 1\nb: \x07", 2, "control characters"),
        ("a: 1\n[b]: 1", 2, "unhashable key"),
        ("a: 1\nb: !!python/object/apply:os.getcwd []", 2, "could not determine a constructor"),
        ("a: !mine 1", 1, "could not determine a constructor"),
        ("a: !!map 1", 1, "expected a mapping"),
        ("a: !!bool 5", 1, "invalid value"),
        ("a: !!timestamp x", 1, "invalid value"),
        ("a: " + "9" * 9999, 1, "invalid value"),
        ("[" * 99999, 1, "nesting depth"),
        ("- " * 99999, 1, "nesting depth"),
    ],
)
def test_invalid_yaml_is_refused_with_its_line(text, line, what):
    with pytest.raises(ValueError, match=f"^line {line}: .*{what}"):
        _yaml.parse(text)


def test_without_libyaml_the_same_is_read_and_refused(monkeypatch):
    monkeypatch.delattr(yaml, "CSafeLoader", raising=False)
    monkeypatch.setattr(_yaml, "_loader", _yaml._loader.__wrapped__)
    assert _yaml.parse("a: on\nb: [010, {c: 1e3}]") == {"a": "on", "b": [10, {"c": 1000.0}]}
    for text, what in [("a: 1\na: 2", "line 2: duplicate"), ("a: &x [*x]", "line 1: aliases"), ("[" * 99999, "nested too deeply")]:
        with pytest.raises(ValueError, match=what):
            _yaml.parse(text)


def test_a_yaml_file_is_read_up_to_its_limit(tmp_path, monkeypatch):
    file = tmp_path / "a.yaml"
    file.write_text("a: ü", encoding="utf-8")
    assert _yaml.read(file) == {"a": "ü"}
    file.write_bytes(b"a: \xff")
    with pytest.raises(ValueError, match="utf-8"):
        _yaml.read(file)
    monkeypatch.setattr(_yaml, "LIMIT", 3)
    with pytest.raises(ValueError, match="it is larger than"):
        _yaml.read(file)
    with pytest.raises(FileNotFoundError):
        _yaml.read(tmp_path / "none")


def test_suites_are_read_as_by_any_reader_of_yaml(explored):
    files = list((explored / "suite").rglob("*.yaml"))
    assert len(files) > 10
    for file in files:
        assert _yaml.read(file) == yaml.safe_load(file.read_text()), file


def _png(levels, kind=np.uint16):
    file = io.BytesIO()
    PIL.Image.fromarray(levels.astype(kind)).save(file, "PNG")
    return file.getvalue()


def test_an_image_is_written_and_read_exactly():
    levels = np.random.default_rng(3).integers(0, 65536, (9, 13))
    read = _image.read_grey16(_png(levels), 9, 13)
    assert np.array_equal(read, levels) and read.dtype == np.uint16
    rgb = np.random.default_rng(3).integers(0, 256, (9, 13, 3)).astype(np.uint8)
    with PIL.Image.open(io.BytesIO(_image.encode_png(rgb))) as image:
        assert image.format == "PNG" and np.array_equal(np.asarray(image), rgb)


def test_damaged_and_other_images_are_refused():
    levels = np.random.default_rng(3).integers(0, 65536, (3, 4))
    whole = _png(levels)
    cases = {"no PNG": b"GIF89a", "truncated": whole[:-12], "no 16-bit greyscale": _png(levels, np.uint8)}
    for what, data in cases.items():
        with pytest.raises(ValueError, match=what):
            _image.read_grey16(data, 3, 4)
    with pytest.raises(ValueError, match="3 x 4 pixels, world.yaml has 4 x 3"):
        _image.read_grey16(whole, 4, 3)
    # Wherever a byte is changed or the file ends: an error, or the same levels.
    for k in range(len(whole)):
        for data in (whole[:k] + bytes([whole[k] ^ 0x41]) + whole[k + 1 :], whole[:k]):
            try:
                assert np.array_equal(_image.read_grey16(data, 3, 4), levels), k
            except ValueError:
                pass


def test_missing_packages_are_named_when_they_are_needed(monkeypatch):
    folder = vertibench.tasks_path() / "smoke/worlds/w001"
    for package, module in (("pyyaml", "yaml"), ("pillow", "PIL.Image")):
        with monkeypatch.context() as patch:
            patch.setattr(_yaml, "_loader", _yaml._loader.__wrapped__)
            patch.setitem(sys.modules, module, None)
            with pytest.raises(vertibench.MissingPackageError, match=rf"pip install {package}\)$"):
                vertibench.datasets._world.read_world(folder, 1.0)


def test_only_what_is_used_is_imported():
    code = "import sys, vertibench, vertibench.datasets; sys.exit(any(m in sys.modules for m in ('yaml', 'PIL', 'gymnasium')))"
    path = os.pathsep.join([str(Path(vertibench.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": path}, check=True)
