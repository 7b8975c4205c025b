"""Reader for the YAML of suites.

The harness writes worlds as YAML with block and flow collections, quoted texts, plain words and numbers. This module
reads that subset, so the package needs no YAML library. Anchors, tags, multi-line texts and other features are refused.
"""

from __future__ import annotations

import json
import re
from typing import Any

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")
_KEY = re.compile(r'("(?:[^"\\]|\\.)*"|[^\s"\'\[\]{},&*!|>%@`#-][^:#]*?)\s*:(?:\s+|$)')
_TOKEN = re.compile(r'\s*([\[\]{},]|:(?=[\s\[\]{},]|$)|"(?:[^"\\]|\\.)*"|\'(?:[^\']|\'\')*\'|[^\s\[\]{},:"\'](?:[^\[\]{},:]|:(?!\s))*)')
_REFUSED = tuple("&*!|>%@`")


def parse(text: str) -> Any:
    """Parses a document into dictionaries, lists, texts and numbers. Raises `ValueError` with the line number."""
    lines = []
    for number, line in enumerate(text.splitlines(), 1):
        line = _without_comment(line).rstrip()
        if line and line != "---":
            lines.append((number, len(line) - len(line.lstrip(" ")), line.strip()))
    value, rest = _block(lines, 0)
    if rest != len(lines):
        raise ValueError(f"line {lines[rest][0]}: it is indented in a way that makes no sense")
    return value


def _without_comment(line: str) -> str:
    quote = ""
    for k, c in enumerate(line):
        if quote:
            if c == quote and line[k - 1] != "\\":
                quote = ""
        elif c in "\"'" and (k == 0 or line[k - 1] in " [{,:"):
            quote = c
        elif c == "#" and (k == 0 or line[k - 1] == " "):
            return line[:k]
    return line


def _block(lines: list, at: int) -> tuple[Any, int]:
    """Parses the value that begins at a line and continues over all lines with at least its indentation."""
    if at == len(lines):
        return None, at
    _, indent, text = lines[at]
    if text == "-" or text.startswith("- "):
        return _list(lines, at, indent)
    if not _KEY.match(text):
        return _flow(lines, at, text)
    value: dict = {}
    while at < len(lines) and lines[at][1] == indent and not lines[at][2].startswith("- "):
        number, _, text = lines[at]
        key = _KEY.match(text)
        if not key:
            raise ValueError(f"line {number}: `{text}` is no field")
        name = str(_scalar(key[1], number))
        if name in value:
            raise ValueError(f"line {number}: the field {name} is there twice")
        if key.end() < len(text):
            value[name], at = _flow(lines, at, text[key.end() :])
        elif at + 1 < len(lines) and (
            lines[at + 1][1] > indent or (lines[at + 1][1] == indent and lines[at + 1][2].startswith("- "))
        ):
            value[name], at = _block(lines, at + 1)
        else:
            value[name], at = None, at + 1
    return value, at


def _list(lines: list, at: int, indent: int) -> tuple[list, int]:
    value = []
    while at < len(lines) and lines[at][1] == indent and (lines[at][2] == "-" or lines[at][2].startswith("- ")):
        number, _, text = lines[at]
        inner = text[1:].lstrip()
        if inner:
            # The text after the dash is a block, indented to its own column.
            lines[at] = (number, indent + len(text) - len(inner), inner)
            item, at = _block(lines, at)
        else:
            item, at = _block(lines, at + 1)
        value.append(item)
    return value, at


def _flow(lines: list, at: int, text: str) -> tuple[Any, int]:
    """Parses a value in brackets, which may continue over several lines, or a scalar."""
    number = lines[at][0]
    if text[0] not in "[{":
        return _scalar(text, number), at + 1
    tokens: list[str] = []
    depth = 0
    while True:
        place = 0
        while place < len(text):
            token = _TOKEN.match(text, place)
            if not token:
                raise ValueError(f"line {lines[at][0]}: `{text[place:]}` makes no sense")
            tokens.append(token[1])
            depth += (token[1] in "[{") - (token[1] in "]}")
            place = token.end()
        at += 1
        if depth <= 0:
            break
        if at == len(lines):
            raise ValueError(f"line {number}: the bracket is never closed")
        text = lines[at][2]
    value, rest = _bracket(tokens, 0, number)
    if rest != len(tokens):
        raise ValueError(f"line {number}: `{tokens[rest]}` is too much")
    return value, at


def _bracket(tokens: list[str], at: int, number: int) -> tuple[Any, int]:
    opening = tokens[at]
    if opening not in ("[", "{"):
        return _scalar(opening, number), at + 1
    closing, at = ("]" if opening == "[" else "}"), at + 1
    items: list = []
    fields: dict = {}
    while at < len(tokens) and tokens[at] != closing:
        if opening == "{":
            if at + 2 >= len(tokens) or tokens[at + 1] != ":":
                raise ValueError(f"line {number}: after `{tokens[at]}` comes no value")
            name = str(_scalar(tokens[at], number))
            fields[name], at = _bracket(tokens, at + 2, number)
        else:
            item, at = _bracket(tokens, at, number)
            items.append(item)
        if at < len(tokens) and tokens[at] == ",":
            at += 1
        elif at < len(tokens) and tokens[at] != closing:
            raise ValueError(f"line {number}: a comma is missing before `{tokens[at]}`")
    if at >= len(tokens):
        raise ValueError(f"line {number}: the bracket is never closed")
    return (items if opening == "[" else fields), at + 1


def _scalar(text: str, number: int) -> Any:
    text = text.strip()
    if text.startswith('"'):
        try:
            return json.loads(text)
        except json.JSONDecodeError:
            raise ValueError(f"line {number}: {text} is no text in quotes") from None
    if text.startswith("'"):
        return text[1:-1].replace("''", "'")
    if text.startswith(_REFUSED):
        raise ValueError(f"line {number}: `{text}` is YAML that this package doesn't read")
    if _NUMBER.match(text):
        return float(text) if any(c in text for c in ".eE") else int(text)
    return {"true": True, "false": False, "null": None, "~": None, "": None}.get(text, text)
