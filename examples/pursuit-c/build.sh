#!/usr/bin/env bash
# Builds the planner: ./build.sh [OUT]; default: build/pursuit-c.wasm
set -euo pipefail
cd "$(dirname "$0")"
out="${1:-build/pursuit-c.wasm}"
mkdir -p build "$(dirname "$out")"

# A module of the interface's types and the planner: a reactor (a library without `main`).
"${PYTHON:-python3}" -m ziglang cc --target=wasm32-wasi -mexec-model=reactor -msimd128 \
    -std=c11 -O2 -ffp-contract=off -Wall -Wextra -Werror \
    -o build/plain.wasm planner.c following.c gen/planner_plugin.c gen/planner_plugin_component_type.o

# Keeps function names for trap messages, and strips debug information, which is large and contains local paths. The
# compiler's options strip both or none.
"${PYTHON:-python3}" - build/plain.wasm <<'EOF'
import sys


def number(data, at):
    """A number of seven bits a byte, and where it ends."""
    value = shift = 0
    while True:
        byte = data[at]
        value, shift, at = value | (byte & 127) << shift, shift + 7, at + 1
        if byte < 128:
            return value, at


with open(sys.argv[1], "rb") as file:
    data = file.read()
kept, at = data[:8], 8
while at < len(data):
    size, start = number(data, at + 1)
    length, name = number(data, start)
    is_for_debuggers = data[at] == 0 and data[name : name + length].startswith(b".debug")
    kept, at = kept + (b"" if is_for_debuggers else data[at : start + size]), start + size
with open(sys.argv[1], "wb") as file:
    file.write(kept)
EOF

"${VB_HARNESS:-vb-harness}" plugin stamp build/plain.wasm --meta planner.yaml --out "$out"
