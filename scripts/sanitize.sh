#!/usr/bin/env bash
# Tests under sanitizers, built with clang in folders of their own. A finding ends it with an error.
#   scripts/sanitize.sh asan           unit tests of the modules that read files from outside (reader_tests), but those
#                                      tagged [long]; address and undefined-behaviour sanitizers
#   scripts/sanitize.sh asan-all       all unit tests (some twenty minutes; nightly)
#   scripts/sanitize.sh tsan           the tests of the loops in threads, thread sanitizer
#   scripts/sanitize.sh tsan-studies   these, those of journals and parts, and every smoke config on three threads (nightly)
# All loops in several threads are in lib/montecarlo/threads.cpp; they call the stages of the studies. The sanitizer does not
# see how the threads of LLVM's OpenMP wait for each other, so that what that library does is ignored: threads.cpp shares by
# a lock of its own all that changes.
set -euo pipefail
cd "$(dirname "$0")/.."
if ! command -v clang++-19 >/dev/null || ! ls /usr/lib/llvm-19/lib/clang/*/lib/linux/libclang_rt.tsan-*.a >/dev/null 2>&1; then
  echo "skipped: sanitizers: no clang with its sanitizers (Debian: clang-19 libclang-rt-19-dev)"
  exit 0
fi
case "${1:-}" in
  asan | asan-all)
    cmake --preset asan >/dev/null
    tests=unit_tests left_out=
    [ "$1" = asan-all ] || tests=reader_tests left_out='~[long]~[.]'  # and, as without any choice, none of those hidden
    cmake --build build-asan --target "$tests"
    # A process for each folder's tests: to start one takes longer than most of the tests.
    folder=$(mktemp -d)
    trap 'rm -rf "$folder"' EXIT
    export left_out folder
    echo "leak:libomp.so" >"$folder/known_leaks"  # LLVM's OpenMP keeps the records of its threads to the end
    export LSAN_OPTIONS="suppressions=$folder/known_leaks print_suppressions=0"
    if [ "$1" = asan ]; then
      sed "s|^|$PWD/build-asan/tests/|" build-asan/tests/reader_tests.txt
    else
      find "$PWD/build-asan/tests" -maxdepth 1 -name '*_tests' -type f -perm -u+x | sort
    fi | xargs -P "$(nproc)" -I{} bash -c '
      name=$(basename {})
      mkdir "$folder/$name" && cd "$folder/$name" || exit
      timeout 1200 {} $left_out >"$folder/$name.log" 2>&1 && exit
      cat "$folder/$name.log"
      echo "sanitize.sh: $name failed (above)" >&2
      exit 1'
    tail -qn 2 "$folder"/*.log | grep -E 'passed|assertions'
    ;;
  tsan | tsan-studies)
    cmake --preset tsan >/dev/null
    cmake --build build-tsan --target thread_tests
    export TSAN_OPTIONS="allow_addr2line=1 halt_on_error=1 ignore_noninstrumented_modules=1 ${TSAN_OPTIONS:-}"
    build-tsan/tests/thread_tests
    [ "$1" = tsan-studies ] || exit 0
    cmake --build build-tsan --target surveymc checkpoint_tests
    build-tsan/tests/checkpoint_tests
    folder=$(mktemp -d)
    trap 'rm -rf "$folder"' EXIT
    for config in configs/smoke/*.toml; do
      build-tsan/surveymc run "$config" --threads 3 -o "$folder/result.h5" >"$folder/log" 2>&1 || {
        cat "$folder/log"
        echo "sanitize.sh: $config (above)" >&2
        exit 1
      }
      rm -f "$folder/result.h5"
    done
    echo "tsan: tests with threads and $(ls configs/smoke/*.toml | wc -l) smoke configs passed"
    ;;
  *) sed -n '2,8s/^# //p' "$0" >&2; exit 64 ;;
esac
