#!/bin/sh
# submit.sh OUT: builds the planner, runs the suite, and writes OUT/planner.wasm and OUT/submission.
#   VB_HARNESS  the harness [vb-harness]
#   VB_SUITE    the suite [vb-100]
#   VB_ENTRANT  name of the entrant
#   VB_NOTE     one-sentence description of the planner
set -eu
out=$1
here=$(dirname "$0")
harness=${VB_HARNESS:-vb-harness}
mkdir -p "$out"
sh "$here/build.sh" "$out/planner.wasm"
"$harness" check "$out/planner.wasm" --suite "${VB_SUITE:-vb-100}"
"$harness" submit "$out/planner.wasm" --suite "${VB_SUITE:-vb-100}" --out "$out/submission" \
    --entrant "${VB_ENTRANT:-}" --note "${VB_NOTE:-}"
