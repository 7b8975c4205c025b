#!/bin/sh
# accept.sh IN VERDICT NAME: adds a verified submission to the checkout in the working directory, as accepted/NAME and
# plugins/NAME.wasm, on a branch accept/NAME. VERDICT is the output folder of verify.sh. Existing entries are never replaced.
set -eu
in=$1 verdict=$2 name=$3
case $name in
'' | .* | *[!A-Za-z0-9._-]*) echo "not a name for an entry: $name" >&2; exit 2 ;;
esac
if [ -e "accepted/$name" ] || [ -e "plugins/$name.wasm" ]; then
    echo "there is an entry $name: choose another name" >&2
    exit 2
fi
git checkout --quiet -b "accept/$name"
mkdir -p accepted plugins
cp -R "$in/submission" "accepted/$name"
rm -f "accepted/$name/holdout.json"
cp "$verdict/verification.json" "accepted/$name/verification.json"
cp "$in/planner.wasm" "plugins/$name.wasm"
git add "accepted/$name" "plugins/$name.wasm"
git commit --quiet -m "Accept $name"
