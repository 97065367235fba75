#!/usr/bin/env bash
# All variants of the lanes give the same bits: compare_lane_bits.sh REFERENCE PROGRAM... Each is tests/simd/lane_bits.cpp,
# built for a variant. One whose name ends in v4 is left out where the processor has no AVX-512.
set -euo pipefail
expected=$("$1")
[ "$(wc -l <<<"$expected")" -ge 15 ] || { echo "the reference prints too little: $expected" >&2; exit 1; }
shift
for program in "$@"; do
  case "$program" in
    *v4) grep -q avx512vl /proc/cpuinfo || { echo "$program: left out, no AVX-512 here"; continue; } ;;
  esac
  found=$("$program")
  if [ "$found" != "$expected" ]; then
    echo "$program: other bits than the reference:" >&2
    diff <(echo "$expected") <(echo "$found") >&2
    exit 1
  fi
  echo "$program: the same bits"
done
