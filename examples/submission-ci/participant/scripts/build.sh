#!/bin/sh
# build.sh OUT: builds the planner as OUT. Adapt it to your planner.
set -eu
out=$1
cargo build --release --target wasm32-unknown-unknown
set -- target/wasm32-unknown-unknown/release/*.wasm
[ $# -eq 1 ] || { echo "want one WASM file, found: $*" >&2; exit 1; }
cp "$1" "$out"
