#!/bin/sh
# Builds accuracy_bench, runs it and draws its tables and plots.
#
#   tests/bench/accuracy/run.sh [DIR] [part...]     DIR: default build/accuracy; parts: precision stress scaling
#                                                   skips demos
set -eu
cd "$(dirname "$0")/../../.."
out=${1:-build/accuracy}
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- precision stress scaling skips demos
cmake --preset release >/dev/null
cmake --build build/release --target accuracy_bench
build/release/tests/bench/accuracy/accuracy_bench "$@" -o "$out"
/usr/bin/python3 tests/bench/accuracy/report.py "$out"
echo "$out/tables.md and $out/plots/"
