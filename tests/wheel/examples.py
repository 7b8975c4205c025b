"""Runs the code blocks of README and docs with the installed package.

Each block of code between fences of `console`, `sh`, `python`, `yaml`, `rust` or `toml` is run or checked; `text` is what programs print,
and isn't, unless a mark names it as a file. The blocks of a page share an empty folder and run in order. Of a `console` block the lines that begin with `$ ` are run, by
bash, and end at the first that fails; what they print isn't compared. Comments on the lines before a block say what is special about it,
in which `then` parts several:

    <!-- example: not run: REASON -->              it can't run here, and why
    <!-- example: first: COMMAND -->               a command of bash that runs before it
    <!-- example: then: COMMAND -->                the same, after it
    <!-- example: with: OLD => NEW -->             a text of it that is replaced before it runs, such as a size that takes hours
    <!-- example: file: NAME -->                   it is the content of this file, which later blocks use
    <!-- example: part of: FILE -->                it is in this file of the repository, which is tested

`python3 tests/wheel/smoke.py` calls it, and `python3 tests/wheel/examples.py --list` prints what is done with each block.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
#: Pages whose blocks are run.
PAGES = ["README.md", *sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs").glob("*.md")), "harness/python/README.md", "sdk/python/README.md"]
LANGUAGES = ("console", "sh", "python", "yaml", "rust", "toml")
#: The longest that a block may take, s.
LONGEST = 300

_BLOCK = re.compile(r"((?:^[ ]*<!-- example: .*? -->\n)*)^([ ]*)```(\w*)\n(.*?)^\2```$", re.MULTILINE | re.DOTALL)
_MARK = re.compile(r"<!-- example: (not run|first|then|with|file|part of): (.*?) -->", re.DOTALL)
_ANY_MARK = re.compile(r"<!-- example:")


@dataclass
class Block:
    """A block of code with its marks."""

    page: str
    line: int
    language: str
    code: str
    marks: list[tuple[str, str]] = field(default_factory=list)

    @property
    def where(self) -> str:
        """Page and line of the block."""
        return f"{self.page}:{self.line}"

    @property
    def is_run(self) -> bool:
        """Whether it is more than what a program prints."""
        return self.language != "text" or bool(self.marks)

    def all(self, kind: str) -> list[str]:
        """What the marks of this kind say."""
        return [value for name, value in self.marks if name == kind]

    def source(self) -> str:
        """The code that runs: commands alone, with what is replaced."""
        code = self.code
        if self.language == "console":
            code = "\n".join(_commands(code))
        for change in self.all("with"):
            old, arrow, new = change.partition(" => ")
            if not arrow or old not in code:
                raise ValueError(f"{self.where}: with: {change!r}: the block doesn't have {old!r}")
            code = code.replace(old, new)
        return code


def _commands(code: str) -> list[str]:
    """The commands of a console: lines after a prompt, and those of a loop that was begun."""
    commands: list[str] = []
    is_open = False
    for line in code.splitlines():
        if is_open or line.startswith("$ "):
            commands.append(line.removeprefix("$ "))
            is_open = commands[-1].endswith("; do") or (is_open and line.strip() != "done")
    return commands


def blocks(page: str) -> list[Block]:
    """The blocks of a page. Raises ValueError for a mark that isn't understood or stands before no block."""
    text = (ROOT / page).read_text(encoding="utf-8")
    found, seen = [], 0
    for match in _BLOCK.finditer(text):
        marks, indent, language, code = match.groups()
        line = text.count("\n", 0, match.start(3)) + 1
        code = "".join(one.removeprefix(indent) for one in code.splitlines(keepends=True))
        block = Block(page, line, language, code, _MARK.findall(marks))
        seen += len(_ANY_MARK.findall(marks))
        if len(block.marks) != len(_ANY_MARK.findall(marks)):
            raise ValueError(f"{block.where}: a mark isn't understood: {marks.strip()}")
        if language not in (*LANGUAGES, "text"):
            raise ValueError(f"{block.where}: a block of {language or 'no language'}: name one of {', '.join(LANGUAGES)} or text")
        found.append(block)
    if seen != len(_ANY_MARK.findall(text)):
        raise ValueError(f"{page}: a mark stands before no block")
    return found


def check(block: Block) -> bool:
    """Whether a block is done with by comparing it; raises ValueError where it differs from its file."""
    for name in block.all("part of"):
        if block.code not in (ROOT / name).read_text(encoding="utf-8"):
            raise ValueError(f"{block.where}: isn't in {name}")
    return bool(block.all("part of"))


def run(block: Block, folder: Path, environment: dict[str, str]) -> None:
    """Runs a block; raises ValueError with what it printed if it fails."""
    shell = ["bash", "-euo", "pipefail", "-c"]
    commands = [[*shell, command] for command in block.all("first")]
    source = block.source()
    if files := block.all("file"):
        (folder / files[0]).parent.mkdir(parents=True, exist_ok=True)
        (folder / files[0]).write_text(source, encoding="utf-8")
    elif block.language in ("console", "sh"):
        commands.append([*shell, source])
    elif block.language == "python":
        commands.append(["python", "-c", source])
    else:
        raise ValueError(f"{block.where}: {block.language} isn't run by itself: mark it with a file, or why it isn't run")
    commands += [[*shell, command] for command in block.all("then")]
    for command in commands:
        done = subprocess.run(
            command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, errors="replace", timeout=LONGEST, check=False,
        )  # fmt: skip
        if done.returncode:
            raise ValueError(f"{block.where}: ended with {done.returncode}:\n{command[-1]}\n{done.stdout[-3000:]}")


def run_pages(folder: Path, environment: dict[str, str], pages: list[str]) -> list[str]:
    """Runs the blocks of pages; gives what failed, a text for each. The folder has a shim for each program that examples name."""
    failures = []
    ran = left = 0
    for page in pages:
        place = folder / page.replace("/", "-").removesuffix(".md")
        place.mkdir()
        # As in a checkout where everything is built.
        for name in ("target", "docs"):
            if (folder / name).exists():
                (place / name).symlink_to(folder / name)
        began = time.monotonic()
        try:
            for block in blocks(page):
                if block.all("not run") or not block.is_run:
                    left += block.is_run
                    continue
                ran += 1
                try:
                    if not check(block):
                        run(block, place, environment)
                except (ValueError, subprocess.TimeoutExpired) as e:
                    failures.append(str(e))
        except ValueError as e:
            failures.append(str(e))
        if (took := time.monotonic() - began) > 1:
            print(f"examples of {page}: {took:.0f} s", flush=True)
    print(f"examples: {ran} blocks run or checked, {left} not run, {len(failures)} failed", flush=True)
    return failures


def prepared(folder: Path, bin: Path, plugins: Path, environment: dict[str, str]) -> dict[str, str]:
    """An environment in which the programs of the examples are those of the package."""
    shims = folder / "bin"
    release = folder / "target/release"
    for place in (shims, release):
        place.mkdir(parents=True, exist_ok=True)
        shim = place / "vb-harness"
        shim.write_text(f'#!/bin/sh\nexec "{bin / "vertibench"}" "$@"\n', encoding="utf-8")
        shim.chmod(0o755)
    (folder / "target/plugins").symlink_to(plugins)
    # No browser is opened.
    return {**environment, "PATH": f"{shims}:{bin}:{os.environ['PATH']}", "BROWSER": "true"}


def main() -> None:
    if "--list" in sys.argv:
        for page in PAGES:
            for block in blocks(page):
                if block.is_run:
                    print(f"{block.where} {block.language}: {'; '.join(': '.join(mark) for mark in block.marks) or 'run'}")


if __name__ == "__main__":
    main()
