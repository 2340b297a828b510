#!/bin/sh
# The expected state hashes of tests/trajectory/trajectories.txt with other compilers and settings: builds the physics and its
# world tests alone in each of them, and runs Trajectory.*. About 3 minutes of one core for each.
#   tests/trajectory/other_builds.sh [clang-release] [gcc-debug] [clang-debug] [native]     (default: the first three)
# `native` uses every instruction of this processor; its bits may differ, so its table is compared by eye.
set -e
cd "$(dirname "$0")/../.."
[ $# -gt 0 ] || set -- clang-release gcc-debug clang-debug
for variant; do
  case $variant in
    clang-release) flags="-DCMAKE_CXX_COMPILER=clang++ -DCMAKE_C_COMPILER=clang -DCMAKE_BUILD_TYPE=Release" ;;
    clang-debug) flags="-DCMAKE_CXX_COMPILER=clang++ -DCMAKE_C_COMPILER=clang -DCMAKE_BUILD_TYPE=Debug" ;;
    gcc-debug) flags="-DCMAKE_CXX_COMPILER=g++ -DCMAKE_C_COMPILER=gcc -DCMAKE_BUILD_TYPE=Debug" ;;
    native) flags="-DCMAKE_BUILD_TYPE=Release -DSKERRY_NATIVE=ON" ;;
    *) echo "other_builds.sh: no variant '$variant'" >&2; exit 2 ;;
  esac
  build=build/trajectories-$variant
  # shellcheck disable=SC2086
  cmake -S . -B "$build" -G Ninja $flags -DSKERRY_RENDER=OFF -DSKERRY_BENCH=OFF -DSKERRY_INSTALL=OFF >/dev/null
  cmake --build "$build" -j "${JOBS:-2}" --target trajectory_tests >/dev/null
  echo "== $variant"
  "$build/tests/trajectory_tests" --gtest_brief=1
done
