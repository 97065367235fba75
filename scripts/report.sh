#!/bin/sh
# Makes one page of results: scripts/report.sh [RESULT.h5 | FOLDER ...] [-o PAGE.html]
# Installed it is the command surveymc-report. --help tells the options.
here=$(dirname "$(readlink -f "$0")")
PYTHONPATH=$here${PYTHONPATH:+:$PYTHONPATH} exec /usr/bin/python3 -P -m surveymc.report "$@"
