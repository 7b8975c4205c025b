#!/usr/bin/env bash
# Builds the planner: ./build.sh [OUT]; default: build/pursuit-python.wasm
set -euo pipefail
cd "$(dirname "$0")"
out="${1:-build/pursuit-python.wasm}"
mkdir -p build "$(dirname "$out")"

# Python itself, the planner and what it imports in one component. Not with --stub-wasi: what the harness gives of WASI lets
# `print` reach the log and `time` tell simulated time, which would both trap.
componentize-py --wit-path wit --world planner-plugin componentize --python-path . guest -o build/plain.wasm

"${VB_HARNESS:-vb-harness}" plugin stamp build/plain.wasm --meta planner.yaml --out "$out"
