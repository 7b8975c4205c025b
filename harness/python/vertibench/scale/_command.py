"""What the commands of this package share: their options, and how they end."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from .._errors import VertibenchError
from ._work import Work


def parser(program: str, about: str) -> argparse.ArgumentParser:
    """A command line with the options that all have."""
    own = argparse.ArgumentParser(prog=program, description=about)
    own.add_argument("--shards", type=int, required=True, metavar="N", help="how many parts the work is split into")
    own.add_argument("--out", type=Path, required=True, metavar="DIR", help="the folder of the results, which all machines see")
    own.add_argument("--cpus", type=int, default=1, metavar="N", help="processors of each shard (default: 1)")
    own.add_argument("--scratch", type=Path, metavar="DIR", help="a folder of each machine's own disk, to work in")
    own.add_argument("arguments", nargs="+", metavar="ARGUMENT", help="after --: those of `vb-harness run`, or `sweep FILE`")
    return own


def work_of(own: argparse.Namespace) -> Work:
    """The work that the options say."""
    return Work.of(own.arguments, own.out, own.shards)


def ended(do: Callable[[], int]) -> int:
    """Does something; its errors become a line and an exit code."""
    try:
        return do()
    except VertibenchError as e:
        print(f"error: {e}", file=sys.stderr)
        return 2
    except OSError as e:
        print(f"error: {e.filename or 'the system'}: {e.strerror or e} (see that it can be written there)", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        print("stopped; the same command goes on", file=sys.stderr)
        return 130
