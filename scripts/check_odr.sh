#!/usr/bin/env bash
# No type or function has two definitions: links the program with link-time optimisation, where the
# compiler compares them (-Wodr). In a folder of its own; some minutes, so it runs under the label nightly.
set -euo pipefail
cd "$(dirname "$0")/.."
cmake --preset release-gcc -B build-odr -DSURVEYMC_UNITY=OFF -DSURVEYMC_MPI=OFF -DSURVEYMC_BENCHMARKS=OFF \
  -DCMAKE_CXX_FLAGS_RELEASE="-O1 -flto" -DCMAKE_EXE_LINKER_FLAGS="-flto=auto -Werror=odr -Werror=lto-type-mismatch" \
  -DCMAKE_AR="$(command -v gcc-ar)" -DCMAKE_RANLIB="$(command -v gcc-ranlib)" >/dev/null
cmake --build build-odr --target surveymc
echo "odr: one definition each"
