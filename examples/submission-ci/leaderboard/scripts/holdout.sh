#!/bin/sh
# holdout.sh NAME: scores plugins/NAME.wasm on the hidden suite and writes the scores to accepted/NAME/holdout.json.
#   VB_HARNESS        the harness [vb-harness]
#   VB_HOLDOUT_SEED   the hidden suite's seed, a secret: 64 random bits
#   VB_HOLDOUT_WORLDS number of its worlds [100]
set -eu
name=$1
harness=${VB_HARNESS:-vb-harness}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# The output of the generator would reveal the suite.
"$harness" suite generate --seed "$VB_HOLDOUT_SEED" --worlds "${VB_HOLDOUT_WORLDS:-100}" --name holdout \
    --out "$work/holdout" >/dev/null 2>&1 || { echo "the hidden suite could not be made" >&2; exit 1; }
"$harness" evaluate "plugins/$name.wasm" --suite "$work/holdout" --out "accepted/$name/holdout.json" --force
