#!/usr/bin/env bash
# Builds the planner: ./build.sh [OUT]; default: build/pursuit-js.wasm
set -euo pipefail
cd "$(dirname "$0")"
out="${1:-build/pursuit-js.wasm}"
mkdir -p build "$(dirname "$out")"
PATH="$PWD/node_modules/.bin:$PATH"

# The QuickJS engine and the planner in one component. Without WASI, because planners have no files and no clock.
componentize-qjs --wit wit --world planner-plugin --js planner.js --stub-wasi --sync --output build/plain.wasm

"${VB_HARNESS:-vb-harness}" plugin stamp build/plain.wasm --meta planner.yaml --out "$out"
