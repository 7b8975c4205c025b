"""The build backend, but for what maturin does."""

import hashlib
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "harness/python/build_backend"))

from vertibench_build import _release, _sdist, _stage, _wheel  # noqa: E402 - it isn't installed

NEWER = b"\x7fELF..\0GLIBC_2.2.5\0GLIBC_2.34\0rest"
OLDER = b"\x7fELF..\0GLIBC_2.14\0"


def wheel(folder: Path, program: bytes) -> Path:
    """As maturin leaves it, with a module for an old glibc."""
    file = folder / "vertibench-1.0-cp310-abi3-linux_x86_64.whl"
    with zipfile.ZipFile(file, "w") as archive:
        for name, content, mode in (
            ("vertibench-1.0.dist-info/WHEEL", b"Wheel-Version: 1.0\nTag: cp310-abi3-linux_x86_64\n", 0o644),
            ("vertibench-1.0.dist-info/RECORD", b"", 0o644),
            ("vertibench/_native.abi3.so", OLDER, 0o755),
            ("vertibench/_data/bin/vb-harness", program, 0o755),
        ):
            entry = zipfile.ZipInfo(name)
            entry.external_attr = mode << 16
            archive.writestr(entry, content)
    return file


@pytest.mark.parametrize(
    "program, tag", [(NEWER, "manylinux_2_34"), (OLDER, "manylinux_2_17"), (b"#!", "manylinux_2_17")]
)
def test_the_tag_is_that_of_the_file_that_needs_most(tmp_path, program, tag):
    out = tmp_path / "out"
    out.mkdir()
    name = _wheel.finish(wheel(tmp_path, program), out)
    assert name == f"vertibench-1.0-cp310-abi3-{tag}_x86_64.whl"
    with zipfile.ZipFile(out / name) as archive:
        assert (
            archive.read("vertibench-1.0.dist-info/WHEEL").decode().splitlines()[-1] == f"Tag: cp310-abi3-{tag}_x86_64"
        )
        record = archive.read("vertibench-1.0.dist-info/RECORD").decode().splitlines()
        assert len(record) == len(archive.namelist()) and record[-1] == "vertibench-1.0.dist-info/RECORD,,"
        assert archive.getinfo("vertibench/_data/bin/vb-harness").external_attr >> 16 == 0o755


def test_the_same_content_gives_the_same_bytes(tmp_path, monkeypatch):
    written = []
    for time in ("0", "0", "1700000000"):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", time)
        name = _wheel.finish(wheel(tmp_path, NEWER), tmp_path)
        written.append((tmp_path / name).read_bytes())
    assert written[0] == written[1] != written[2]


def test_only_versions_of_glibc_count():
    assert _wheel.glibc([NEWER, OLDER]) == 34
    assert _wheel.glibc([b"text with \0GLIBC_2.99\0", b"\x7fELF of musl", b"\x7fELF\0XGLIBC_2.50\0"]) is None


@pytest.mark.parametrize(
    "platform", ["linux_aarch64", "manylinux_2_17_aarch64", "manylinux2014_aarch64.manylinux_2_17_aarch64"]
)
def test_every_tag_of_maturin_for_linux_is_replaced(platform):
    name = f"vertibench-1.0-cp310-abi3-{platform}.whl"
    assert _wheel._tagged(name, 28) == (
        "vertibench-1.0-cp310-abi3-manylinux_2_28_aarch64.whl",
        "manylinux_2_28_aarch64",
    )


def test_other_systems_keep_their_tag():
    for name in ("vertibench-1.0-cp310-abi3-win_amd64.whl", "vertibench-1.0-cp310-abi3-macosx_11_0_arm64.whl"):
        assert _wheel._tagged(name, None)[0] == name
    musl = "vertibench-1.0-cp310-abi3-linux_x86_64.whl"
    assert _wheel._tagged(musl, None)[0] == musl


def test_the_planners_are_those_that_drive():
    names = _stage.planners()
    assert {"pid", "eh", "mppi", "ibex", "expert", "pursuit"} <= set(names)
    assert not {"faulty", "wild", "hybrid", "pursuit-c"} & set(names)


def test_the_description_fits_another_folder():
    text = _stage.pyproject("harness/python/Cargo.toml", "harness/python")
    for line in (
        'manifest-path = "harness/python/Cargo.toml"',
        'python-source = "harness/python"',
        'readme = "harness/python/README.md"',
        'backend-path = ["harness/python/build_backend"]',
    ):
        assert f"\n{line}\n" in text


def test_the_sources_have_the_workspace_and_planners(tmp_path, monkeypatch):
    if not (ROOT / ".git").exists():
        pytest.skip("git: not installed, or no checkout")
    planners = tmp_path / "planners"
    planners.mkdir()
    for name in _stage.planners():
        (planners / f"{name}.wasm").write_bytes(b"")
    monkeypatch.setenv("VB_WHEEL_PLUGINS", str(planners))
    with tarfile.open(tmp_path / _sdist.make(tmp_path, b"Name: vertibench\nVersion: 1.2\n")) as archive:
        names = set(archive.getnames())
    for path in ("Cargo.lock", "harness/cli/Cargo.toml", "tests/Cargo.toml", "pyproject.toml", "PKG-INFO", ".commit"):
        assert f"vertibench-1.2/{path}" in names, path
    assert "vertibench-1.2/harness/python/prebuilt/pid.wasm" in names
    assert not [name for name in names if "/golden/abi-" in name]
    (planners / "pid.wasm").unlink()
    with pytest.raises(SystemExit, match="pid.wasm: the planner isn't there"):
        _sdist.make(tmp_path, b"Version: 1.2\n")


def test_an_archive_of_a_release_has_what_the_program_needs_beside_it(tmp_path, monkeypatch):
    program, planners, shell = tmp_path / "vb-harness", tmp_path / "planners", tmp_path / "shell"
    program.write_bytes(b"#!")
    planners.mkdir()
    for name in _stage.planners():
        (planners / f"{name}.wasm").write_bytes(b"x")
    (shell / "man/man1").mkdir(parents=True)
    (shell / "man/man1/vb-harness.1").write_bytes(b"page")
    monkeypatch.setenv("VB_WHEEL_HARNESS", str(program))
    monkeypatch.setenv("VB_WHEEL_PLUGINS", str(planners))
    monkeypatch.setenv("VB_RELEASE_SHELL", str(shell))
    monkeypatch.setattr(_release._licences, "text", lambda root: "terms")
    monkeypatch.delenv("VB_RELEASE_TARGET", raising=False)
    with pytest.raises(SystemExit, match="VB_RELEASE_TARGET"):
        _release.make(tmp_path)
    monkeypatch.setenv("VB_RELEASE_TARGET", "x86_64-unknown-linux-gnu")
    names = [_release.make(out) for out in (tmp_path / "a", tmp_path / "b") if not out.mkdir()]
    assert len(set(names)) == 1 and names[0].endswith("-x86_64-unknown-linux-gnu.tar.gz")
    first, second = ((tmp_path / out / names[0]).read_bytes() for out in "ab")
    assert first == second
    assert (tmp_path / "a/SHA256SUMS").read_text() == f"{hashlib.sha256(first).hexdigest()}  {names[0]}\n"
    top = names[0].removesuffix(".tar.gz")
    with tarfile.open(tmp_path / "a" / names[0]) as archive:
        assert archive.getmember(f"{top}/vb-harness").mode == 0o755
        for path in ("tasks/smoke/suite.yaml", "plugins/pid.wasm", "man/man1/vb-harness.1", "LICENSE-THIRD-PARTY.txt"):
            assert archive.getmember(f"{top}/{path}").mode == 0o644, path
        assert not any("faulty" in name for name in archive.getnames())
