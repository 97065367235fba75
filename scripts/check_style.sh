#!/usr/bin/env bash
# C++ files must be as clang-format writes them. `scripts/check_style.sh --fix` writes them.
set -euo pipefail
cd "$(dirname "$0")/.."
mapfile -t files < <(git ls-files -co --exclude-standard '*.h' '*.cpp')
if [ "${1:-}" = --fix ]; then
  clang-format -i "${files[@]}"
else
  clang-format --dry-run --Werror "${files[@]}" && echo "style: ${#files[@]} files"
fi
