#!/usr/bin/env bash
# Builds the planner: ./build.sh [OUT]; default: build/pursuit-c.wasm
set -euo pipefail
cd "$(dirname "$0")"
out="${1:-build/pursuit-c.wasm}"
mkdir -p build "$(dirname "$out")"

# A module of the interface's types and the planner: a reactor, that is, a library without `main`.
"${PYTHON:-python3}" -m ziglang cc --target=wasm32-wasi -mexec-model=reactor -msimd128 \
    -std=c11 -O2 -ffp-contract=off -Wall -Wextra -Werror -s \
    -o build/plain.wasm planner.c following.c gen/planner_plugin.c gen/planner_plugin_component_type.o

"${VB_HARNESS:-vb-harness}" plugin stamp build/plain.wasm --meta planner.yaml --out "$out"
