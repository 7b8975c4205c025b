#!/bin/sh
# site.sh OUT: builds the site of all accepted submissions, and replaces an earlier one.
#   VB_HARNESS  the harness [vb-harness]
#   VB_TITLE    title of the leaderboard
set -eu
"${VB_HARNESS:-vb-harness}" leaderboard build accepted --out "$1" --force --title "${VB_TITLE:-Verti-Bench leaderboard}"
