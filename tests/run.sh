#!/bin/sh
# Installs what is missing, builds, and runs every test through CTest: everything in Release, each in a process of its
# own; under the address and undefined-behaviour sanitizers all but the longest scenes, with a quarter of the random
# ones, a folder in eight processes (CMakePresets.json; all of them: ctest --test-dir build/asan-ubsan). Ends with
# a line of what passed and what did not.
#
#   tests/run.sh            everything
#   tests/run.sh release    Release only
#   tests/run.sh asan-ubsan sanitizers only
set -eu
cd "$(dirname "$0")/.."
. .ci/setup.sh

# shellcheck disable=SC2086  # the lists are meant to be split
install_missing $SKERRY_BUILD_PACKAGES $SKERRY_TEST_PACKAGES

presets=${1:-release asan-ubsan}
status=0
passed=
failed=
for preset in $presets; do
  case $preset in
  release | asan-ubsan) ;;
  *) die "no preset \"$preset\"; there are release and asan-ubsan" ;;
  esac
  configure "$preset"
  build "$preset"
  say "testing build/$preset"
  if ctest --preset "$preset" --parallel "$(nproc)"; then
    passed="$passed $preset ($(ctest --preset "$preset" --show-only | sed -n 's/^Total Tests: //p') tests)"
  else
    status=$?
    failed="$failed $preset"
  fi
done
[ -z "$passed" ] || say "passed:$passed"
[ -z "$failed" ] || say "FAILED:$failed"
exit $status
