#!/bin/sh
# Shared by demos/capture.sh and tests/run.sh: installs missing Debian packages, configures, builds.
# Source it from the root of the tree; it defines functions only.

# shellcheck shell=sh disable=SC2034  # the lists are for the scripts that source this file

# To build and run the sandbox.
SKERRY_BUILD_PACKAGES="g++ cmake ninja-build pkg-config ccache libeigen3-dev libimgui-dev libegl-dev libgl-dev
libegl1 libegl-mesa0 libgl1-mesa-dri libepoxy-dev libstb-dev libavcodec-dev libavformat-dev libavutil-dev
libdeflate-dev libglfw3-dev liblua5.4-dev libcli11-dev nlohmann-json3-dev fonts-dejavu-core
coinor-libclp-dev"
# To build and run the tests and benchmarks besides (ffmpeg brings ffprobe; chromium
# opens the report of golden images).
SKERRY_TEST_PACKAGES="libgtest-dev libgmock-dev libbenchmark-dev ffmpeg xvfb xdotool libxml2-utils
chromium"
# To compare with other engines and to draw the plots of that (tests/bench/).
SKERRY_PEER_PACKAGES="libbox2d-dev libchipmunk-dev libbullet-dev libode-dev libcgal-dev libboost-dev
python3-matplotlib"

say() { printf '== %s\n' "$*" >&2; }
die() { printf 'error: %s\n' "$*" >&2; exit 4; }

# install_missing PACKAGE...: asks dpkg first, so that a complete machine needs neither root nor network.
install_missing() {
  command -v dpkg-query >/dev/null || die "this script installs with apt; on other systems install: $*"
  missing=""
  for package in "$@"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing="$missing $package"
  done
  if [ -z "$missing" ]; then return 0; fi
  say "installing:$missing"
  as_root=""
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || die "neither root nor sudo; install these first:$missing"
    as_root="sudo"
  fi
  # shellcheck disable=SC2086  # the list is meant to be split
  {
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get update -qq >&2 &&
      $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >&2
  } || die "apt-get could not install:$missing"
}

# configure PRESET [OPTION...]: only when the build folder is new or an option is given.
configure() {
  preset=$1
  shift
  if [ -f "build/$preset/build.ninja" ] && [ $# -eq 0 ]; then return 0; fi
  say "configuring build/$preset"
  mkdir -p "build/$preset"
  cmake --preset "$preset" "$@" >"build/$preset/configure.log" 2>&1 || {
    cat "build/$preset/configure.log" >&2
    die "configuring failed (build/$preset/configure.log)"
  }
}

# build PRESET [TARGET...]
build() {
  preset=$1
  shift
  say "building build/$preset"
  if [ $# -gt 0 ]; then set -- --target "$@"; fi
  cmake --build "build/$preset" --parallel "$(nproc)" "$@" >&2 || die "the build of build/$preset failed"
}
