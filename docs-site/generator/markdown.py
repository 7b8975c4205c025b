"""Markdown as GitHub reads it: links, headings, and conversion to the Markdown of MkDocs."""

from __future__ import annotations

import re
from dataclasses import dataclass

_FENCE = re.compile(r" {0,3}(`{3,}|~{3,})")
#: HTML comment, or code span that doesn't cross a blank line.
_HIDDEN = re.compile(r"<!--.*?-->|(?<!`)(`+)(?!`)((?:(?!\n[ \t]*\n).)+?)(?<!`)\1(?!`)", re.DOTALL)
#: Destination of an inline link or picture, with one level of parentheses, and an optional title.
_INLINE = re.compile(r"\]\(\s*(?:<([^<>\n]*)>|((?:[^\s()]|\([^\s()]*\))+))(?:\s+\"[^\"]*\")?\s*\)")
_DEFINITION = re.compile(r"^ {0,3}\[[^\]\n]+\]:[ \t]+(\S+)", re.MULTILINE)
_ATTRIBUTE = re.compile(r"<[A-Za-z][^>]*?\b(?:href|src)\s*=\s*\"([^\"]*)\"", re.DOTALL)
_ANCHOR = re.compile(r"<[A-Za-z][^>]*?\b(?:id|name)\s*=\s*\"([^\"]*)\"", re.DOTALL)
_HEADING = re.compile(r" {0,3}(#{1,6})[ \t]+(.*?)[ \t]*#*[ \t]*$")
_DELIMITERS = re.compile(r" {0,3}\|?[ \t]*:?-+:?[ \t]*(\|[ \t]*:?-+:?[ \t]*)*\|?[ \t]*$")
_ITEM = re.compile(r"( *)([-*+]|\d{1,9}[.)])( +)(?=\S)")


def _blank(text: str) -> str:
    return re.sub(r"[^\n]", " ", text)


def fenced(text: str) -> list[bool]:
    """Whether each line belongs to a fenced code block, fences included."""
    found, fence = [], ""
    for line in text.splitlines():
        match = _FENCE.match(line)
        if fence:
            found.append(True)
            if match and match[1].startswith(fence) and not line.strip().strip(fence[0]):
                fence = ""
        else:
            fence = match[1] if match and not (match[1][0] == "`" and "`" in line[match.end() :]) else ""
            found.append(bool(fence))
    return found


def masked(text: str) -> str:
    """The text with blanks in place of code and comments; all other characters keep their offsets."""
    lines = text.splitlines(keepends=True)
    open_text = "".join(_blank(line) if code else line for line, code in zip(lines, fenced(text), strict=True))

    return _HIDDEN.sub(lambda match: _blank(match[0]), open_text)


@dataclass(frozen=True)
class Link:
    """Destination of a link, a picture, or an HTML attribute.

    Attributes:
        target: The destination.
        start: Offset of the destination in the text.
        line: Number of its line, from 1.
    """

    target: str
    start: int
    line: int


def links(text: str) -> list[Link]:
    """The links and pictures of a page outside code and comments, in their order."""
    visible = masked(text)
    found = []
    for pattern in (_INLINE, _DEFINITION, _ATTRIBUTE):
        for match in pattern.finditer(visible):
            group = next(i for i in range(1, match.re.groups + 1) if match[i] is not None)
            found.append(Link(match[group], match.start(group), text.count("\n", 0, match.start(group)) + 1))
    return sorted(found, key=lambda link: link.start)


def replaced(text: str, changes: list[tuple[Link, str]]) -> str:
    """The text with other destinations of links."""
    for link, target in sorted(changes, key=lambda change: -change[0].start):
        text = text[: link.start] + target + text[link.start + len(link.target) :]
    return text


def slug(heading: str) -> str:
    """Anchor of a heading on GitHub, without the number of a repeated heading."""
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", text.lower().strip()).replace(" ", "-")


def anchors(text: str) -> dict[str, str]:
    """Anchors of a page on GitHub, each with its anchor on the site, which numbers repeated headings differently."""
    found: dict[str, str] = {}
    counts: dict[str, int] = {}
    for line, code in zip(text.splitlines(), fenced(text), strict=True):
        if not code and (match := _HEADING.match(line)):
            name = slug(match[2])
            count = counts[name] = counts.get(name, -1) + 1
            found[f"{name}-{count}" if count else name] = f"{name}_{count}" if count else name
    found.update((match[1], match[1]) for match in _ANCHOR.finditer(masked(text)))
    return found


def _without_comments(text: str) -> str:
    """Removes comments outside code; they are instructions for tests and generators."""
    lines = text.splitlines(keepends=True)
    code = fenced(text)
    parts, i = [], 0
    while i < len(lines):
        j = i
        while j < len(lines) and code[j] == code[i]:
            j += 1
        part = "".join(lines[i:j])
        if not code[i]:
            part = re.sub(r"^[ \t]*<!--.*?-->[ \t]*\n", "", part, flags=re.DOTALL | re.MULTILINE)
            part = _HIDDEN.sub(lambda match: "" if match[0].startswith("<!--") else match[0], part)
        parts.append(part)
        i = j
    return "".join(parts)


def _is_table_head(lines: list[str], i: int) -> bool:
    return i + 1 < len(lines) and "|" in lines[i] and "|" in lines[i + 1] and bool(_DELIMITERS.match(lines[i + 1]))


def _row(line: str) -> str:
    """A row of a table with plain pipes in code, where Python-Markdown needs and takes no backslash."""
    return re.sub(r"(`+)(.+?)\1", lambda match: match[0].replace(r"\|", "|"), line)


def for_mkdocs(text: str) -> str:
    """Converts Markdown as GitHub reads it to what Python-Markdown reads as the same.

    Python-Markdown needs a blank line before a list or table that follows a paragraph, and four columns of indentation per
    level of a list. Comments are removed.
    """
    lines = _without_comments(text).splitlines()
    code = fenced("\n".join(lines))
    result: list[str] = []
    #: Columns at which the content of the open list items begins.
    columns: list[int] = []
    in_table = False
    for i, line in enumerate(lines):
        if not line.strip():
            in_table = False
            result.append("")
            continue
        indent = len(line) - len(line.lstrip(" "))
        after_blank = not result or not result[-1]
        opens_code = code[i] and not (i and code[i - 1])
        item = None if code[i] else _ITEM.match(line)
        was_in_list = bool(columns)
        after_code = bool(i) and code[i - 1] and not code[i]
        if item or opens_code or (after_blank or after_code or _HEADING.match(line)) and not code[i]:
            columns = [column for column in columns if column <= indent]
        if after_code and was_in_list and not columns and not item:
            result.append("")
        if item and not was_in_list and not after_blank:
            if item[2] in "-*+" or item[2][:-1] == "1":
                result.append("")
            else:
                item = None  # GitHub, too, takes this number for a part of the paragraph
        margin = "    " * len(columns)
        if item:
            in_table = False
            columns.append(item.end())
            result.append(f"{margin}{item[2].replace(')', '.')} {line[item.end() :]}")
            continue
        line = line[min(indent, columns[-1] if columns else 0) :]
        if not code[i]:
            if not in_table and _is_table_head(lines, i):
                in_table = True
                if not after_blank:
                    result.append("")
            if in_table:
                line = _row(line)
        result.append(margin + line)
    return "\n".join(result) + "\n"


def words(text: str) -> int:
    """Number of words that people wrote on a page: without code blocks, generated parts, comments and the lines of tables."""
    lines = [line for line, code in zip(text.splitlines(), fenced(text), strict=True) if not code]
    open_text = re.sub(r"<!-- made: .*?<!-- end of .*?-->|<!--.*?-->", "", "\n".join(lines), flags=re.DOTALL)
    return len(re.sub(r"^[ |:-]+$", "", open_text, flags=re.MULTILINE).replace("|", " ").split())


def escaped(text: str) -> str:
    """Plain text as Markdown."""
    return re.sub(r"([\\`*_\[\]<>|#])", lambda match: {"<": "&lt;", ">": "&gt;"}.get(match[1], "\\" + match[1]), text)


def table(header: list[str], rows: list[list[str]]) -> str:
    """A table of cells that are Markdown already."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in lines) + "\n"


def section(text: str, heading: str) -> tuple[int, str]:
    """First line (from 1) and text of the section with this heading, up to the next heading of its level or above."""
    lines = text.splitlines()
    code = fenced(text)
    start = level = 0
    for i, line in enumerate(lines):
        match = None if code[i] else _HEADING.match(line)
        if not match:
            continue
        if start and len(match[1]) <= level:
            return start, "\n".join(lines[start:i])
        if not start and match[2] == heading:
            start, level = i + 1, len(match[1])
    if not start:
        raise LookupError(heading)
    return start, "\n".join(lines[start:])


def table_with(text: str, first_column: str) -> list[str]:
    """Lines of the first table whose first column has this header."""
    lines = text.splitlines()
    code = fenced(text)
    for i in range(len(lines)):
        if not code[i] and _is_table_head(lines, i) and lines[i].strip("| ").split("|")[0].strip() == first_column:
            end = i
            while end < len(lines) and lines[end].startswith("|"):
                end += 1
            return lines[i:end]
    raise LookupError(first_column)
