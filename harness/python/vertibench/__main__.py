"""`vertibench` and `python -m vertibench`: the program `vb-harness` with this package's tasks and planners."""

from __future__ import annotations

import os
import subprocess
import sys

from ._errors import MissingError
from ._program import environment, harness_path


def main() -> int:
    """Replaces this process with the program, with the same arguments; where this is impossible, returns its exit code."""
    try:
        program = str(harness_path())
        variables = environment()
    except MissingError as e:
        print(f"error: {e}", file=sys.stderr)
        return 3
    command = [program, *sys.argv[1:]]
    try:
        if os.name == "posix":
            # Signals and exit codes are then the program's own.
            os.execve(program, command, variables)
        return subprocess.run(command, env=variables, check=False).returncode
    except OSError as e:
        print(
            f"error: {program}: can't be started: {e.strerror or e} (install vertibench again, or set VB_HARNESS)",
            file=sys.stderr,
        )
        return 3


if __name__ == "__main__":
    sys.exit(main())
