#!/bin/sh
# only_eight_lanes.sh NM OBJECT: fails if the object defines a function that the linker may share with files that
# were compiled for every processor.
set -eu
symbols=$("$1" -C --defined-only "$2")
echo "$symbols" | grep -q eight_lanes || { echo "$2 has no functions for eight lanes"; exit 1; }
shared=$(echo "$symbols" | grep -E ' [TWVu] ' | grep -v -e eight_lanes -e DW.ref || true)
[ -z "$shared" ] || { echo "$shared"; exit 1; }
