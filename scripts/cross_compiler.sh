#!/usr/bin/env bash
# The smoke configs give the same content hash with the other compiler: scripts/cross_compiler.sh PROGRAM SMOKE_FOLDER [BUILD_FOLDER]
# builds surveymc with GCC where PROGRAM is Clang's, else with Clang, runs each config, and compares it with what PROGRAM wrote in
# SMOKE_FOLDER (build/surveymc and build/smoke, which ctest fills). Seven to nine minutes of processor time, once. Exit 77 where the
# other compiler is missing.
set -euo pipefail
program=$(realpath "${1:?program}")
smoke=$(realpath "${2:?folder of smoke results}")
cd "$(dirname "$0")/.."
other=(clang-19 clang++-19)
if "$program" --version | grep -q Clang; then other=(gcc g++); fi
command -v "${other[1]}" >/dev/null || { echo "skipped: no ${other[1]}"; exit 77; }
build=$(realpath -m "${3:-build-other-compiler}")
mkdir -p "$build/smoke"
exec 9>"$build/lock"
flock 9
cmake -S . -B "$build" -G Ninja -DCMAKE_C_COMPILER="${other[0]}" -DCMAKE_CXX_COMPILER="${other[1]}" -DCMAKE_BUILD_TYPE=Release \
  -DSURVEYMC_TESTS=OFF -DSURVEYMC_MPI=OFF >"$build/log"
cmake --build "$build" --target surveymc >>"$build/log" 2>&1 || { tail -n 20 "$build/log" >&2; exit 1; }
exec /usr/bin/python3 tests/formats/compare_machines.py "$program" "$smoke" "$build/smoke" "$build/surveymc"
