"""Page of the planner interface in C, from the header `sdk/c/vb_planner.h` and its comments."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from . import SiteError, markdown

PAGE = "c-reference.md"
HEADER = "sdk/c/vb_planner.h"
#: Macros that other macros of the header need.
LEFT_OUT = {"VB_PLANNER_H", "VB_EXPORT", "VB_SECTION", "VB_TEXT_", "VB_TEXT"}

_TOKEN = re.compile(
    r"/\*(?P<comment>.*?)\*/"
    r"|^enum \{(?P<enum>.*?)^\};"
    r"|^typedef struct (?P<struct>\w+) \{(?P<fields>.*?)^\} (?P=struct);"
    r"|^#define (?P<macro>\w+)(?P<parameters>\([^)]*\))?(?P<body>(?:[^\n\\]|\\\n|\\.)*)$"
    r"|^extern VB_EXPORT (?P<variable>[^;]+);",
    re.DOTALL | re.MULTILINE,
)
_VALUE = re.compile(r"\s*(?:/\*(?P<comment>.*?)\*/\s*)?(?P<name>\w+) = (?P<value>\d+),?", re.DOTALL)
_FIELD = re.compile(
    r"\s*(?:/\*(?P<comment>.*?)\*/\s*)?(?:(?P<result>[\w ]+?) \(\*(?P<function>\w+)\)\((?P<arguments>[^)]*)\);"
    r"|(?P<type>[\w ]+?(?: \*+)?) ?(?P<name>\w+)(?P<size>\[\w+\])?;)",
    re.DOTALL,
)


@dataclass
class Item:
    """An enumeration, a structure, a macro or a variable.

    Attributes:
        kind: `enum`, `struct`, `macro` or `variable`.
        name: Name, of a macro with its parameters; empty for an enumeration.
        text: Its comment.
        rows: Values with their meaning, or fields with type and meaning.
    """

    kind: str
    name: str
    text: str
    rows: list[tuple[str, str, str]] = field(default_factory=list)


def _plain(comment: str | None) -> str:
    lines = [re.sub(r"^\s*\* ?", "", line).strip() for line in (comment or "").strip().splitlines()]
    return " ".join(line for line in lines if line)


def parsed(text: str) -> tuple[str, list[Item]]:
    """Leading comment and items of a header. Raises ValueError for a line of a structure that isn't understood."""
    about = ""
    items: list[Item] = []
    comment, end = "", 0
    for match in _TOKEN.finditer(text):
        if match["comment"] is not None:
            about = about or match["comment"]
            comment, end = _plain(match["comment"]), match.end()
            continue
        # A comment belongs to the items that follow it without a blank line.
        if "\n\n" in text[end : match.start()]:
            comment = ""
        if match["enum"] is not None:
            rows = [(one["name"], one["value"], _plain(one["comment"])) for one in _all(_VALUE, match["enum"])]
            items.append(Item("enum", "", comment, rows))
        elif match["struct"]:
            items.append(Item("struct", match["struct"], comment, _fields(match["fields"])))
        elif match["macro"] and match["macro"] not in LEFT_OUT:
            value = "" if match["parameters"] else match["body"].strip()
            items.append(Item("macro", f"{match['macro']}{match['parameters'] or ''}", comment, [(match["macro"], value, "")] if value else []))
        elif match["variable"]:
            items.append(Item("variable", match["variable"], comment))
        end = match.end()
    return about, items


def _all(pattern: re.Pattern[str], text: str) -> list[re.Match[str]]:
    found, at = [], 0
    while text[at:].strip():
        match = pattern.match(text, at)
        if not match:
            raise ValueError(f"not understood: {text[at:].strip().splitlines()[0]}")
        found.append(match)
        at = match.end()
    return found


def _fields(text: str) -> list[tuple[str, str, str]]:
    rows = []
    for one in _all(_FIELD, text):
        about = _plain(one["comment"])
        if one["function"]:
            rows.append((one["function"], f"{one['result']} (*)({' '.join(one['arguments'].split())})", about))
        elif one["name"].endswith("_len") and not about:
            rows.append((one["name"], one["type"], f"The number of elements of `{one['name'].removesuffix('_len')}`."))
        else:
            rows.append((one["name"], f"{one['type']}{one['size'] or ''}", about))
    return rows


def _prose(text: str, documents: dict[str, str]) -> str:
    """Text of a comment as Markdown; names of the interface are code, and names of pages links."""

    def part(match: re.Match[str]) -> str:
        found = match[0]
        if found in documents:
            return f"[{found}]({documents[found]})"
        if found.startswith("`") and len(found) > 1:
            return found
        return f"`{found}`" if "_" in found and found != "_" else markdown.escaped(found)

    return re.sub(r"`[^`]*`|\b[\w/-]+\.md\b|(?<![\w.])[A-Za-z]\w*_\w*…?|[\w]+|[^\w`]+|`", part, text)


def page(root: Path, documents: dict[str, str]) -> str:
    """The page. Raises SiteError if the header is not understood.

    Args:
        root: Root of the repository.
        documents: Paths of other pages on the site, by their path in the repository.
    """
    try:
        about, items = parsed((root / HEADER).read_text(encoding="utf-8"))
    except ValueError as e:
        raise SiteError(f"{HEADER}: {e}; adapt {Path(__file__).name}") from None

    def prose(text: str) -> str:
        return _prose(text, documents)

    opening, _, rules = about.partition("Rules:")
    listed = [_plain(rule) for rule in re.split(r"^ \* - ", rules, flags=re.MULTILINE)[1:]]
    parts = ["# C reference", prose(_plain(opening)), "\n".join(f"- {prose(rule)}" for rule in listed)]
    kinds = {kind: [item for item in items if item.kind == kind] for kind in ("struct", "enum", "macro", "variable")}
    if not all(kinds.values()):
        raise SiteError(f"{HEADER}: has no {', '.join(kind for kind, found in kinds.items() if not found)}; adapt {Path(__file__).name}")
    parts.append("## Structures")
    for item in kinds["struct"]:
        rows = [[f"`{name}`", f"`{kind}`", prose(text)] for name, kind, text in item.rows]
        parts += [f"### `{item.name}`", prose(item.text), markdown.table(["field", "type", "meaning"], rows)]
    parts.append("## Constants")
    for item in kinds["enum"]:
        parts.append(prose(item.text))
        parts.append(markdown.table(["name", "value", "meaning"], [[f"`{name}`", value, prose(text)] for name, value, text in item.rows]))
    values = [item for item in kinds["macro"] if item.rows]
    parts.append(markdown.table(["name", "value", "meaning"], [[f"`{item.name}`", item.rows[0][1], prose(item.text)] for item in values]))
    parts.append("## Macros and the entry")
    for item in [*(one for one in kinds["macro"] if not one.rows), *kinds["variable"]]:
        parts += [f"### `{item.name}`", prose(item.text)]
    return "\n\n".join(part for part in parts if part) + "\n"
