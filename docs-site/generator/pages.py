"""Pages of the site from files of the repository: paths, links, and copies of linked sources."""

from __future__ import annotations

import json
import os
import posixpath
import re
import shutil
import subprocess
from pathlib import Path
from urllib.parse import quote, unquote

from . import SiteError, markdown

#: Pages outside of `docs`, by their path in the repository, with their path on the site.
PAGES = {
    "README.md": "index.md",
    "harness/python/README.md": "python-first-run.md",
    "sdk/python/README.md": "python-planners.md",
    "CONTRIBUTING.md": "project/contributing.md",
    "ARCHITECTURE.md": "project/architecture.md",
    "STYLE.md": "project/style.md",
    "SECURITY.md": "project/security.md",
    "CODE_OF_CONDUCT.md": "project/code-of-conduct.md",
    "CHANGELOG.md": "project/changelog.md",
    "tasks/LICENSES.md": "project/data-licences.md",
    "examples/notebook/tutorial.ipynb": "notebook.md",
}
#: Maximum size of a file that gets a page, bytes.
SMALL = 128 * 1024
PICTURES = {".gif", ".jpg", ".jpeg", ".png", ".svg", ".webp"}
#: Names of lexers for code blocks, by ending.
LEXERS = {
    ".c": "c", ".cff": "yaml", ".cpp": "cpp", ".css": "css", ".csv": "text", ".h": "c", ".html": "html", ".js": "js", ".json": "json", ".md": "markdown",
    ".py": "python", ".rs": "rust", ".sh": "sh", ".toml": "toml", ".yaml": "yaml", ".yml": "yaml",
}  # fmt: skip
_EXTERNAL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:")


class Pages:
    """Writes pages into a folder for MkDocs, together with the files of the repository that they link to.

    Args:
        root: Root of the repository.
        out: Folder for the pages.
    """

    def __init__(self, root: Path, out: Path) -> None:
        self._root = root
        self._out = out
        self._pages = {**PAGES, **{f"docs/{p.name}": p.name for p in sorted((root / "docs").glob("*.md"))}}
        self._tracked = _tracked(root)
        self._anchors: dict[str, dict[str, str]] = {}
        #: Linked files and folders of the repository, with their place on the site; `True` once it is written.
        self._files: dict[str, bool] = {}
        self._problems: list[str] = []

    @property
    def sources(self) -> dict[str, str]:
        """Path on the site of each page, by its path in the repository."""
        return self._pages

    def write_all(self) -> None:
        """Writes all pages and what they link to. Raises SiteError with all broken links."""
        for source, page in self._pages.items():
            text = (self._root / source).read_text(encoding="utf-8")
            if source.endswith(".ipynb"):
                heading, _, rest = self.linked(_notebook(text), source, page).partition("\n")
                copy = _place(source)
                shutil.copyfile(self._root / source, _made(self._out / copy))
                text = f"{heading}\n\nThis page shows the notebook [{posixpath.basename(source)}]({copy}) without its outputs.\n{rest}"
            else:
                text = self.linked(text, source, page)
            if page == "index.md":
                # It is no part of a group, so it needs no list of pages beside it.
                text = f"---\nhide: [navigation]\n---\n\n{text}"
            self.write(page, text)
        while waiting := [path for path, is_written in self._files.items() if not is_written]:
            for path in waiting:
                self._files[path] = True
                self._write_copy(path)
        if self._problems:
            raise SiteError(*self._problems)

    def write(self, page: str, text: str) -> None:
        """Writes a page that is Markdown as GitHub reads it; its links are links of the site."""
        _made(self._out / page).write_text(markdown.for_mkdocs(text), encoding="utf-8")

    def linked(self, text: str, source: str, page: str, first_line: int = 1) -> str:
        """Text of the repository's file `source`, or of a part of it, with the links that it needs on the page `page`.

        Broken links are kept for the error of `write_all`.
        """
        changes = []
        for link in markdown.links(text):
            try:
                changes.append((link, self._target(link.target, source, page)))
            except LookupError as e:
                self._problems.append(f"{source}:{link.line + first_line - 1}: broken link {link.target!r}: {e.args[0]}")
        return markdown.replaced(text, changes)

    def _target(self, target: str, source: str, page: str) -> str:
        if _EXTERNAL.match(target):
            return target
        path, _, anchor = target.partition("#")
        if path.startswith("/"):
            raise LookupError("absolute path; write it relative to the page")
        full = posixpath.normpath(posixpath.join(posixpath.dirname(source), unquote(path))) if path else source
        if full.startswith(".."):
            raise LookupError("outside of the repository")
        if full not in self._tracked and full not in self._pages:
            raise LookupError("no such file")
        # On GitHub, the page of a folder shows the README in it.
        if f"{full}/README.md" in self._pages:
            full = f"{full}/README.md"
        if anchor and full.endswith(".md"):
            known = self._anchors_of(full)
            if anchor not in known:
                raise LookupError(f"no heading of {full} has this anchor")
            anchor = known[anchor]
        elif anchor and not re.fullmatch(r"L\d+(-L\d+)?", anchor):
            raise LookupError("an anchor of a file without headings")
        elif anchor:
            anchor = ""
        there = self._pages.get(full) or self._copy(full)
        if there == page and anchor:
            return f"#{anchor}"
        there = quote(posixpath.relpath(there, posixpath.dirname(page) or "."))
        return f"{there}#{anchor}" if anchor else there

    def _anchors_of(self, path: str) -> dict[str, str]:
        if path not in self._anchors:
            self._anchors[path] = markdown.anchors((self._root / path).read_text(encoding="utf-8"))
        return self._anchors[path]

    def _copy(self, path: str) -> str:
        """Place on the site of a file or folder of the repository, which will be copied."""
        folder, _, name = path.rpartition("/")
        if name == "README.md" and folder:
            path = folder
        self._files.setdefault(path, False)
        place = _place(path)
        if (self._root / path).is_dir():
            return f"{place}/index.md"
        return f"{place}.md" if self._has_page(path) else place

    def _has_page(self, path: str) -> bool:
        """Whether a file gets a page with its text: a small text file that is no picture."""
        file = self._root / path
        if file.suffix in PICTURES or file.stat().st_size > SMALL:
            return False
        try:
            return "\0" not in file.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            return False

    def _write_copy(self, path: str) -> None:
        file, place = self._root / path, _place(path)
        if file.is_dir():
            self._write_folder(path)
            return
        target = _made(self._out / place)
        if file.suffix != ".md":
            shutil.copyfile(file, target)
        if self._has_page(path):
            text = file.read_text(encoding="utf-8")
            fence = "`" * max([3, *(len(run) + 1 for run in re.findall(r"`{3,}", text))])
            raw = f" [Plain file]({quote(target.name)})." if file.suffix != ".md" else ""
            about = f"`{path}` of the repository.{raw}"
            code = f"{fence}{LEXERS.get(file.suffix, 'text')}\n{text.rstrip()}\n{fence}\n"
            self.write(f"{place}.md", f"{_OF_CODE}# {markdown.escaped(file.name)}\n\n{about}\n\n{code}")

    def _write_folder(self, path: str) -> None:
        page = f"{_place(path)}/index.md"
        readme = f"{path}/README.md"
        inside = sorted(one[len(path) + 1 :] for one in self._tracked if one.startswith(f"{path}/") and "/" not in one[len(path) + 1 :])
        rows = []
        for name in inside:
            one = f"{path}/{name}"
            if one == readme or (self._root / one).is_symlink():
                continue
            is_folder = (self._root / one).is_dir()
            size = "" if is_folder else f"{max(1, round((self._root / one).stat().st_size / 1000))} kB"
            label = markdown.escaped(name + "/" * is_folder)
            if is_folder or self._has_page(one):
                label = f"[{label}]({quote(posixpath.relpath(self._copy(one), posixpath.dirname(page)))})"
            rows.append([label, size])
        text = f"# {markdown.escaped(path)}\n"
        if readme in self._tracked:
            text = self.linked((self._root / readme).read_text(encoding="utf-8"), readme, page)
        self.write(page, f"{_UNSEARCHED}{text}\n## Files\n\n`{path}` of the repository.\n\n{markdown.table(['file', 'size'], rows)}")


#: Copies of files are not searched. Those of code need the width of the window.
_UNSEARCHED = "---\nsearch: {exclude: true}\n---\n\n"
_OF_CODE = "---\nsearch: {exclude: true}\nhide: [navigation, toc]\n---\n\n"


def _place(path: str) -> str:
    """Place of a copied file. MkDocs ignores names with a leading dot."""
    return "files/" + "/".join(re.sub(r"^\.", "dot.", part) for part in path.split("/"))


def _made(file: Path) -> Path:
    """The file, after its folder is made."""
    file.parent.mkdir(parents=True, exist_ok=True)
    return file


def _tracked(root: Path) -> set[str]:
    """Files of the repository, and the folders that contain them: those that Git knows, or all without Git."""
    done = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"], cwd=root, capture_output=True, check=False
    )  # fmt: skip
    if done.returncode == 0:
        files = [name for name in os.fsdecode(done.stdout).split("\0") if name and (root / name).exists()]
    else:
        left_out = {"target", "node_modules", "runs", "__pycache__", ".git"}
        files = []
        for folder, folders, names in os.walk(root):
            folders[:] = [name for name in folders if name not in left_out]
            files += [Path(folder, name).relative_to(root).as_posix() for name in names]
    found = set(files)
    for file in files:
        while (file := posixpath.dirname(file)) and file not in found:
            found.add(file)
    return found


def _notebook(text: str) -> str:
    """A notebook as a page: its text and code, without outputs."""
    parts = []
    for cell in json.loads(text)["cells"]:
        source = "".join(cell["source"]).rstrip()
        parts.append(source if cell["cell_type"] == "markdown" else f"```python\n{source}\n```")
    return "\n\n".join(parts) + "\n"
