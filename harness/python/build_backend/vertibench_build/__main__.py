"""`python -m vertibench_build wheel|sdist|release DIR`: what pip does in a folder of its own, with the maturin that is there,
and the archive of a release."""

from __future__ import annotations

import sys
from pathlib import Path

from . import _release, build_sdist, build_wheel

if __name__ == "__main__":
    makers = {"wheel": build_wheel, "sdist": build_sdist, "release": _release.make}
    make = makers.get(sys.argv[1] if len(sys.argv) == 3 else "")
    if not make:
        sys.exit("error: want wheel, sdist or release, and a folder")
    out = Path(sys.argv[2]).absolute()
    out.mkdir(parents=True, exist_ok=True)
    print(out / make(out))
