#!/usr/bin/env bash
# Builds the planner: ./build.sh [OUT]; default: build/pursuit-python.wasm
set -euo pipefail
cd "$(dirname "$0")"
out="${1:-build/pursuit-python.wasm}"
mkdir -p build "$(dirname "$out")"

# Packages with C extensions would need WASI builds, which PyPI does not have. The compiler's message about them is a hundred
# lines long and suggests installing numpy.
found="$(grep -nE '^[[:space:]]*(import|from)[[:space:]]+(numpy|scipy|torch|pandas|cv2|sklearn|numba|jax)([[:space:].,]|$)' ./*.py | head -n 1 || true)"
if [ -n "$found" ]; then
    echo "build.sh: $found: only pure Python packages work in WebAssembly (a planner with numpy runs as a command, unranked: see README.md)" >&2
    exit 1
fi

# Python, the planner and its imports in one component. Without --stub-wasi, because the harness implements WASI for `print`
# (task log) and `time` (simulated time), which would trap otherwise.
componentize-py --wit-path wit --world planner-plugin componentize --python-path . guest -o build/plain.wasm

"${VB_HARNESS:-vb-harness}" plugin stamp build/plain.wasm --meta planner.yaml --out "$out"
