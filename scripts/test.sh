#!/usr/bin/env bash
# Installs what is missing, builds, runs the tests. Other arguments go to ctest: scripts/test.sh -R estimate
#   scripts/test.sh            all but those labelled nightly
#   scripts/test.sh -L nightly what takes long
#   scripts/test.sh --quick    the developer's loop: the unit tests, and the program is built
# Labels (ctest -L): unit, cli (the program end to end), slow (more than some seconds), nightly (full size, and all of
# what CI has a sample of; never in CI).
set -euo pipefail
cd "$(dirname "$0")/.."
targets=() choice=(-LE nightly)
if [ "${1:-}" = --quick ]; then
  shift
  targets=(--target unit_tests surveymc) choice=(-L unit)
fi
[[ " $* " == *" -L"* ]] && choice=()
scripts/bootstrap.sh test
cmake --preset release -DSURVEYMC_TESTS=ON >/dev/null  # the quickstart may have turned them off here
cmake --build --preset release "${targets[@]}"
# Two tests more than there are cores: some wait for a cluster, a signal or a browser.
exec ctest --test-dir build --no-tests=error --output-on-failure --parallel "$(($(nproc) + 2))" "${choice[@]}" "$@"
