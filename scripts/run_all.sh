#!/usr/bin/env bash
# Runs every study at full size, draws the figures, and writes the report: results/report/index.html.
#
#   scripts/run_all.sh                    all studies; what is done already, with the same config and program, is kept
#   scripts/run_all.sh --quick            few trials, a few minutes: results/quick/report/index.html
#   scripts/run_all.sh --only 'thesis/*'   those whose name fits (shell pattern, or part of the name); may be repeated
#   scripts/run_all.sh --list             names, whether they are done, and nothing else
#   --threads N, --no-report              for surveymc studies, which does the work
#
# Ctrl-C stops it; finished results stay, and the next call goes on from there.
set -euo pipefail
cd "$(dirname "$0")/.."
for argument in "$@"; do
  case "$argument" in -h | --help) exec /usr/bin/python3 scripts/surveymc studies --help ;; esac
done
scripts/bootstrap.sh report
exec /usr/bin/python3 scripts/surveymc studies --build "$@"
