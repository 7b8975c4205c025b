"""`python -m vertibench_build wheel|sdist DIR`: what pip does in a folder of its own, with the maturin that is there."""

from __future__ import annotations

import sys
from pathlib import Path

from . import build_sdist, build_wheel

if __name__ == "__main__":
    make = {"wheel": build_wheel, "sdist": build_sdist}.get(sys.argv[1] if len(sys.argv) == 3 else "")
    if not make:
        sys.exit("error: want wheel or sdist, and a folder")
    Path(sys.argv[2]).mkdir(parents=True, exist_ok=True)
    print(Path(sys.argv[2], make(sys.argv[2])).absolute())
