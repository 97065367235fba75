#!/bin/sh
# A survey in another form to CSV: scripts/import_survey.sh FILE -o well.csv
# Installed it is the command surveymc-import. --help tells the options.
here=$(dirname "$(readlink -f "$0")")
PYTHONPATH=$here${PYTHONPATH:+:$PYTHONPATH} exec /usr/bin/python3 -P -m surveymc.importer "$@"
