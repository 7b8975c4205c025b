#!/bin/sh
# collect.sh ENTRY OUT: gathers what a pull request proposes (ENTRY is incoming/NAME in its checkout) in OUT: planner.wasm and
# submission. If ENTRY has source/build.sh, the planner is built by it: this is the only place where a stranger's program runs
# outside of the sandbox. Run it where there is nothing to steal and nothing to break; trust nothing of what it leaves.
set -eu
entry=$1 out=$2
mkdir -p "$out"
if [ -f "$entry/source/build.sh" ]; then
    # An absolute path, since the build runs in its own folder.
    target=$(cd "$out" && pwd)/planner.wasm
    (cd "$entry/source" && env -i HOME="$HOME" PATH="$PATH" sh build.sh "$target")
else
    cp "$entry/planner.wasm" "$out/planner.wasm"
fi
cp -R "$entry/submission" "$out/submission"
