#!/usr/bin/env bash
# Installs what is missing, builds, runs all tests. Arguments go to ctest: scripts/test.sh -R estimate
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/bootstrap.sh test
cmake --preset release >/dev/null
cmake --build --preset release
exec ctest --test-dir build --output-on-failure --parallel "$(nproc)" "$@"
