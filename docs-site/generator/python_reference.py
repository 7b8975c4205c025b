"""Pages of the Python reference: the public names of the packages, which mkdocstrings describes from their docstrings.

The source is parsed, never imported.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass, field
from pathlib import Path

from . import SiteError, markdown

#: Folders of the packages.
PACKAGES = {"vertibench": "harness/python/vertibench", "vertibench_planner": "sdk/python/src/vertibench_planner"}
#: Public modules of each page.
PAGES = {
    "vertibench": ["vertibench"],
    "vertibench.envs": ["vertibench.envs", "vertibench.envs.sb3", "vertibench.envs.puffer"],
    "vertibench.training": ["vertibench.training"],
    "vertibench.datasets": ["vertibench.datasets"],
    "vertibench.gpu": ["vertibench.gpu"],
    "vertibench.scale": ["vertibench.scale", "vertibench.scale.ray", "vertibench.scale.slurm", "vertibench.scale.kubernetes"],
    "vertibench_planner": ["vertibench_planner"],
}
#: Modules without an underscore that are no interface for users: programs, and what the package does at its import.
LEFT_OUT = {"vertibench.envs.bench", "vertibench.registration", "vertibench.scale.cost"}


@dataclass
class Module:
    """Public names of a module.

    Attributes:
        name: The module.
        errors: Exceptions.
        classes: Other classes.
        functions: Functions.
        constants: Constants with their comments.
    """

    name: str
    errors: list[str] = field(default_factory=list)
    classes: list[str] = field(default_factory=list)
    functions: list[str] = field(default_factory=list)
    constants: dict[str, str] = field(default_factory=dict)


def pages(root: Path) -> dict[str, str]:
    """The pages, by their path on the site. Raises SiteError if a public module is on no page."""
    listed = {name for names in PAGES.values() for name in names} | LEFT_OUT
    for package, folder in PACKAGES.items():
        for file in sorted((root / folder).rglob("*.py")):
            parts = [package, *file.relative_to(root / folder).with_suffix("").parts]
            name = ".".join(parts).removesuffix(".__init__")
            if not any(part.startswith("_") for part in name.split(".")) and name not in listed:
                raise SiteError(f"{file.relative_to(root)}: a public module on no page of the reference: add it to `PAGES` or `LEFT_OUT` in {__file__}")
    rows = []
    found = {}
    for page, modules in PAGES.items():
        file = f"python-reference/{page}.md"
        texts = [_text(_module(root, name), is_first=i == 0) for i, name in enumerate(modules)]
        found[file] = "\n".join(texts)
        rows.append([f"[`{page}`]({page}.md)", markdown.escaped(_docstring(root, page).split("\n")[0])])
    found["python-reference/index.md"] = (
        "# Python reference\n\nThe package `vertibench` ([installation](../install.md)) and the package `vertibench_planner` for "
        f"[planners in Python](../python-planners.md).\n\n{markdown.table(['module', 'content'], rows)}"
    )
    return found


def _file(root: Path, module: str) -> Path:
    package, *parts = module.split(".")
    place = Path(root, PACKAGES[package], *parts)
    return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")


def _docstring(root: Path, module: str) -> str:
    return ast.get_docstring(ast.parse(_file(root, module).read_text(encoding="utf-8"))) or ""


def _module(root: Path, name: str) -> Module:
    file = _file(root, name)
    text = file.read_text(encoding="utf-8")
    tree = ast.parse(text)
    module = Module(name)
    for public in _public(tree, file):
        kind = _kind(root, file, tree, public)
        if kind == "constant":
            module.constants[public] = _comment(text.splitlines(), tree, public)
        elif kind == "function":
            module.functions.append(public)
        elif kind == "class":
            (module.errors if public.endswith(("Error", "Warning")) else module.classes).append(public)
    return module


def _public(tree: ast.Module, file: Path) -> list[str]:
    """Names in `__all__`, those of the table of lazily imported names, or public definitions."""
    for node in tree.body:
        if not isinstance(node, ast.Assign) or not isinstance(node.targets[0], ast.Name):
            continue
        if node.targets[0].id == "__all__" and isinstance(node.value, ast.List) and all(isinstance(e, ast.Constant) for e in node.value.elts):
            return list(ast.literal_eval(node.value))
        if node.targets[0].id == "_FROM":
            return [name for names in ast.literal_eval(node.value).values() for name in names]
    if file.name == "__init__.py":
        raise SiteError(f"{file}: neither `__all__` nor `_FROM` has the public names as literals")
    names = [node.name for node in tree.body if isinstance(node, ast.ClassDef | ast.FunctionDef)]
    names += [target.id for node in tree.body for target in _targets(node)]
    return [name for name in names if not name.startswith("_") and name != "main"]


def _targets(node: ast.stmt) -> list[ast.Name]:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    return [target for target in targets if isinstance(target, ast.Name)]


def _kind(root: Path, file: Path, tree: ast.Module, name: str) -> str:
    """Kind of a name, which is defined in the file or imported into it from another file of the package."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and any((alias.asname or alias.name) == name for alias in node.names):
            folder = file.parent
            for _ in range(node.level - 1):
                folder = folder.parent
            place = Path(folder, *(node.module or "").split("."))
            if not node.module:
                return "module"
            there = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
            return _kind(root, there, ast.parse(there.read_text(encoding="utf-8")), name)
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and node.name == name:
            return "class"
        if isinstance(node, ast.FunctionDef) and node.name == name:
            return "function"
        if any(target.id == name for target in _targets(node)):
            return "constant"
    raise SiteError(f"{file.relative_to(root)}: doesn't define {name!r}")


def _comment(lines: list[str], tree: ast.Module, name: str) -> str:
    """Text of the lines with `#:` above a constant."""
    for node in tree.body:
        if any(target.id == name for target in _targets(node)):
            found: list[str] = []
            i = node.lineno - 2
            while i >= 0 and lines[i].startswith("#:"):
                found.insert(0, lines[i][2:].strip())
                i -= 1
            return " ".join(found)
    return ""


def _text(module: Module, is_first: bool) -> str:
    """Page, or part of a page, about a module."""
    level = 1 if is_first else 2
    parts = [
        f"{'#' * level} `{module.name}`",
        f"::: {module.name}\n    options:\n      members: false\n      show_root_heading: false\n      show_root_toc_entry: false",
    ]
    groups = (("Functions", module.functions), ("Classes", module.classes), ("Errors", module.errors))
    for title, names in groups:
        if not names:
            continue
        if is_first:
            parts.append(f"## {title}")
        for name in names:
            parts.append(f"::: {module.name}.{name}\n    options:\n      heading_level: 3")
    if module.constants:
        if is_first:
            parts.append("## Constants")
        for name, comment in module.constants.items():
            parts.append(f"::: {module.name}.{name}\n    options:\n      heading_level: 3")
            if comment:
                parts.append(comment)
    return "\n\n".join(parts) + "\n"
