#!/bin/sh
# SPDX-License-Identifier: MIT
# Pair finding, all of it: every implementation and every peer, on every distribution, for 1e3 to 1e6 boxes.
#   tests/bench/broadphase.sh [OUT [SIZES [BENCH]]]
# writes OUT/broadphase.csv, OUT/crossover.svg (time a body against the number of bodies), OUT/tables.md (times, bytes,
# ratios) and OUT/broadphase.log (the machine, versions). All of it takes about 25 minutes of an idle core.
# OUT is a folder, ./broadphase by default; SIZES for example "1000 10000"; BENCH the program, by default that of
# the preset `release`. Every size runs in a process of its own, so that a run cut off keeps the sizes before.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
out=${1:-broadphase}
sizes=${2:-1000 10000 100000 1000000}
bench=${3:-$here/../../build/release/tests/bench/broadphase_bench}
. "$here/../../.ci/setup.sh"
# shellcheck disable=SC2086  # the list is meant to be split
install_missing $SKERRY_PEER_PACKAGES
mkdir -p "$out"
: > "$out/broadphase.csv"
: > "$out/broadphase.log"
for n in $sizes; do
  echo "broadphase: $n boxes" >&2
  "$bench" --benchmark_filter="/$n/" --benchmark_min_time=0.05 --benchmark_format=csv \
    > "$out/$n.csv" 2>> "$out/broadphase.log"
  # One header for all.
  if [ -s "$out/broadphase.csv" ]; then grep '^"' "$out/$n.csv"; else cat "$out/$n.csv"; fi >> "$out/broadphase.csv"
  rm "$out/$n.csv"
  /usr/bin/python3 "$here/broadphase_plot.py" "$out/broadphase.csv" "$out/crossover.svg" "$out/tables.md"
done
echo "$out/broadphase.csv $out/crossover.svg" >&2
