"""The licences of what is linked into the program and the module."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

_PACKAGES = ("vb-harness", "vb-python")
_NAMES = ("licen", "copying", "notice", "unlicense")
# Of what our own crates contain and others made.
_OTHERS = {"the font Liberation Sans": "harness/figure/fonts/LICENSE"}


def text(root: Path) -> str:
    """All of them, each once, with the crates that it is of; and all crates, with their terms in a word."""
    told = subprocess.run(
        ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", _host(root)],
        cwd=root, stdout=subprocess.PIPE, text=True, check=False,
    )  # fmt: skip
    if told.returncode != 0:
        raise SystemExit(f"error: `cargo metadata` failed in {root} (what it says above is the reason)")
    metadata = json.loads(told.stdout)
    of: dict[str, list[str]] = {}
    listed = []
    for package in _linked(metadata):
        name = f"{package['name']} {package['version']}"
        listed.append(f"{name}: {package['license'] or 'see its licence below'}")
        for file in sorted(Path(package["manifest_path"]).parent.iterdir()):
            if file.is_file() and file.name.lower().startswith(_NAMES):
                terms = file.read_text(encoding="utf-8", errors="replace").replace("\r\n", "\n").strip()
                of.setdefault(terms, []).append(name)
    for what, file in _OTHERS.items():
        of.setdefault((root / file).read_text(encoding="utf-8").strip(), []).append(what)
    parts = ["This package contains code of the following crates.\n\n" + "\n".join(listed)]
    parts += [", ".join(names) + "\n\n" + terms for terms, names in sorted(of.items(), key=lambda item: item[1])]
    return f"\n\n{'-' * 80}\n\n".join(parts) + "\n"


def _host(root: Path) -> str:
    """The platform that Rust builds for by itself; another with the same system has the same crates, but for a few."""
    told = subprocess.run(["rustc", "-vV"], cwd=root, stdout=subprocess.PIPE, text=True, check=False).stdout
    found = [line.removeprefix("host: ") for line in told.splitlines() if line.startswith("host: ")]
    if not found:
        raise SystemExit("error: `rustc -vV` doesn't name its host (install Rust from https://rustup.rs)")
    return found[0]


def _linked(metadata: dict) -> list[dict]:
    """The foreign packages that ours depend on to run, by name."""
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    open_ = [id_ for id_, package in packages.items() if package["name"] in _PACKAGES and not package["source"]]
    seen = set(open_)
    while open_:
        for dependency in nodes[open_.pop()]["deps"]:
            runs = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            if runs and dependency["pkg"] not in seen:
                seen.add(dependency["pkg"])
                open_.append(dependency["pkg"])
    foreign = [packages[id_] for id_ in seen if packages[id_]["source"]]
    return sorted(foreign, key=lambda package: (package["name"], package["version"]))
