#!/bin/sh
# Draws the stills of this folder and its page again: one line of the table below a picture.
set -eu
cd "$(dirname "$0")/.."
skerry=build/release/skerry
[ -x "$skerry" ] || { echo "build first: tests/run.sh release" >&2; exit 4; }
{
  echo "# Gallery"
  echo
  echo "Stills of the demos; \`captures/stills.sh\` draws all of them, the line under a picture that one."
  echo "\`demos/capture.sh NAME\` records the video beside them."
} >captures/README.md
while read -r demo at options; do
  # shellcheck disable=SC2086  # options are words
  "$skerry" capture "$demo" --at "$at" $options -o "captures/$demo.png" >/dev/null
  {
    echo
    echo "![$demo]($demo.png)"
    echo
    echo "\`skerry capture $demo --at $at${options:+ $options} -o captures/$demo.png\`"
  } >>captures/README.md
done <<TABLE
newtons_cradle 0.60
newtons_cradle_free 1.00 --matrix
free_fall 1.25
stack 1.50
see_saw 1.00
four_body_chain 1.05
impact_laws 1.20
TABLE
echo "captures/README.md and $(ls captures/*.png | wc -l) stills"
