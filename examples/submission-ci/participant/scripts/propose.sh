#!/bin/sh
# propose.sh OUT REMOTE NAME: pushes planner and submission of OUT as incoming/NAME to the branch submit/NAME of REMOTE, your
# fork of the leaderboard's repository. Then open a pull request from it.
set -eu
out=$1 remote=$2 name=$3
case $name in
'' | .* | *[!A-Za-z0-9._-]*) echo "name: letters, digits, '-', '_' and '.' only: $name" >&2; exit 2 ;;
esac
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
git clone --quiet --depth 1 "$remote" "$work/board"
mkdir -p "$work/board/incoming/$name"
cp -R "$out/planner.wasm" "$out/submission" "$work/board/incoming/$name/"
cd "$work/board"
git checkout --quiet -b "submit/$name"
git add "incoming/$name"
git commit --quiet -m "Submission $name"
git push --quiet origin "submit/$name"
echo "pushed submit/$name: open a pull request from it"
