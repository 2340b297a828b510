#!/bin/sh
# Error against wall time of the steppers: writes stepping.csv and stepping.svg (one panel a scene) to a folder. About 5 s on an idle machine.
#   tests/bench/stepping.sh [FOLDER] [BUILD]     (defaults: the present folder, build/release)
set -e
here=$(dirname "$0")
out=${1:-.}
build=${2:-$here/../../build/release}
mkdir -p "$out"
"$build/tests/bench/stepping_bench" > "$out/stepping.csv"
python3 "$here/stepping_plot.py" "$out/stepping.csv" "$out/stepping.svg"
echo "$out/stepping.csv $out/stepping.svg"
