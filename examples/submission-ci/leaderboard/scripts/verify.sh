#!/bin/sh
# verify.sh IN OUT: verifies IN/submission with IN/planner.wasm from collect.sh. Of IN only the planner is executed, in the
# harness's sandbox. Writes verification.json and comment.md to OUT. Exits with the harness's exit code: 0 if verified, 9 if not.
#   VB_HARNESS  the harness [vb-harness]
#   VB_SAMPLE   number of re-run tasks [50]
#   VB_OPEN     1: also accepts the open division
set -eu
in=$1 out=$2
harness=${VB_HARNESS:-vb-harness}
mkdir -p "$out"
# A link could redirect the paths that are read and removed below.
if [ -n "$(find "$in" -type l)" ]; then
    echo "**This submission does not verify.** It holds links." | tee "$out/comment.md"
    exit 9
fi
ranked=--ranked
[ "${VB_OPEN:-}" = 1 ] && ranked=
# An included verdict is untrusted.
rm -rf "$out/verification.json" "$in/submission/verification.json" "$in/submission/holdout.json"
code=0
# shellcheck disable=SC2086 # nothing, if empty
"$harness" verify "$in/submission" --plugin "$in/planner.wasm" --sample "${VB_SAMPLE:-50}" $ranked \
    --out "$out/verification.json" >"$out/told.txt" 2>"$out/errors.txt" || code=$?
{
    case $code in
    0) echo "**This submission verifies.**" ;;
    9) echo "**This submission does not verify.**" ;;
    *) echo "**This submission could not be verified** (exit code $code)." ;;
    esac
    echo
    # Indented text is shown verbatim: it cannot contain links or mentions.
    sed 's/^/    /' "$out/told.txt"
    grep '^error:' "$out/errors.txt" | sed 's/^/    /' || true
} >"$out/comment.md"
cat "$out/comment.md"
exit "$code"
