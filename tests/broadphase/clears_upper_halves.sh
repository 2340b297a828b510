#!/bin/sh
# clears_upper_halves.sh OBJDUMP FILE...: fails if a function of these objects or libraries writes registers of more
# than 128 bits and never clears their upper halves: code without AVX that runs after it would keep them with every
# instruction, at up to twice the time. g++ 12 forgets it before a call that is the last thing in a function.
set -eu
list=$(mktemp)
trap 'rm -f "$list"' EXIT
objdump=$1
shift
"$objdump" --disassemble --demangle --no-show-raw-insn "$@" >"$list"
awk '
  function note() {
    if (wide) ++functions
    if (wide && !clears) { print "leaves its upper halves: " name; ++bad }
  }
  /^[0-9a-f]+ <.*>:$/ { note(); name = $0; wide = clears = 0; next }
  /%[yz]mm/ { wide = 1 }
  /vzeroupper/ { clears = 1 }
  END {
    note()
    print functions + 0 " functions with wide registers, " bad + 0 " that leave their upper halves"
    exit bad > 0 || functions == 0
  }' "$list"
