#!/usr/bin/env bash
# Builds the fuzz targets with clang in a folder of their own, and runs one of them on its corpus and beyond.
#   run_fuzz.sh BUILD_FOLDER build
#   run_fuzz.sh BUILD_FOLDER config|csv|journal|part SECONDS [options of libFuzzer]
# A finding ends it with an error, the input is kept in BUILD_FOLDER/found: mend it, and make a unit test of it.
# Exit 77: skipped, since clang or its libFuzzer is missing.
set -euo pipefail
[ $# -ge 2 ] || { sed -n '2,6s/^# //p' "$0" >&2; exit 64; }
here=$(cd "$(dirname "$0")" && pwd)
source_folder=$(cd "$here/../.." && pwd)
mkdir -p "$1"
build=$(cd "$1" && pwd) target=$2
if ! command -v clang++-19 >/dev/null || ! ls "$(clang++-19 -print-resource-dir)"/lib/linux/libclang_rt.fuzzer-*.a >/dev/null 2>&1; then
  echo "skipped: no clang with libFuzzer (Debian: clang-19 libclang-rt-19-dev)"
  exit 77
fi

if [ "$target" = build ]; then
  cd "$source_folder"
  cmake --preset asan -B "$build" >/dev/null
  exec cmake --build "$build" --target fuzz_targets
fi

seconds=${3:?how many seconds}
program=$build/tests/fuzz/fuzz_$target
[ -x "$program" ] || { echo "run_fuzz.sh: $program is missing: run_fuzz.sh $1 build" >&2; exit 1; }
mkdir -p "$build/found" "$build/corpus/$target"
seeds=("$here/corpus/$target")
[ "$target" != config ] || seeds+=("$source_folder/configs/smoke" "$source_folder/configs/examples")
[ "$target" != csv ] || seeds+=("$source_folder/configs/examples")
# 64 kB a file; 1 GB of memory and 10 s for one input are findings, too. A finding must not end with 77, libFuzzer's own choice:
# ctest would take it for a test that was skipped.
exec "$program" -max_total_time="$seconds" -max_len=65536 -rss_limit_mb=1024 -timeout=10 -error_exitcode=1 -print_final_stats=1 -print_funcs=0 -verbosity=0 \
  -artifact_prefix="$build/found/$target-" "${@:4}" "$build/corpus/$target" "${seeds[@]}"
