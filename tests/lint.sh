#!/bin/sh
# Checks the sources with clang-format and clang-tidy (configurations in the tree). Needs a configured build/release.
#
#   tests/lint.sh            all files
#   tests/lint.sh FILE...    these
set -eu
cd "$(dirname "$0")/.."
[ -f build/release/compile_commands.json ] || { echo "run first: cmake --preset release" >&2; exit 4; }
if [ $# -eq 0 ]; then
  # shellcheck disable=SC2046  # no file name has a blank
  set -- $(git ls-files '*.cpp' '*.h')
fi
clang-format --dry-run --Werror "$@"
echo "clang-format: $# files"
printf '%s\n' "$@" | grep '\.cpp$' | xargs -P "$(nproc)" -n 4 clang-tidy -p build/release --quiet
echo "clang-tidy: passed"
