#!/usr/bin/env bash
# Builds the documentation site: scripts/build_docs.sh [FOLDER], then open FOLDER/index.html (build/docs/index.html).
# Needs the packages of `scripts/bootstrap.sh docs`, and no network, neither now nor to read it.
#   SURVEYMC_DOCS_NOTEBOOKS   folder of notebooks with what they printed (build/notebooks, by the test tutorial.notebook)
#   SURVEYMC_DOCS_RESULTS     folder of results (results/quick, or build/smoke): columns of tables, pictures of configs
set -euo pipefail
folder=$(realpath -m "${1:-"$(dirname "$0")/../build/docs"}")
cd "$(dirname "$0")/.."
for module in sphinx myst_parser furo nbconvert; do
  if ! /usr/bin/python3 -c "import $module" 2>/dev/null; then
    echo "skipped: no $module (scripts/bootstrap.sh docs installs it)" >&2
    exit 77
  fi
done
build=$(dirname "$folder")
notebooks=${SURVEYMC_DOCS_NOTEBOOKS:-$build/notebooks}
results=${SURVEYMC_DOCS_RESULTS:-}
for place in results/quick "$build/smoke"; do
  [ -z "$results" ] && [ -d "$place" ] && results=$place
done
pages=$(mktemp -d)
trap 'rm -rf "$pages"' EXIT
/usr/bin/python3 scripts/docs_site.py . "$pages/docs" --notebooks "$notebooks" ${results:+--results "$results"}
rm -rf "$folder"
/usr/bin/python3 -m sphinx -q -W --keep-going -j auto -d "$pages/doctrees" -b html "$pages/docs" "$folder"
rm -f "$folder/.buildinfo"
/usr/bin/python3 tests/docs/check_links.py --html "$folder"
echo "docs: $folder/index.html"
