#!/bin/sh
# Draws the stills of this folder from stills.txt, and README.md from `skerry list`.
#
#   captures/stills.sh              all demos
#   captures/stills.sh arch stack   these
#   SKERRY=build/native/skerry captures/stills.sh     another program, by the caller's path
set -eu
case ${1:-} in
-h | --help)
  sed -n '2,/^set /{/^#/s/^# \{0,1\}//p;}' "$0"
  exit 0
  ;;
esac
case ${SKERRY:-} in
"" | /*) ;;
*) SKERRY=$PWD/$SKERRY ;;
esac
cd "$(dirname "$0")/.."
skerry=${SKERRY:-build/release/skerry}
[ -x "$skerry" ] || { echo "$skerry: no program; build first: tests/run.sh release" >&2; exit 4; }
size="--size 960x540"

list=$("$skerry" list --demos demos)
names=$(printf '%s\n' "$list" | sed -n 's/^  \([^ ]*\) - .*/\1/p')
seconds=$("$skerry" list --demos demos --json | sed -n 's/^    "name": "\(.*\)",$/\1/p; s/^    "seconds": \([0-9.e+-]*\),$/\1/p' | paste - -)

# row NAME: what follows the name in stills.txt, single-spaced; without a row a moment of the demo's middle
row() {
  row=$(awk -v name="$1" '$1 == name { $1 = ""; sub(/^ /, ""); print; exit }' captures/stills.txt)
  [ -n "$row" ] || row=$(printf '%s\n' "$seconds" | awk -v name="$1" '$1 == name { printf "%.2f", 0.4 * $2; exit }')
  printf '%s' "$row"
}

for demo in "$@"; do
  printf '%s\n' "$names" | grep -qxF -e "$demo" || {
    echo "no demo \"$demo\" (names: skerry list)" >&2
    exit 3
  }
done

for demo in ${*:-$names}; do
  # shellcheck disable=SC2046  # options are words
  "$skerry" capture "$demo" --demos demos --at $(row "$demo") $size --small -o "captures/$demo.png"
done

{
  echo "# Gallery"
  echo
  echo "A still of each demo with the command that draws it. \`captures/stills.sh\` draws all of them again and writes"
  echo "this page; \`demos/capture.sh NAME\` records the video. What a still shows is checked: \`skerry test NAME\`."
  printf '%s\n' "$list" | while IFS= read -r line; do
    case $line in
    "    --set"*) ;;
    "    "*) printf '%s\n' "${line#    }" ;;
    "  "*)
      name=${line#  }
      name=${name%% - *}
      printf '\n### %s\n\n![%s](%s.png)\n\n`skerry capture %s --at %s -o %s.png`\n\n' \
        "${line#* - }" "${line#* - }" "$name" "$name" "$(row "$name") $size --small" "$name"
      ;;
    *) printf '\n## %s\n' "$(printf '%s' "$line" | tr '_' ' ' | awk '{ print toupper(substr($0, 1, 1)) substr($0, 2) }')" ;;
    esac
  done
} >captures/README.md
echo "captures/README.md: $(grep -c '^### ' captures/README.md) demos"
