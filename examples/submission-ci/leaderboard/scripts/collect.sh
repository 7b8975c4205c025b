#!/bin/sh
# collect.sh ENTRY OUT: collects the submission of a pull request (ENTRY is incoming/NAME in its checkout) in OUT: planner.wasm and
# submission. If ENTRY has source/build.sh, the planner is built with it: this is the only place where untrusted code runs
# outside the sandbox. Run it on an isolated machine without secrets, and treat its output as untrusted.
set -eu
entry=$1 out=$2
mkdir -p "$out"
if [ -f "$entry/source/build.sh" ]; then
    # An absolute path, because the build runs in another folder.
    target=$(cd "$out" && pwd)/planner.wasm
    (cd "$entry/source" && env -i HOME="$HOME" PATH="$PATH" sh build.sh "$target")
else
    cp "$entry/planner.wasm" "$out/planner.wasm"
fi
cp -R "$entry/submission" "$out/submission"
