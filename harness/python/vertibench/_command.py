"""How the commands of this package end."""

from __future__ import annotations

import sys
from collections.abc import Callable

from ._errors import VertibenchError


def ended(do: Callable[[], int | None], stopped: str = "stopped") -> int:
    """Does something; its errors become a line and an exit code. `stopped` is said after Ctrl-C."""
    try:
        return int(do() or 0)
    except VertibenchError as e:
        print(f"error: {e}", file=sys.stderr)
        return 2
    except OSError as e:
        print(f"error: {e.filename or 'the system'}: {e.strerror or e} (see that it can be written there)", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        print(stopped, file=sys.stderr)
        return 130
