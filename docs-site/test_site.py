"""Tests of the generator: `python3 docs-site/test_site.py`. They need no packages."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import build
from generator import SiteError, c_reference, cli, markdown, pages, python_reference


class Markdown(unittest.TestCase):
    def test_links_in_code_and_comments_are_none(self) -> None:
        text = "[a](b.md)\n`[c](d.md)` <!-- [e](f.md) -->\n```text\n[g](h.md)\n```\n![i\nj](k.png \"title\") <img\nsrc=\"l.png\">\n[m]: n.md\n[`o`](p(q).md#r)\n"
        found = [(link.target, link.line) for link in markdown.links(text)]
        self.assertEqual(found, [("b.md", 1), ("k.png", 7), ("l.png", 8), ("n.md", 9), ("p(q).md#r", 10)])
        changed = markdown.replaced(text, [(link, "x") for link in markdown.links(text)])
        self.assertIn("[a](x)\n`[c](d.md)`", changed)
        self.assertIn('![i\nj](x "title") <img\nsrc="x">\n[m]: x\n[`o`](x)', changed)

    def test_anchors_are_those_of_github(self) -> None:
        text = "# The `run.json` file\n## A – B, c_d\n## Twice\n## Twice\n```sh\n# no heading\n```\n<a id=\"own\"></a>\n"
        self.assertEqual(
            markdown.anchors(text),
            {"the-runjson-file": "the-runjson-file", "a--b-c_d": "a--b-c_d", "twice": "twice", "twice-1": "twice_1", "own": "own"},
        )

    def test_lists_and_tables_after_a_paragraph_get_a_blank_line(self) -> None:
        text = "text\n- a\n  goes on\n- b\n  1. c\n\n     more\n\n  ```sh\n  x\n  ```\nend\n| h `a\\|b` | i |\n|---|---|\n| `c\\|d` | \\|e\\| |\n"
        self.assertEqual(
            markdown.for_mkdocs(text),
            "text\n\n- a\n    goes on\n- b\n    1. c\n\n        more\n\n    ```sh\n    x\n    ```\n\nend\n\n"
            "| h `a|b` | i |\n|---|---|\n| `c|d` | \\|e\\| |\n",
        )

    def test_a_number_in_a_paragraph_begins_no_list(self) -> None:
        self.assertEqual(markdown.for_mkdocs("the year\n1999. was\n"), "the year\n1999. was\n")
        self.assertEqual(markdown.for_mkdocs("steps:\n1. a\n2. b\n"), "steps:\n\n1. a\n2. b\n")

    def test_comments_are_removed_but_not_from_code(self) -> None:
        self.assertEqual(markdown.for_mkdocs("<!-- a\nb -->\n```html\n<!-- c -->\n```\n`<!-- d -->` <!-- e -->f\n"), "```html\n<!-- c -->\n```\n`<!-- d -->` f\n")

    def test_tables_are_found_by_section_and_column(self) -> None:
        text = "# A\n## B\n| x | y |\n|---|---|\n| 1 | 2 |\n\n| code | y |\n|---|---|\n| 3 | 4 |\n## C\n| code |\n|---|\n"
        _, section = markdown.section(text, "B")
        self.assertEqual(markdown.table_with(section, "code"), ["| code | y |", "|---|---|", "| 3 | 4 |"])
        with self.assertRaises(LookupError):
            markdown.section(text, "D")


class Length(unittest.TestCase):
    #: Words of README, and of README and all pages in `docs`.
    README, ALL = 700, 32_000
    #: Pages that are generated as a whole.
    GENERATED = {"file-fields.md", "vehicle-fields.md"}

    def test_words_are_those_that_people_wrote(self) -> None:
        text = "a b <!-- c\nd -->\n```sh\ne\n```\n| f | g |\n|---|---|\n| h – i | `j k` |\n<!-- made: x (by y) -->\n\n| l |\n<!-- end of x -->\nm\n"
        self.assertEqual(markdown.words(text), 10)

    def test_readme_and_pages_stay_short(self) -> None:
        root = Path(__file__).resolve().parents[1]
        counts = {p.name: markdown.words(p.read_text(encoding="utf-8")) for p in (root / "docs").glob("*.md") if p.name not in self.GENERATED}
        readme = markdown.words((root / "README.md").read_text(encoding="utf-8"))
        self.assertLessEqual(readme, self.README, "README.md: move details to a page in docs")
        longest = ", ".join(f"{name} {count}" for name, count in sorted(counts.items(), key=lambda item: -item[1])[:5])
        self.assertLessEqual(readme + sum(counts.values()), self.ALL, f"README.md and docs: shorten what you extend (longest: {longest})")


class Pages(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name, "repository")
        for name in pages.PAGES:
            self.file(name, '{"cells": []}' if name.endswith(".ipynb") else "# Page\n")
        self.out = Path(self.folder.name, "out")

    def tearDown(self) -> None:
        self.folder.cleanup()

    def file(self, name: str, text: str) -> None:
        place = self.root / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")

    def test_links_lead_to_pages_and_copies(self) -> None:
        self.file("docs/a.md", "# A\n[b](b.md#b) [home](../README.md) [code](../src/x.rs#L2) [folder](../src) [web](https://example.org/)\n")
        self.file("docs/b.md", "## B\n[up](../CONTRIBUTING.md) ![p](pictures/p.png)\n")
        self.file("docs/pictures/p.png", "")
        self.file("src/x.rs", "fn x() {}\n")
        self.file("src/README.md", "# Sources\n[a](../docs/a.md) [x](x.rs)\n")
        pages.Pages(self.root, self.out).write_all()
        a = (self.out / "a.md").read_text(encoding="utf-8")
        links = "[b](b.md#b) [home](index.md) [code](files/src/x.rs.md) [folder](files/src/index.md) [web](https://example.org/)"
        self.assertEqual(a, f"# A\n{links}\n")
        self.assertIn("[up](project/contributing.md) ![p](files/docs/pictures/p.png)", (self.out / "b.md").read_text(encoding="utf-8"))
        self.assertTrue((self.out / "files/docs/pictures/p.png").is_file())
        self.assertIn("```rust\nfn x() {}\n```", (self.out / "files/src/x.rs.md").read_text(encoding="utf-8"))
        folder = (self.out / "files/src/index.md").read_text(encoding="utf-8")
        self.assertIn("[a](../../a.md) [x](x.rs.md)", folder)
        self.assertIn("| [x.rs](x.rs.md) | 1 kB |", folder)

    def test_broken_links_have_file_line_and_target(self) -> None:
        self.file("docs/a.md", "# A\n\n[b](b.md)\n[c](#c) [d](/d) [e](../../e) [f](../SECURITY.md#no)\n[g](../README.md#page)\n")
        with self.assertRaises(SiteError) as caught:
            pages.Pages(self.root, self.out).write_all()
        self.assertEqual(
            list(caught.exception.problems),
            [
                "docs/a.md:3: broken link 'b.md': no such file",
                "docs/a.md:4: broken link '#c': no heading of docs/a.md has this anchor",
                "docs/a.md:4: broken link '/d': absolute path; write it relative to the page",
                "docs/a.md:4: broken link '../../e': outside of the repository",
                "docs/a.md:4: broken link '../SECURITY.md#no': no heading of SECURITY.md has this anchor",
            ],
        )


class CommandLine(unittest.TestCase):
    MANUAL = r"""
.ie \n(.g .ds Aq \(aq
.el .ds Aq '
.TH vb-harness-drive 1  "drive "
.SH NAME
vb\-harness\-drive \- Drive
.SH SYNOPSIS
\fBvb\-harness drive\fR [\fB\-\-seed\fR]
.SH DESCRIPTION
Drive as docs/abi.md says
.SH OPTIONS
.TP
\fB\-s\fR, \fB\-\-seed\fR \fI<N>\fR [default: 0]
Seed of the planner\*(Aqs noise; see \-\-out
.TP
\fB\-\-mode\fR \fI<MODE>\fR
.br

.br
\fIPossible values:\fR
.RS 14
.IP \(bu 2
fast: Fast
.RE
.TP
\fB\-h\fR, \fB\-\-help\fR
Print help
.TP
<\fIRUN\fR>
Runs
.SH EXTRA
Exit codes:
    0  done
  130  stopped
"""

    def test_a_manual_page_becomes_a_page(self) -> None:
        command = cli.parsed(("drive",), self.MANUAL)
        self.assertEqual(command.exit_codes(), {0: "done", 130: "stopped"})
        text = cli.page(command, [command], {("drive",): "cli/drive.md"}, {"docs/abi.md": "abi.md"})
        for part in (
            "# vb-harness drive", "Drive as [docs/abi.md](../abi.md) says.", "## Arguments\n\n### `<RUN>`\n\nRuns.", "### `-s, --seed <N>`",
            "Seed of the planner's noise; see `--out`. Default: `0`.", "| `fast` | Fast |", "| 130 | stopped |",
        ):  # fmt: skip
            self.assertIn(part, text)
        self.assertNotIn("--help", text)

    def test_an_unknown_request_is_an_error(self) -> None:
        with self.assertRaises(ValueError):
            cli.parsed((), ".SH OPTIONS\n.UR x\n")


class CReference(unittest.TestCase):
    HEADER = """/* The interface.
 * Rules:
 * - SI units.
 */
#ifndef VB_PLANNER_H
#define VB_PLANNER_H
/* Room for a text. */
#define VB_BYTES 8

/* Levels. */
enum {
    VB_A = 0,
    /* The other. */
    VB_B = 1
};

/* A path, of vb_x. */
typedef struct vb_x {
    /* The points; see
     * docs/abi.md. */
    const vb_y *points;
    size_t points_len;
    char text[VB_BYTES];
    /* Logs. */
    void (*log)(void *context,
                uint32_t level);
} vb_x;
#define VB_NEED(sensor) "need: " sensor
extern VB_EXPORT const vb_x vb_entry;
#endif
"""

    def test_a_header_becomes_tables(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, c_reference.HEADER)
            file.parent.mkdir(parents=True)
            file.write_text(self.HEADER, encoding="utf-8")
            text = c_reference.page(Path(folder), {"docs/abi.md": "abi.md"})
            for part in (
                "- SI units.", "A path, of `vb_x`.", "| `points` | `const vb_y *` | The points; see [docs/abi.md](abi.md). |",
                "| `points_len` | `size_t` | The number of elements of `points`. |", "| `text` | `char[VB_BYTES]` |  |",
                "| `log` | `void (*)(void *context, uint32_t level)` | Logs. |", "| `VB_B` | 1 | The other. |",
                "| `VB_BYTES` | 8 | Room for a text. |", "### `VB_NEED(sensor)`", "### `const vb_x vb_entry`",
            ):  # fmt: skip
                self.assertIn(part, text)
            self.assertNotIn("VB_PLANNER_H", text)
            file.write_text(self.HEADER.replace("size_t points_len;", "size_t : 3;"), encoding="utf-8")
            with self.assertRaises(SiteError) as caught:
                c_reference.page(Path(folder), {})
            self.assertIn("sdk/c/vb_planner.h: not understood: size_t : 3;", caught.exception.problems[0])

    def test_every_structure_and_field_has_a_text(self) -> None:
        _, items = c_reference.parsed((Path(__file__).resolve().parents[1] / c_reference.HEADER).read_text(encoding="utf-8"))
        self.assertEqual([item.name for item in items if not item.text and not item.rows], [])
        self.assertEqual([(item.name, row[0]) for item in items if item.kind == "struct" for row in item.rows if not row[2]], [])


class RustReference(unittest.TestCase):
    def test_the_documentation_of_the_sdk_is_copied_without_other_crates(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            docs, out = Path(folder, "doc"), Path(folder, "out")
            with self.assertRaises(SiteError):
                docs.mkdir()
                build.copy_rustdoc(docs, out)
            for name in ("vb_sdk/index.html", "vb_sdk/all.html", "vb_host/all.html", "src/vb_sdk/lib.rs.html", "src/vb_host/lib.rs.html", "static.files/a.css", "static.files/b.md", ".lock"):
                file = docs / name
                file.parent.mkdir(parents=True, exist_ok=True)
                file.touch()
            build.copy_rustdoc(docs, out)
            found = sorted(p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file())
            self.assertEqual(found, ["src/vb_sdk/lib.rs.html", "static.files/a.css", "static.files/b.txt", "vb_sdk/all.html", "vb_sdk/index.html"])
        self.assertIn("rust/vb_sdk/index.html", build.rust_page(True))
        self.assertIn("cargo doc", build.rust_page(False))


class PythonReference(unittest.TestCase):
    def test_every_public_module_is_on_a_page(self) -> None:
        found = python_reference.pages(Path(__file__).resolve().parents[1])
        self.assertIn("::: vertibench.run\n", found["python-reference/vertibench.md"])
        self.assertIn("::: vertibench.envs.sb3.make_vec\n", found["python-reference/vertibench.envs.md"])


class Leaderboard(unittest.TestCase):
    def test_the_page_has_ranks_with_links_or_says_how_to_get_them(self) -> None:
        self.assertIn("`cargo xtask leaderboard`", build.leaderboard_page(None))
        entry = {
            "rank": 2, "tied": True, "planner": "tal", "page": "entries/tal/index.html", "time_s": None,
            "success_rate": {"mean": 0.639, "low": 0.567, "high": 0.712},
        }  # fmt: skip
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(SiteError):
                build.leaderboard_page(Path(folder))
            text = json.dumps({"boards": [{"suite": {"name": "vb-100"}, "vehicle": {"name": "hmmwv"}, "entries": [entry]}]})
            Path(folder, "leaderboard.json").write_text(text, encoding="utf-8")
            self.assertIn("| 2= | [tal](board/entries/tal/index.html) | 63.9 (56.7–71.2) | – |", build.leaderboard_page(Path(folder)))


class Program(unittest.TestCase):
    def test_a_missing_program_is_reported_with_the_remedy(self) -> None:
        script = Path(__file__).with_name("build.py")
        done = subprocess.run([sys.executable, script, "--check", "--program", "/nowhere/vb-harness"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("/nowhere/vb-harness: no such file; build it with", done.stderr)

    def test_a_folder_with_other_files_is_not_emptied(self) -> None:
        script = Path(__file__).with_name("build.py")
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "mine").touch()
            done = subprocess.run([sys.executable, script, "--without-cli", "--out", folder], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 1)
            self.assertIn("no earlier site", done.stderr)
            self.assertTrue(Path(folder, "mine").is_file())


if __name__ == "__main__":
    unittest.main()
