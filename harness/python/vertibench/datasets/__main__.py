"""`python -m vertibench.datasets`: conversion of datasets."""

from __future__ import annotations

import argparse
import sys

from . import DatasetError, open, to_minari


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line.

    Args:
        arguments: Arguments after the program's name. None (default): those of the process.

    Returns:
        Exit code: 0, or 3 if the dataset can't be read or written.
    """
    parser = argparse.ArgumentParser("python -m vertibench.datasets", description="Convert datasets of vb-harness.")
    commands = parser.add_subparsers(dest="command", required=True)
    minari = commands.add_parser(
        "to-minari",
        help="put a dataset into Minari's store",
        description="Put a dataset into Minari's store, the folder that MINARI_DATASETS_PATH names.",
    )
    minari.add_argument("directory", metavar="DIR", help="the folder that `vb-harness dataset` wrote")
    minari.add_argument("id", metavar="ID", help="name in the store, for instance vertibench/explore-v0")
    minari.add_argument("--author", metavar="NAME", help="who is named as the author")
    minari.add_argument("--author-email", metavar="ADDRESS", help="the author's address")
    given = parser.parse_args(arguments)
    try:
        made = to_minari(open(given.directory), given.id, author=given.author, author_email=given.author_email)
    except (DatasetError, ValueError, OSError) as e:
        print(f"error: {' '.join(str(e).split())}", file=sys.stderr)
        return 3
    print(f"{given.id}: {made.total_episodes} episodes, {made.total_steps} steps")
    return 0


if __name__ == "__main__":
    sys.exit(main())
