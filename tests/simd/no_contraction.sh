#!/usr/bin/env bash
# The program has no instruction that adds one product and subtracts the next: no kernel asks for one, so a compiler has
# fused what -ffp-contract=off keeps apart, and other processors have other bits. no_contraction.sh PROGRAM
set -euo pipefail
listing=$(objdump -dC --no-show-raw-insn "$1" | awk '/^[0-9a-f]+ <.*>:$/ {name = $0} /vfmadd[123]/ {++asked} /vfm(addsub|subadd)/ {print name} END {print asked + 0}')
asked=$(tail -n 1 <<<"$listing")
[ "$asked" -gt 0 ] || { echo "no_contraction.sh: $1: no fused multiplication at all: is this the program for AVX2?" >&2; exit 1; }
found=$(head -n -1 <<<"$listing" | sort -u)
[ -z "$found" ] || { printf 'no_contraction.sh: fused by the compiler, in\n%s\n' "$found" >&2; exit 1; }
