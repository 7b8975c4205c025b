"""Reference of the command line, from the manual pages and the usage lines that the program prints."""

from __future__ import annotations

import posixpath
import re
import subprocess
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from . import SiteError, markdown

_ROFF = {r"\-": "-", r"\*(Aq": "'", r"\(aq": "'", r"\(bu": "•", r"\e": "\\", r"\&": ""}
_ESCAPE = re.compile(r"\\f[BIRP]|\\-|\\\*\(Aq|\\\(aq|\\\(bu|\\e|\\&")
_EXIT_CODE = re.compile(r"\s+(\d+)  (.+)")


@dataclass
class Item:
    """An option, an argument or a subcommand.

    Attributes:
        term: Its name and value, e.g. `--seed <N>`.
        default: Its default value; empty if there is none.
        text: Its description.
        values: Its possible values with their descriptions.
    """

    term: str
    default: str = ""
    text: str = ""
    values: list[str] = field(default_factory=list)


@dataclass
class Command:
    """A command of the program.

    Attributes:
        path: Its words without the program's name; empty for the program.
        about: Its description.
        usage: Its lines of usage.
        sections: Items by the heading under which they stand.
        notes: Lines after the options, such as exit codes.
        version: Version of the program; only for the program itself.
    """

    path: tuple[str, ...]
    about: str = ""
    usage: str = ""
    sections: dict[str, list[Item]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    version: str = ""

    @property
    def name(self) -> str:
        """The command as it is typed."""
        return " ".join(("vb-harness", *self.path))

    def exit_codes(self) -> dict[int, str]:
        """Exit codes with their meaning."""
        return {int(match[1]): match[2] for line in self.notes if (match := _EXIT_CODE.match(line))}


def _plain(line: str) -> str:
    return _ESCAPE.sub(lambda match: _ROFF.get(match[0], ""), line)


def parsed(path: tuple[str, ...], page: str) -> Command:
    """A command from its manual page. Raises ValueError for a page with requests that are not known here."""
    command = Command(path)
    heading, items, item, expects_term = "", [], None, False
    is_value = False
    for line in page.splitlines():
        request, _, rest = line.partition(" ")
        if request == ".SH":
            heading, item, expects_term = rest.strip('"'), None, False
            items = command.sections.setdefault(heading, [])
        elif request == ".TP":
            expects_term, is_value = True, False
        elif request == ".IP":
            is_value = True
        elif request in (".ie", ".el", ".TH", ".br", ".RS", ".RE", ".PP"):
            is_value = is_value and request != ".RE"
        elif request.startswith("."):
            raise ValueError(f"the manual page of {command.name} has an unknown request: {line}")
        elif heading == "VERSION":
            command.version = _plain(line).split(" ")[0].removeprefix("v")
        elif heading == "EXTRA":
            command.notes.append(_plain(line))
        elif heading == "DESCRIPTION":
            command.about = f"{command.about}\n\n{_plain(line)}".strip()
        elif heading == "SYNOPSIS":
            command.usage = f"{command.usage}\n{_plain(line)}".strip()
        elif heading == "NAME" or not line.strip() or _plain(line) == "Possible values:":
            pass
        elif expects_term:
            term, _, default = _plain(line).partition(" [default: ")
            item = Item(term.strip(), default.rstrip("]"))
            items.append(item)
            expects_term = False
        elif item is None:
            raise ValueError(f"the manual page of {command.name} has text that belongs to no option: {line}")
        elif is_value:
            item.values.append(_plain(line))
        else:
            item.text = f"{item.text}\n\n{_plain(line)}".strip()
    return command


def _run(program: Path, *arguments: str) -> str:
    try:
        done = subprocess.run([program, *arguments], capture_output=True, encoding="utf-8", timeout=60, check=False)
    except (OSError, subprocess.TimeoutExpired) as e:
        raise SiteError(f"{program}: can't be run: {e}") from None
    if done.returncode:
        raise SiteError(f"{program} {' '.join(arguments)}: ended with exit code {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def commands(program: Path) -> list[Command]:
    """All commands of the program, in the order in which it lists them."""
    with tempfile.TemporaryDirectory() as folder:
        _run(program, "man", "--out", folder)
        pages = {p.stem: p.read_text(encoding="utf-8") for p in Path(folder).glob("*.1")}

    found: list[Command] = []

    def add(path: tuple[str, ...]) -> None:
        try:
            command = parsed(path, pages.pop("-".join(("vb-harness", *path))))
        except (KeyError, ValueError) as e:
            raise SiteError(f"{program}: manual page of {' '.join(('vb-harness', *path))}: {e}") from None
        # The usage lines of the help are clearer than those of the manual page. A command without help of its own calls another program.
        if any(item.term == "-h, --help" for item in command.sections.get("OPTIONS", [])):
            usage = re.search(r"^Usage: (.*?)(?:\n\s*\n|\Z)", _run(program, *path, "--help"), re.DOTALL | re.MULTILINE)
            if not usage:
                raise SiteError(f"{program} {' '.join(path)} --help: no usage line")
            command.usage = "\n".join(line.strip() for line in usage[1].splitlines())
        found.append(command)
        for item in command.sections.get("SUBCOMMANDS", []):
            words = item.term.removesuffix("(1)").removeprefix(f"{'-'.join(('vb-harness', *path))}-")
            if words != "help":
                add((*path, words))

    add(())
    if pages:
        raise SiteError(f"{program}: manual pages without a command: {', '.join(sorted(pages))}")
    return found


def place(command: Command, is_group: bool) -> str:
    """Path of a command's page on the site."""
    return "/".join(("cli", *command.path, "index.md")) if is_group else "/".join(("cli", *command.path)) + ".md"


def page(command: Command, all_commands: Iterable[Command], places: dict[tuple[str, ...], str], documents: dict[str, str]) -> str:
    """Page of a command.

    Args:
        command: The command.
        all_commands: All commands.
        places: Paths of the commands' pages on the site.
        documents: Paths of other pages on the site, by their path in the repository.
    """
    here = posixpath.dirname(places[command.path])

    def prose(text: str) -> str:
        def part(match: re.Match[str]) -> str:
            found = match[0]
            if found in documents:
                return f"[{markdown.escaped(found)}]({posixpath.relpath(documents[found], here)})"
            return f"`{found}`" if found.startswith("--") else markdown.escaped(found)

        return re.sub(r"(?<![\w-])--[a-z][a-z-]*[a-z]|\b[\w/-]+\.md\b|(?:(?!(?<![\w-])--[a-z]|\b[\w/-]+\.md\b).)+", part, text, flags=re.DOTALL)

    about = [prose(text) + "." * (not text.endswith((".", "…"))) for text in command.about.split("\n\n")]
    parts = [f"# {command.name}", *about, f"```text\n{command.usage}\n```"]
    inside = [one for one in all_commands if one.path[:-1] == command.path and one.path]
    if inside:
        rows = [[f"[`{one.path[-1]}`]({posixpath.relpath(places[one.path], here)})", prose(one.about)] for one in inside]
        parts += ["## Commands", markdown.table(["command", "purpose"], rows)]
    if not command.path:
        parts.append(f"Options without a command are those of [`run`]({posixpath.relpath(places[('run',)], here)}). `--version` prints the version; this page describes {command.version}.")
    else:
        for heading, items in command.sections.items():
            shown = [item for item in items if item.term not in ("-h, --help", "-V, --version")]
            if heading == "SUBCOMMANDS" or not shown:
                continue
            arguments = [item for item in shown if not item.term.startswith("-")]
            options = [item for item in shown if item.term.startswith("-")]
            name = heading.capitalize()
            for title, some in (("Arguments", arguments), (name, options)):
                if some:
                    parts.append(f"## {title}")
                for item in some:
                    parts.append(f"### `{item.term}`")
                    default = f" Default: `{item.default}`." if item.default else ""
                    paragraphs = [prose(text) + "." * (not text.endswith((".", "…"))) for text in item.text.split("\n\n") if text]
                    parts.append(("\n\n".join(paragraphs) + default).strip())
                    if item.values:
                        values = [value.partition(": ") for value in item.values]
                        parts.append(markdown.table(["value", "meaning"], [[f"`{name}`", prose(text)] for name, _, text in values]))
    if codes := command.exit_codes():
        parts += ["## Exit codes", f"All codes: [fault codes and exit codes]({posixpath.relpath('codes.md', here)}#exit-codes)."]
        parts.append(markdown.table(["exit code", "meaning"], [[str(code), prose(text)] for code, text in codes.items()]))
    rest = [line for line in command.notes if line.strip() and not _EXIT_CODE.match(line) and line != "Exit codes:"]
    if rest:
        parts += ["## Notes", "```text\n" + "\n".join(rest) + "\n```"]
    return "\n\n".join(parts) + "\n"


def navigation(all_commands: list[Command], places: dict[tuple[str, ...], str], indent: str) -> str:
    """Lines of the navigation for the commands, in YAML."""
    lines = []
    for command in all_commands:
        is_group = any(one.path[:-1] == command.path and one.path for one in all_commands)
        at = places[command.path]
        depth = indent + "    " * max(0, len(command.path) - 1)
        if not command.path:
            lines.append(f"{indent}- {at}")
        elif is_group:
            lines += [f"{depth}- {command.path[-1]}:", f"{depth}    - {at}"]
        else:
            lines.append(f"{depth}- {command.path[-1]}: {at}")
    return "\n".join(lines)
