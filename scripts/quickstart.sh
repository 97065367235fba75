#!/usr/bin/env bash
# From a fresh machine to the main result: installs what is missing, builds, runs test 4 of the thesis, prints its
# comparison table, draws its figures, and says where they are.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/bootstrap.sh
cmake --preset release -DSURVEYMC_TESTS=OFF >/dev/null
cmake --build --preset release --target surveymc
mkdir -p results
echo
build/surveymc run configs/thesis/test4.toml -o results/quickstart.h5 --overwrite >results/quickstart.log
build/surveymc show results/quickstart.h5 parameters
build/surveymc show results/quickstart.h5 position
tail -n 2 results/quickstart.log
rm results/quickstart.log
build/surveymc run configs/thesis/noise_scale.toml -o results/noise_scale.h5 | tail -n 2
echo
echo "figures:"
scripts/plot.sh msa_position results/quickstart.h5
scripts/plot.sh msa_position results/noise_scale.h5
echo
echo "every study and one page with all results: scripts/run_all.sh --quick    then open results/quick/report.html"
echo "what is in it: build/surveymc show results/quickstart.h5    again, elsewhere: build/surveymc rerun results/quickstart.h5"
