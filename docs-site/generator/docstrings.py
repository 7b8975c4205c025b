"""Griffe extension: docstrings as Markdown, with examples as code and names of documents as links."""

from __future__ import annotations

import re
from typing import Any

import griffe

#: Lines of an interactive session, up to the next blank line.
_SESSION = re.compile(r"^([ \t]*)>>> .*(?:\n[ \t]*\S.*)*", re.MULTILINE)
#: Role of reStructuredText before a name in code.
_ROLE = re.compile(r":(?:attr|class|func|meth|mod):(?=`)")
#: Document of the repository, outside of code and addresses.
_DOCUMENT = re.compile(r"(?<![`/\w])docs/([\w-]+)\.md\b(?![`\w])")


def as_markdown(text: str) -> str:
    """A docstring with fences around interactive sessions, and with links for pages one level below the site's root."""
    parts = re.split(r"(^[ \t]*>>> .*(?:\n[ \t]*\S.*)*)", text, flags=re.MULTILINE)
    for i, part in enumerate(parts):
        if session := _SESSION.fullmatch(part):
            parts[i] = f"{session[1]}```pycon\n{part}\n{session[1]}```"
        else:
            # A paragraph that ends with two colons introduces code.
            part = re.sub(r"::(?=\n\n[ \t]{4})", ":", _ROLE.sub("", part))
            parts[i] = _DOCUMENT.sub(r"[\g<0>](../\1.md)", part)
    return "".join(parts)


class Docstrings(griffe.Extension):
    """Converts the docstrings of a package."""

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:
        """Is called by griffe when a package is loaded."""
        _convert(pkg)


def _convert(object_: griffe.Object) -> None:
    if object_.docstring:
        object_.docstring.value = as_markdown(object_.docstring.value)
    for member in object_.members.values():
        if isinstance(member, griffe.Object):
            _convert(member)
