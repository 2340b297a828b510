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

# Whoever installs the package can build against it: what its .pc file links and requires comes with it.
if command -v dpkg-query >/dev/null && dpkg-query -W coinor-libclp-dev >/dev/null 2>&1; then
  # The names in a Depends, one a line.
  dependencies() { tr ',|' '\n' | sed 's/([^)]*)//; s/:any//; s/ //g' | sort -u; }
  sed -n 's/^set(CPACK_DEBIAN_PACKAGE_DEPENDS "\(.*\)")$/\1/p' "$build/CPackConfig.cmake" |
    dependencies >"$work/brought"
  # What dependencies bring along in their turn, twice.
  for _ in 1 2; do
    # shellcheck disable=SC2046  # names are meant to be split
    dpkg-query -W -f '${Depends}, ${Package}, ' $(cat "$work/brought") 2>/dev/null | dependencies >"$work/more"
    mv "$work/more" "$work/brought"
  done
  for module in $(pkg-config --print-requires skerry-physics); do
    echo "$(pkg-config --variable=pcfiledir "$module")/$module.pc"
  done >"$work/needed"
  for library in $(pkg-config --libs-only-l skerry-physics | sed 's/-l//g'); do
    [ "$library" = skerry_physics ] && continue
    file=$(c++ -print-file-name="lib$library.so")
    echo "$(cd "$(dirname "$file")" && pwd)/$(basename "$file")"
  done >>"$work/needed"
  while read -r file; do
    # Which package an alternative comes from is chosen on the machine.
    case $(readlink "$file") in /etc/alternatives/*) continue ;; esac
    owner=$(dpkg -S "$file" | sed 's/:.*//')
    grep -qx "${owner:-nobody}" "$work/brought" || { echo "Depends lacks $owner, which has $file" >&2; exit 1; }
  done <"$work/needed"
  echo "package: brings $(wc -l <"$work/needed") files that are built against"

  if PKG_CONFIG_LIBDIR=/nowhere PKG_CONFIG_PATH='' cmake -G Ninja -S "$source/tests/package/consumer" -B "$work/without" \
    -DCMAKE_PREFIX_PATH="$prefix" >"$work/without.log" 2>&1; then
    echo "find_package found what is not there" >&2
    exit 1
  fi
  tr -s ' \n' ' ' <"$work/without.log" | grep -q "apt install pkg-config coinor-libclp-dev" || { cat "$work/without.log"; exit 1; }
  echo "find_package: says that Clp is missing"
fi

cmake -G Ninja -S "$source/tests/package/consumer" -B "$work/sub" -DSKERRY_SOURCE="$source" >/dev/null
echo "FetchContent: configures, with everything but the library off"

(cd / && "$prefix/bin/skerry" list | grep -q newtons_cradle)
echo "program: finds its demos"
