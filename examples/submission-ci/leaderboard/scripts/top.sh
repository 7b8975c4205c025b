#!/bin/sh
# top.sh OUT: re-runs all tasks of the entries in the first ranks that were verified with a sample; a sample may miss a few
# forged tasks (docs/leaderboard.md of the harness has the table). A positive verdict replaces that in accepted/NAME. Entries that
# fail are listed in OUT/comment.md, and the exit code is 9: remove them.
#   VB_HARNESS  the harness [vb-harness]
#   VB_TOP      number of ranks of each board [3]
set -eu
out=$1
harness=${VB_HARNESS:-vb-harness}
mkdir -p "$out"
: >"$out/comment.md"
"$harness" leaderboard build accepted --out "$out/site" --force
# Names of entries consist of letters, digits, '-', '_' and '.'.
names=$(jq -r --argjson top "${VB_TOP:-3}" '.boards[].entries[]
    | select(.rank <= $top and (.verified.tasks_driven_again // 0) < .tasks) | .id' "$out/site/leaderboard.json")
code=0
for name in $names; do
    # The verdict of the sample remains until all tasks are verified.
    if "$harness" verify "accepted/$name" --plugin "plugins/$name.wasm" --out "$out/$name.json" >"$out/$name.txt" 2>&1; then
        cp "$out/$name.json" "accepted/$name/verification.json"
        echo "$name: all tasks verify" | tee -a "$out/comment.md"
    else
        code=9
        echo "**$name does not verify with all tasks.**" | tee -a "$out/comment.md"
        sed 's/^/    /' "$out/$name.txt" | tee -a "$out/comment.md"
    fi
done
exit "$code"
