#!/usr/bin/env bash
# Installs what is missing, builds, runs all tests. Arguments go to ctest: scripts/test.sh -R estimate
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/bootstrap.sh test
cmake --preset release -DSURVEYMC_TESTS=ON >/dev/null  # the quickstart may have turned them off here
cmake --build --preset release
exec ctest --test-dir build --no-tests=error --output-on-failure --parallel "$(nproc)" "$@"
