#!/bin/sh
# Installs a build into a folder of its own and uses it as a stranger would: find_package, pkg-config, subproject.
#   tests/package/test.sh BUILD_DIR WORK_DIR
set -eu
build=$1
work=$2
source=$(cd "$(dirname "$0")/../.." && pwd)
rm -rf "$work"
mkdir -p "$work"
prefix=$work/installed

cmake --install "$build" --prefix "$prefix" >/dev/null
echo "installed: $(find "$prefix" -type f | wc -l) files"

# A header that includes what was not installed would be found here.
cmake -G Ninja -S "$source/tests/package/consumer" -B "$work/find" -DCMAKE_PREFIX_PATH="$prefix" \
  -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$work/find"
"$work/find/drop"
"$work/find/picture"
echo "find_package: physics and render"

export PKG_CONFIG_PATH="$prefix/lib/pkgconfig:$(echo "$prefix"/lib/*/pkgconfig)"
# shellcheck disable=SC2046  # flags are meant to be split
c++ -std=c++20 -O1 "$source/tests/package/consumer/drop.cpp" \
  $(pkg-config --cflags --libs skerry-physics) -o "$work/drop"
"$work/drop"
echo "pkg-config: skerry-physics"

cmake -G Ninja -S "$source/tests/package/consumer" -B "$work/sub" -DSKERRY_SOURCE="$source" >/dev/null
echo "FetchContent: configures, with everything but the library off"

(cd / && "$prefix/bin/skerry" list | grep -q newtons_cradle)
echo "program: finds its demos"
