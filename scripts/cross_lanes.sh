#!/usr/bin/env bash
# The lanes give the same bits on other processors: scripts/cross_lanes.sh REFERENCE builds tests/simd/lane_bits.cpp by Debian's
# cross compiler for aarch64 and by the compiler of this machine for any x86-64 (no AVX, no FMA), runs the first under
# qemu-user, and compares what they print with what REFERENCE prints, the program as it is built here. Exit 77 where the
# compiler or the emulator is missing: scripts/bootstrap.sh cross installs them.
set -euo pipefail
cd "$(dirname "$0")/.."
for tool in aarch64-linux-gnu-g++ qemu-aarch64; do
  command -v "$tool" >/dev/null || { echo "skipped: no $tool"; exit 77; }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
flags=(-std=c++20 -O2 -Ilib -ffp-contract=off -fno-math-errno -fno-trapping-math -fsigned-char -Wno-psabi -DSURVEYMC_PORTABLE)
aarch64-linux-gnu-g++ "${flags[@]}" -static tests/simd/lane_bits.cpp -o "$folder/aarch64"
g++ "${flags[@]}" tests/simd/lane_bits.cpp -o "$folder/x86-64"
printf '#!/bin/sh\nexec qemu-aarch64 %s\n' "$folder/aarch64" >"$folder/aarch64.sh"
chmod +x "$folder/aarch64.sh"
tests/simd/compare_lane_bits.sh "$1" "$folder/aarch64.sh" "$folder/x86-64"
