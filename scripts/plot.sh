#!/bin/sh
# Draws a result: scripts/plot.sh RESULT.h5, or one drawer: scripts/plot.sh thesis RESULT.h5
# Installed it is the command surveymc-plot. --help tells the options.
here=$(dirname "$(readlink -f "$0")")
PYTHONPATH=$here${PYTHONPATH:+:$PYTHONPATH} exec /usr/bin/python3 -P -m surveymc.plots "$@"
