#!/usr/bin/env bash
# Builds the program without precompiled headers, in a folder of its own: each file must include what it uses. Takes as
# long as a build did before them, so CI does not run it.
set -euo pipefail
cd "$(dirname "$0")/.."
cmake --preset release -B build-plain -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DSURVEYMC_UNITY=OFF -DSURVEYMC_TESTS=OFF >/dev/null
cmake --build build-plain --target surveymc
