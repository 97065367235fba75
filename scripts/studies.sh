#!/bin/sh
# Runs all studies with a built program: scripts/studies.sh [--quick] [--only PATTERN]
# Installed it is the command surveymc-studies. --help tells the options.
here=$(dirname "$(readlink -f "$0")")
PYTHONPATH=$here${PYTHONPATH:+:$PYTHONPATH} exec /usr/bin/python3 -P -m surveymc.run_studies "$@"
