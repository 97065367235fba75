#!/usr/bin/env bash
# C++ files must be as clang-format writes them; `scripts/check_style.sh --fix` writes them. Tests say to how many digits
# two numbers are equal: the default of Approx, 1.2e-5, does not see a survey foot (2e-6) taken for a foot. No result and no
# other binary file is committed, but small pictures of the pages (docs/figures, scripts/draw_*.py).
set -euo pipefail
cd "$(dirname "$0")/.."
mapfile -t files < <(git ls-files -co --exclude-standard '*.h' '*.cpp' ':!third_party')  # as its authors wrote it
if [ "${1:-}" = --fix ]; then
  clang-format -i "${files[@]}"
else
  clang-format --dry-run --Werror "${files[@]}"
  if grep -nE '(^|[^s])Approx\(' "${files[@]}" | grep -vE 'epsilon|margin'; then
    echo "check_style.sh: Approx without .epsilon() or .margin()" >&2
    exit 1
  fi
  if git ls-files ':!docs/figures/*.png' | grep -E '\.(h5|part|png|pdf|o|a|so|gz|zip)$|\.journal'; then
    echo "check_style.sh: generated or binary files are committed" >&2
    exit 1
  fi
  if find docs/figures -name '*.png' -size +130k | grep .; then
    echo "check_style.sh: pictures above 130 kB" >&2
    exit 1
  fi
  echo "style: ${#files[@]} files"
fi
