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
        help="convert a dataset to Minari",
        description="Write a dataset into Minari's local storage, the folder in MINARI_DATASETS_PATH.",
    )
    minari.add_argument("directory", metavar="DIR", help="output directory of `vb-harness dataset`")
    minari.add_argument("id", metavar="ID", help="name in the storage, e.g. vertibench/explore-v0")
    minari.add_argument("--author", metavar="NAME", help="name of the author")
    minari.add_argument("--author-email", metavar="ADDRESS", help="e-mail address of the author")
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
