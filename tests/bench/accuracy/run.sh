#!/bin/sh
# Installs what is missing, other engines included, builds accuracy_bench, runs it and draws its tables and plots.
#
#   tests/bench/accuracy/run.sh [DIR] [part...]     DIR: default build/accuracy; parts: precision stress scaling
#                                                   skips demos (default: all, half an hour)
set -eu
cd "$(dirname "$0")/../../.."
. .ci/setup.sh
out=${1:-build/accuracy}
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- precision stress scaling skips demos

# shellcheck disable=SC2086  # the lists are meant to be split
install_missing $SKERRY_BUILD_PACKAGES $SKERRY_TEST_PACKAGES $SKERRY_PEER_PACKAGES
# Always, since engines may have been installed after the last time.
say "configuring build/release"
cmake --preset release >/dev/null
build release accuracy_bench
build/release/tests/bench/accuracy/accuracy_bench "$@" -o "$out"
/usr/bin/python3 tests/bench/accuracy/report.py "$out"
echo "$out/tables.md and $out/plots/"
