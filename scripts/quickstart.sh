#!/usr/bin/env bash
# From a fresh machine to a first result: installs what is missing, builds, runs test 4 of the thesis, prints what it
# found, draws its figures, and says how to go on. What takes many lines goes to a log.
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p build results
log=build/quickstart.log
result=results/quickstart.h5
: >"$log"

# Ends with the last lines of the log.
failed() {
  tail -n 15 "$log" >&2
  echo "quickstart.sh: failed: $*: the last lines are above, all are in $log" >&2
  exit 1
}

# Runs a command, its output to the log.
logged() { "$@" >>"$log" 2>&1 || failed "$@"; }

minutes() { if [ "$1" -lt 100 ]; then echo "$1 s"; else echo "$((($1 + 30) / 60)) min"; fi; }

scripts/bootstrap.sh
echo "building: some minutes; the log is $log"
start=$SECONDS
logged cmake --preset release -DSURVEYMC_TESTS=OFF
logged cmake --build --preset release --target surveymc
echo "built in $(minutes $((SECONDS - start)))"

echo
echo "Test 4 of the thesis: how large are the errors that multi-station analysis leaves?"
build/surveymc run configs/thesis/test4.toml -o "$result" --overwrite 2>>"$log" || failed surveymc run

echo
echo "figures:"
logged build/surveymc plot "$result"
{ grep -o '^results/.*[.]png$' "$log" || tail -n 1 "$log"; } | sed 's/^/  /'

echo
echo "what is in the result:    build/surveymc show $result"
echo "your own well:            build/surveymc new position_covariance -o well.toml"
echo "all studies as pages:  scripts/run_all.sh --quick    then open results/quick/report/index.html"
