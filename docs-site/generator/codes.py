"""Page with all fault codes and exit codes, from the tables of the pages that define them."""

from __future__ import annotations

from pathlib import Path

from . import SiteError, markdown
from .pages import Pages

PAGE = "codes.md"
#: Heading on the page, file and heading of the section with the table, header of its first column.
TABLES = (
    ("Exit codes", "docs/results.md", "Messages and exit codes", "exit code"),
    ("Fault codes", "docs/abi.md", "Faults", "code"),
    ("Errors in Python", "harness/python/README.md", "Runs", "code"),
)


def page(root: Path, pages: Pages) -> str:
    """The page. Raises SiteError if a table is missing."""
    about = (
        "An exit code is the result of a command. A fault code is the reason why a planner or the harness failed in a task, or why a "
        "planner can't be loaded."
    )
    parts = ["# Fault codes and exit codes", about]
    for heading, source, section, column in TABLES:
        text = (root / source).read_text(encoding="utf-8")
        try:
            _, text_of_section = markdown.section(text, section)
            table = markdown.table_with(text_of_section, column)
        except LookupError:
            raise SiteError(f"{source}: no table with the first column {column!r} under {section!r}; adapt `TABLES` in {Path(__file__).name}") from None
        # Lines of errors are those of the source.
        line = text.splitlines().index(table[0]) + 1
        anchor = next(a for a in markdown.anchors(text) if a == markdown.slug(section))
        where = pages.linked(f"[{section}]({'../' * source.count('/')}{source}#{anchor})", source, PAGE)
        parts += [f"## {heading}", f"Explained in {where}.", pages.linked("\n".join(table), source, PAGE, line)]
    return "\n\n".join(parts) + "\n"


def exit_codes(root: Path) -> set[int]:
    """Exit codes in the table of docs/results.md."""
    _, source, section, column = TABLES[0]
    _, text = markdown.section((root / source).read_text(encoding="utf-8"), section)
    return {int(row.split("|")[1]) for row in markdown.table_with(text, column)[2:]}
