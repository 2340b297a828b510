#!/bin/sh
# Records demos to captures/*.mp4 on a bare Debian 12: installs what is missing, builds, captures.
#
#   demos/capture.sh                               all demos
#   demos/capture.sh newtons_cradle stack          these
#   demos/capture.sh newtons_cradle --matrix       options go on to `skerry capture` (see its --help)
#
# Ends with one line a file: name, seconds, frames, frames/s, size. A second run installs and builds nothing.
set -eu
caller=$PWD
cd "$(dirname "$0")/.."
root=$PWD
. .ci/setup.sh

# shellcheck disable=SC2086  # the list is meant to be split
install_missing $SKERRY_BUILD_PACKAGES
# A folder of its own: no tests, so that it needs no test libraries.
if [ ! -f build/capture/build.ninja ]; then
  say "configuring build/capture"
  mkdir -p build/capture
  cmake -S . -B build/capture -G Ninja -DCMAKE_BUILD_TYPE=Release -DSKERRY_TESTS=OFF -DSKERRY_BENCH=OFF \
    >build/capture/configure.log 2>&1 || {
    cat build/capture/configure.log >&2
    die "configuring failed (build/capture/configure.log)"
  }
fi
build capture skerry

mkdir -p captures
# An own -o wins; otherwise everything goes to captures/. Paths are those of the caller.
cd "$caller"
for word in "$@"; do
  case $word in
  -o | -o?* | --out | --out=*) exec "$root/build/capture/skerry" capture --demos "$root/demos" "$@" ;;
  esac
done
exec "$root/build/capture/skerry" capture --demos "$root/demos" -o "$root/captures/" "$@"
