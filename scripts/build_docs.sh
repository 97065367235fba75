#!/usr/bin/env bash
# Builds the documentation site, pages of docs/ and API of lib/: scripts/build_docs.sh [FOLDER], then open
# FOLDER/index.html (build/docs/index.html). Needs doxygen; needs no network, neither now nor to read it.
set -euo pipefail
folder=$(realpath -m "${1:-"$(dirname "$0")/../build/docs"}")
cd "$(dirname "$0")/.."
if ! command -v doxygen >/dev/null; then
  echo "skipped: no doxygen (scripts/bootstrap.sh test installs it)" >&2
  exit 77
fi
rm -rf "$folder"
mkdir -p "$folder"
version=$(sed -n 's/^project(surveymc VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { cat docs/Doxyfile; echo "OUTPUT_DIRECTORY = $folder/.."; echo "HTML_OUTPUT = $(basename "$folder")"
       echo "PROJECT_NUMBER = $version"; echo "WARN_LOGFILE = $log"; } | doxygen - >/dev/null || [ -s "$log" ]; then
  cat "$log" >&2
  echo "build_docs.sh: broken links or commands (above)" >&2
  exit 1
fi
cp -r docs/figures LICENSE CITATION.cff "$folder/"
# The notebook is no page of the site: pages of docs/ and the README link to the file, each by its own path.
for place in tutorials docs/tutorials; do
  mkdir -p "$folder/$place"
  cp docs/tutorials/python.ipynb "$folder/$place/"
done
python3 tests/docs/check_links.py --html "$folder"
echo "docs: $folder/index.html"
