#!/bin/sh
# top.sh OUT: drives all tasks of the entries in the first ranks again, if only a sample of theirs was so far; a sample misses who
# forged few tasks (docs/leaderboard.md of the harness has the table). A good verdict replaces that in accepted/NAME. An entry that
# doesn't verify is named in OUT/comment.md, and the exit code is 9: take it out.
#   VB_HARNESS  the harness [vb-harness]
#   VB_TOP      number of ranks of each board [3]
set -eu
out=$1
harness=${VB_HARNESS:-vb-harness}
mkdir -p "$out"
: >"$out/comment.md"
"$harness" leaderboard build accepted --out "$out/site" --force
# Names of entries are plain: letters, digits, '-', '_' and '.'.
names=$(jq -r --argjson top "${VB_TOP:-3}" '.boards[].entries[]
    | select(.rank <= $top and (.verified.tasks_driven_again // 0) < .tasks) | .id' "$out/site/leaderboard.json")
code=0
for name in $names; do
    # The verdict of the sample stays until there is one of all tasks.
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
