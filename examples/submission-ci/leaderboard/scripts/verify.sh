#!/bin/sh
# verify.sh IN OUT: verifies IN/submission with IN/planner.wasm, as collect.sh left them. Nothing of IN is executed but the
# planner, in the harness's sandbox. Leaves in OUT: verification.json and comment.md. Ends with the harness's exit code: 0 if it
# verifies, 9 if not.
#   VB_HARNESS  the harness [vb-harness]
#   VB_SAMPLE   number of tasks that are driven again [50]
#   VB_OPEN     1: the open division may enter, too
set -eu
in=$1 out=$2
harness=${VB_HARNESS:-vb-harness}
mkdir -p "$out"
# A link could lead what is read and removed below to anywhere.
if [ -n "$(find "$in" -type l)" ]; then
    echo "**This submission does not verify.** It holds links." | tee "$out/comment.md"
    exit 9
fi
ranked=--ranked
[ "${VB_OPEN:-}" = 1 ] && ranked=
# A verdict that came along is the stranger's own.
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
    # Indented text is shown as it is: nothing in it can become a link or a mention.
    sed 's/^/    /' "$out/told.txt"
    grep '^error:' "$out/errors.txt" | sed 's/^/    /' || true
} >"$out/comment.md"
cat "$out/comment.md"
exit "$code"
