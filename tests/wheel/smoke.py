"""Installs the wheel in a fresh virtual environment and tests it without Rust and without a checkout.

`cargo xtask wheel --check` runs it; it can also be run with `python3 tests/wheel/smoke.py target/wheels/verti_bench-*.whl`. It needs
Python and pip, which fetches the dependencies. A check is a function with the argument `Installed`, in the list at the end.
"""

from __future__ import annotations

import argparse
import json
import lzma
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import examples


class Installed:
    """The package in a virtual environment, and a folder to work in, far from any checkout."""

    def __init__(self, wheel: Path, folder: Path, python: str, extras: str) -> None:
        self.folder = folder / "work"
        self.folder.mkdir()
        venv = folder / "venv"
        # Debian's Python brings no pip for environments, but the pip that is there can install into them.
        _run([python, "-m", "venv", "--without-pip", str(venv)], os.environ)
        self._pip = [python, "-m", "pip", "--disable-pip-version-check", "--python", str(venv / "bin/python")]
        self.pip("install", "--quiet", f"{wheel}{extras}")
        self.bin = venv / "bin"
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("VB_", "PYTHON", "CARGO"))}
        # No Rust, and no compiled planners of another program.
        self.environment = {**kept, "PATH": f"{self.bin}:/usr/bin:/bin", "XDG_CACHE_HOME": str(folder / "cache")}

    def pip(self, *arguments: str) -> None:
        """Has pip do something in the environment."""
        _run([*self._pip, *arguments], os.environ)

    def run(self, *command: str, code: int = 0) -> str:
        """What a program of the environment prints; it must end with this exit code."""
        return _run([str(self.bin / command[0]), *command[1:]], self.environment, self.folder, code)

    def has(self, module: str) -> bool:
        """Whether another package is there, too."""
        return self.python(f"import importlib.util as u; print(u.find_spec({module!r}) is not None)").strip() == "True"

    def python(self, source: str) -> str:
        """What a piece of Python prints."""
        return self.run("python", "-c", source)


def _run(command: list[str], environment, folder: Path | None = None, code: int = 0) -> str:
    done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != code:
        sys.exit(f"error: {' '.join(command)}: ended with {done.returncode}, not {code}:\n{done.stdout}{done.stderr}")
    # Errors are told there.
    return done.stdout if code == 0 else done.stderr


def versions(package: Installed) -> None:
    """Program, module and package are of one version; Python writes 1.0.0rc1 for Rust's 1.0.0-rc.1."""
    python = package.python("import vertibench; print(vertibench.__version__)").strip()
    metadata = "import importlib.metadata as m; print(m.version('verti-bench'))"
    assert package.python(metadata).strip() == python
    version = package.python("import vertibench._native as n; print(n.version())").strip()
    assert version.replace("-rc.", "rc") == python
    for command in (["vertibench"], ["python", "-m", "vertibench"]):
        told = package.run(*command, "--version")
        assert told.startswith(f"vb-harness {version} "), told


def paths(package: Installed) -> None:
    """Everything lies in the package."""
    told = package.python(
        "from vertibench import *; print(harness_path(), tasks_path(), plugins_path(), plugin_path('pid.wasm'), sep='\\n')"
    )
    root = package.python("import vertibench; print(vertibench.__path__[0])").strip()
    lines = told.splitlines()
    assert len(lines) == 4 and all(line.startswith(f"{root}/_data/") and Path(line).exists() for line in lines), told
    # Messages name the pages of the documentation.
    assert Path(root, "docs/abi.md").is_file()


def kernels(package: Installed) -> None:
    """Kernels for GPUs, if any come with it, are those of its simulator."""
    own = package.python("import vertibench._native as n; print(n.kernel_sources(), end='')").encode()
    folder = Path(package.python("import vertibench; print(vertibench.__path__[0])").strip()) / "_data/kernels"
    files = sorted(folder.glob("*.xz"))
    print("kernels:", ", ".join(file.name for file in files) or "none", flush=True)
    for file in files:
        assert own in lzma.decompress(file.read_bytes()), f"{file.name}: of other sources; `cargo xtask kernel` makes it anew"


def planners(package: Installed) -> None:
    """Every planner that comes with it can be loaded, and an unknown one is told in one line."""
    folder = Path(package.python("import vertibench; print(vertibench.plugins_path())").strip())
    names = sorted(path.name for path in folder.iterdir())
    assert {"pid.wasm", "ibex.wasm", "pursuit.wasm"} <= set(names) and "faulty.wasm" not in names, names
    for name in names:
        told = json.loads(package.run("vertibench", "inspect", "--plugin", name, "--json"))
        assert told["event"] == "plugin", told
    told = package.run("vertibench", "--plugin", "gone.wasm", code=3)
    assert "gone.wasm" in told and "(VB_PLUGINS)" in told and told.count("error:") == 1, told


def ten_tasks(package: Installed) -> None:
    """A planner drives the tasks of a world, and one of them is replayed."""
    run = ["--plugin", "pid.wasm", "--suite", "smoke", "--tasks", "w001", "--out", "run", "--json"]
    events = [json.loads(line) for line in package.run("vertibench", *run).splitlines()]
    records = [event["record"] for event in events if event["event"] == "task"]
    assert len(records) == 10, len(records)
    outcomes = [record["outcome"] for record in records]
    assert outcomes.count("success") >= 5, outcomes
    told = package.run("vertibench", "replay", "run", "--task", "w001/t00", "--out", "replay.html", "--json")
    assert json.loads(told)["exact"] == [True], told
    assert (package.folder / "replay.html").stat().st_size > 100_000


def projects(package: Installed) -> None:
    """Planners are begun without a checkout: a crate whose SDK is in the package, and a planner with NumPy."""
    package.run("vertibench", "plugin", "new", "fox", "--lang", "rust")
    manifest = (package.folder / "fox/Cargo.toml").read_text(encoding="utf-8")
    sdk = Path(re.search(r'vb-sdk = .*path = "([^"]+)"', manifest)[1])
    assert (sdk / "Cargo.toml").is_file() and (sdk / "vb-math/Cargo.toml").is_file(), sdk
    assert "Planner" in package.python("import vertibench_planner; print(vertibench_planner.Planner)")
    package.run("vertibench", "plugin", "new", "hare", "--lang", "numpy")
    told = package.run("vertibench", "run", "python3 hare/planner.py", "--suite", "smoke", "--tasks", "w001/t00", "--out", "hare-run")
    assert "100.0" in told, told


def datasets(package: Installed) -> None:
    """The converter is there; without pyarrow it says what to install."""
    assert "to-minari" in package.run("python", "-m", "vertibench.datasets", "--help")
    told = package.run("python", "-m", "vertibench.datasets", "to-minari", "gone", "a/b-v0", code=3)
    wanted = "no such folder" if package.has("pyarrow") else "pip install pyarrow"
    assert told.startswith("error: gone: ") and wanted in told and told.count("\n") == 1, told


def own_tests(package: Installed) -> None:
    """The tests of the package pass, among them that a policy has the same record in an environment and as a planner, that a cluster makes
    the run of one machine, and that the tutorial runs."""
    if not package.has("pytest"):
        return print("tests: not run, since pytest is not installed (--extras [test])", flush=True)
    tests = str(Path(__file__).parents[2] / "harness/python/tests")
    # Files run in two processes; the tests of a file share what they made.
    split = ["-n", "2", "--dist", "loadfile"]
    told = package.run("python", "-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider", *split, "--rootdir", tests, tests)
    print("tests:", told.splitlines()[-1], flush=True)
    skipped = [line for line in told.splitlines() if line.startswith("SKIPPED")]
    assert all("not installed" in line for line in skipped), skipped


def documents(package: Installed) -> None:
    """The examples of README and docs run, each as it stands there."""
    if not package.has("pytest"):
        return print("documents: not tested, since what they need is not installed (--extras [test])", flush=True)
    folder = package.folder / "examples"
    folder.mkdir()
    plugins = Path(package.python("import vertibench; print(vertibench.plugins_path())").strip())
    environment = examples.prepared(folder, package.bin, plugins, package.environment)
    if failures := examples.run_pages(folder, environment, examples.PAGES):
        sys.exit("\n".join(f"error: {failure}" for failure in failures))


CHECKS = [versions, paths, kernels, planners, ten_tasks, projects, datasets, documents, own_tests]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("wheel", type=Path)
    parser.add_argument("--python", default=sys.executable, help="the Python of the environment")
    parser.add_argument("--extras", default="", help="extras to install, e.g. [datasets]")
    given = parser.parse_args()
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        package = Installed(given.wheel.absolute(), Path(folder), given.python, given.extras)
        for check in CHECKS:
            check(package)
            print(f"{check.__name__}: ok", file=sys.stderr)
    print(f"{given.wheel.name}: works ({time.monotonic() - began:.0f} s)", file=sys.stderr)


if __name__ == "__main__":
    main()
