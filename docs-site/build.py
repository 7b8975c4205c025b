"""Builds the documentation site from the Markdown pages of the repository, the program's help and Python docstrings.

    python3 -m venv target/site-venv && target/site-venv/bin/pip install -r docs-site/requirements.txt
    target/site-venv/bin/python docs-site/build.py

The site works from the file system, without a network. Broken links and all warnings are errors. `--help` lists the options.
"""

from __future__ import annotations

import argparse
import html
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import unquote

from generator import SiteError, c_reference, cli, codes, python_reference
from generator.pages import Pages

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
PROGRAM = ROOT / "target/release" / ("vb-harness.exe" if os.name == "nt" else "vb-harness")
#: Crates whose documentation is part of the site.
RUST_CRATES = {"vb_sdk", "vb_math"}
#: What a page loads when it is opened, in contrast to what it links to.
_LOADED = re.compile(
    r"<(?:script|img|iframe|source|video|audio|embed)\b[^>]*?\bsrc=[\"']?((?:https?:)?//[^\"'\s>]+)"
    r"|<link\b(?=[^>]*\brel=[\"']?(?:stylesheet|preconnect|preload|icon|manifest))[^>]*?\bhref=[\"']?((?:https?:)?//[^\"'\s>]+)"
)


def write_commands(program: Path | None, pages: Pages) -> str:
    """Writes the pages of the command line, and returns their lines of the navigation."""
    indent = " " * 10
    if program is None:
        text = (
            "# Command line\n\nThis copy of the documentation was built without the reference of the command line, which comes from the "
            "program. `vb-harness --help` and `vb-harness COMMAND --help` list commands and options.\n"
        )
        pages.write("cli/index.md", text)
        return f"{indent}- cli/index.md"
    if not program.is_file():
        raise SiteError(
            f"{program}: no such file; build it with `cargo build --release -p vb-harness`, name another with --program, or leave out the "
            "command line with --without-cli"
        )
    found = cli.commands(program)
    places = {c.path: cli.place(c, any(one.path[:-1] == c.path for one in found if one.path)) for c in found}
    for command in found:
        pages.write(places[command.path], cli.page(command, found, places, pages.sources))
    listed, known = codes.exit_codes(ROOT), set(found[0].exit_codes())
    if listed != known:
        differ = ", ".join(map(str, sorted(listed ^ known)))
        raise SiteError(f"docs/results.md: the table of exit codes and {program} differ in {differ}; rebuild the program or correct the table")
    return cli.navigation(found, places, indent)


def made_rustdoc(root: Path) -> Path | None:
    """Folder into which `cargo doc` has written the documentation of the SDK, if there is one."""
    folder = root / "target/doc"
    return folder if (folder / "vb_sdk/index.html").is_file() else None


def rust_page(is_included: bool) -> str:
    """The page that leads to the documentation of the Rust SDK, or says how to make it."""
    lines = ["# Rust reference", ""]
    if is_included:
        lines += ["[`vb_sdk`](rust/vb_sdk/index.html), the SDK for planners: the interface, and modules for paths, maps, search, sampling and networks."]
    else:
        lines += [
            "This copy of the documentation was built without the reference of the Rust SDK, which `cargo doc` makes. In a planner's project, "
            "`cargo doc --package vb-sdk --open` shows it.",
        ]
    lines += ["", "[Writing a planner](writing-a-planner.md) is the tutorial, [the planner interface](abi.md) the reference of the data."]
    return "\n".join(lines) + "\n"


def copy_rustdoc(folder: Path, out: Path) -> None:
    """Copies the documentation of the SDK out of a folder of `cargo doc`, which may have other crates, too."""
    if not (folder / "vb_sdk/index.html").is_file():
        raise SiteError(f"{folder}: no documentation of the SDK is here; make it with `cargo doc --release --package vb-sdk --no-deps`, or leave out --rustdoc")
    crates = {p.name for p in folder.iterdir() if (p / "all.html").is_file()} - RUST_CRATES

    def left_out(place: str, names: list[str]) -> set[str]:
        is_top = Path(place) in (folder, folder / "src")
        return {name for name in names if name.startswith(".") or (is_top and name in crates)}

    shutil.copytree(folder, out, ignore=left_out)
    # Licences of fonts, which MkDocs would take for pages.
    for file in out.rglob("*.md"):
        file.rename(file.with_suffix(".txt"))


def leaderboard_page(board: Path | None) -> str:
    """The page of the leaderboard of the reference planners, which is in a folder (`cargo xtask leaderboard`) or missing."""
    lines = ["# Leaderboard", ""]
    if board is None:
        lines += [
            "This copy of the documentation was built without the leaderboard of the reference planners, which needs their runs: "
            "`cargo xtask results vb-100-hmmwv`, then `cargo xtask leaderboard`, both in a checkout.",
        ]
    else:
        try:
            boards = json.loads((board / "leaderboard.json").read_text(encoding="utf-8"))["boards"]
        except OSError as e:
            raise SiteError(f"{board}: no leaderboard is here ({e.strerror}); make one with `cargo xtask leaderboard`, or leave out --leaderboard") from None
        lines += ["The paper's planners, submitted and verified like those of entrants (`cargo xtask leaderboard`)."]
        for one in boards:
            lines += ["", f"## {one['suite']['name']}, {one['vehicle']['name']}", "", "| rank | planner | success, % (95 %) | mean time, s |", "|---|---|---|---|"]
            for entry in one["entries"]:
                tie, rate, time = "=" if entry["tied"] else "", entry["success_rate"], entry["time_s"]
                percent = "{:.1f} ({:.1f}–{:.1f})".format(*(100 * rate[k] for k in ("mean", "low", "high")))
                seconds = "–" if time is None else f"{time['mean']:.1f}"
                lines.append(f"| {entry['rank']}{tie} | [{entry['planner']}](board/{entry['page']}) | {percent} | {seconds} |")
        lines += ["", "`=`: a tie, the difference is not significant. [All figures, maps and records](board/index.html)."]
    lines += ["", "[Results](benchmark-results.md) has the planners by terrain and cause of failure, [entering a leaderboard](leaderboard.md) the steps for your planner."]
    return "\n".join(lines) + "\n"


def prepare(folder: Path, program: Path | None, board: Path | None, rustdoc: Path | None) -> Path:
    """Writes the pages and the settings for MkDocs into a folder, and returns the settings' file."""
    docs = folder / "pages"
    pages = Pages(ROOT, docs)
    missing = [source for source, page in pages.sources.items() if f" {page}\n" not in (HERE / "mkdocs.yml").read_text(encoding="utf-8")]
    if missing:
        raise SiteError(*(f"{source}: not in the navigation of docs-site/mkdocs.yml" for source in missing))
    shutil.copytree(HERE / "assets", docs / "assets")
    commands = write_commands(program, pages)
    pages.write(codes.PAGE, codes.page(ROOT, pages))
    for page, text in python_reference.pages(ROOT).items():
        place = docs / page
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")
    pages.write(c_reference.PAGE, c_reference.page(ROOT, pages.sources))
    pages.write("rust-reference.md", rust_page(rustdoc is not None))
    if rustdoc is not None:
        copy_rustdoc(rustdoc, docs / "rust")
    pages.write_all()
    (docs / "leaderboard-of-planners.md").write_text(leaderboard_page(board), encoding="utf-8")
    if board is not None:
        shutil.copytree(board, docs / "board")
    settings = (HERE / "mkdocs.yml").read_text(encoding="utf-8")
    settings = re.sub(r'"@root(/[^"]*)"', lambda match: json.dumps(f"{ROOT.as_posix()}{match[1]}"), settings)
    settings = re.sub(r'^ *- "@commands"$', lambda _: commands, settings, flags=re.MULTILINE)
    file = folder / "mkdocs.yml"
    file.write_text(settings, encoding="utf-8")
    return file


def check_out(out: Path) -> None:
    """Refuses a folder with files that are no earlier site, because MkDocs empties it."""
    if out.exists() and not out.is_dir():
        raise SiteError(f"{out}: not a folder")
    if out.is_dir() and any(out.iterdir()) and not (out / "search/search_index.js").is_file():
        raise SiteError(f"{out}: has files that are no earlier site; name an empty folder with --out")


def run_mkdocs(settings: Path, out: Path) -> None:
    """Runs MkDocs; its warnings are errors."""
    if missing := [name for name in ("mkdocs", "material", "mkdocstrings_handlers") if find_spec(name) is None]:
        raise SiteError(f"Python packages are missing ({', '.join(missing)}); install them with `pip install -r docs-site/requirements.txt`")
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "true"}
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--config-file", str(settings), "--site-dir", str(out)]
    # Not with --quiet, which also keeps warnings from being counted.
    done = subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8", check=False)
    print("".join(line for line in done.stdout.splitlines(keepends=True) if not line.startswith("INFO")), end="", file=sys.stderr)
    if done.returncode:
        raise SiteError("MkDocs found errors, see above")


def check_site(out: Path) -> int:
    """Returns the number of pages. Raises SiteError if a link of the site is broken, if a page loads something from the network, or if the
    search is missing."""
    texts = {p: p.read_text(encoding="utf-8") for p in sorted(out.rglob("*.html"))}
    # Other files with this ending are copies of sources.
    texts = {p: text for p, text in texts.items() if "data-md-component" in text}
    names = {p: {html.unescape(name) for name in re.findall(r"\b(?:id|name)=\"?([^\s\">]+)", text)} for p, text in texts.items()}
    problems = []
    for page, text in texts.items():
        where = page.relative_to(out)
        problems += [f"{where}: loads {match[1] or match[2]}" for match in _LOADED.finditer(text)]
        for link in sorted({html.unescape(link) for link in re.findall(r"\b(?:href|src)=\"([^\"]*)\"", text)}):
            path, _, anchor = link.partition("#")
            # The page for missing files has absolute links, which only a server uses.
            if re.match(r"[a-z]+:", link) or page.name == "404.html":
                continue
            there = Path(os.path.normpath(page.parent / unquote(path))) if path else page
            there = there / "index.html" if there.is_dir() else there
            if not there.is_file():
                problems.append(f"{where}: broken link {link!r}: no such file in the site")
            elif anchor and there in names and unquote(anchor) not in names[there]:
                problems.append(f"{where}: broken link {link!r}: no such anchor")
    if not (out / "search/search_index.js").is_file():
        problems.append("search/search_index.js: missing")
    if problems:
        raise SiteError(*problems)
    return len(texts)


def build(out: Path, program: Path | None, board: Path | None, rustdoc: Path | None) -> int:
    """Builds the site into a folder, and returns the number of pages."""
    check_out(out)
    with tempfile.TemporaryDirectory() as folder:
        run_mkdocs(prepare(Path(folder), program, board, rustdoc), out)
    if program is None:
        print("the pages of the command line are left out (--without-cli)", file=sys.stderr)
    if rustdoc is None:
        print("the reference of the Rust SDK is left out: target/doc/vb_sdk is missing", file=sys.stderr)
    if board is None:
        print("the leaderboard is left out: target/leaderboard is missing", file=sys.stderr)
    return check_site(out)


def main() -> int:
    """Runs the command line and returns the exit code."""
    parser = argparse.ArgumentParser(description="Builds the documentation site. Broken links and warnings are errors.")
    parser.add_argument("--out", type=Path, default=ROOT / "target/site", metavar="DIR", help="folder for the site; default: target/site")
    parser.add_argument("--check", action="store_true", help="build into a temporary folder, which is removed")
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        "--program", type=Path, default=PROGRAM, metavar="FILE",
        help="program whose command line is documented; default: target/release/vb-harness",
    )  # fmt: skip
    which.add_argument("--without-cli", action="store_true", help="leave out the pages of the command line, which need the program")
    parser.add_argument(
        "--leaderboard", type=Path, metavar="DIR",
        help="leaderboard to include, from cargo xtask leaderboard; default: target/leaderboard if it exists",
    )  # fmt: skip
    parser.add_argument(
        "--rustdoc", type=Path, metavar="DIR",
        help="folder of cargo doc with the SDK's documentation; default: target/doc if it has vb_sdk",
    )  # fmt: skip
    arguments = parser.parse_args()
    program = None if arguments.without_cli else arguments.program.absolute()
    made = ROOT / "target/leaderboard"
    board = arguments.leaderboard.absolute() if arguments.leaderboard else made if made.is_dir() else None
    rustdoc = arguments.rustdoc.absolute() if arguments.rustdoc else made_rustdoc(ROOT)
    try:
        if arguments.check:
            with tempfile.TemporaryDirectory() as folder:
                pages = build(Path(folder), program, board, rustdoc)
            print(f"{pages} pages, no broken links, no warnings")
        else:
            out = arguments.out.absolute()
            pages = build(out, program, board, rustdoc)
            print(f"{pages} pages in {out}; open {out / 'index.html'}")
    except SiteError as e:
        for problem in e.problems:
            print(f"error: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
