"""Reader for YAML files of suites and trainings, with PyYAML.

The harness reads YAML 1.2, PyYAML YAML 1.1, in which `on` and `yes` are booleans, `010` is 8, `1e3` is a text and `12:30`
is 750. The loader below therefore has the types of YAML 1.2 (core schema) only. It creates no objects of other classes,
and refuses aliases, because a few of them can expand to gigabytes.
"""

from __future__ import annotations

import functools
import re
from pathlib import Path
from typing import Any

from ._errors import MissingPackageError

#: Maximum size of a file, bytes; the largest file of the shipped suites has 65 kB.
LIMIT = 64 << 20
#: Plain scalars that are no texts, by type, and their first characters.
_SCALARS = {
    "null": (r"(?:~|null|Null|NULL|)$", ["~", "n", "N", ""]),
    "bool": (r"(?:true|True|TRUE|false|False|FALSE)$", "tTfF"),
    "int": (r"(?:[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+)$", "-+0123456789"),
    "float": (
        r"(?:[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))$",
        "-+.0123456789",
    ),
}


def read(file: Path) -> Any:
    """Reads the document in a file. Raises `OSError` if it can't be read, and `ValueError` if it is too large or invalid."""
    with file.open("rb") as opened:
        content = opened.read(LIMIT + 1)
    if len(content) > LIMIT:
        raise ValueError(f"it is larger than {LIMIT >> 20} MiB")
    return parse(content.decode("utf-8"))


def parse(text: str) -> Any:
    """Parses a document into dictionaries, lists, texts, numbers, booleans and None. Raises `ValueError` with the line."""
    loader = _loader()
    import yaml

    try:
        return yaml.load(text, loader)  # noqa: S506 - a subclass of SafeLoader
    except yaml.MarkedYAMLError as e:
        mark = e.problem_mark or e.context_mark
        what = ", ".join(part for part in (e.context, e.problem) if part)
        raise ValueError(f"line {mark.line + 1}: {what}" if mark else what) from None
    except yaml.reader.ReaderError as e:
        raise ValueError(f"line {text.count(chr(10), 0, e.position) + 1}: {e.reason}") from None
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


@functools.cache
def _loader() -> Any:
    try:
        import yaml
    except ImportError:
        raise MissingPackageError("pyyaml", "the YAML files of suites and trainings") from None

    class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
        """Loader of YAML 1.2."""

        yaml_implicit_resolvers: dict[Any, Any] = {}

        def construct_object(self, node: Any, deep: bool = False) -> Any:
            # Only the node of an alias is constructed twice.
            if node in self.constructed_objects or node in self.recursive_objects:
                raise yaml.constructor.ConstructorError(None, None, "aliases (`*name`) are not supported", node.start_mark)
            try:
                return super().construct_object(node, deep)
            except (AttributeError, KeyError, ValueError):
                # Only with a tag, e.g. `!!bool 5`, or a number with thousands of digits.
                raise yaml.constructor.ConstructorError(None, None, "invalid value", node.start_mark) from None

        def construct_mapping(self, node: Any, deep: bool = False) -> Any:
            names = set()
            for key, _ in node.value if isinstance(node, yaml.MappingNode) else ():
                name = (key.tag, key.value) if isinstance(key, yaml.ScalarNode) else None
                if name in names:
                    raise yaml.constructor.ConstructorError(None, None, f"duplicate field {key.value}", key.start_mark)
                names |= {name} - {None}
            return super().construct_mapping(node, deep)

        def construct_yaml_int(self, node: Any) -> int:
            text = self.construct_scalar(node)
            return int(text, 0 if text[:2] in ("0o", "0x") else 10)

    for kind, (pattern, first) in _SCALARS.items():
        Loader.add_implicit_resolver(f"tag:yaml.org,2002:{kind}", re.compile(pattern), first)
    Loader.add_constructor("tag:yaml.org,2002:int", Loader.construct_yaml_int)
    return Loader
