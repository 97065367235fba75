#!/usr/bin/env bash
# Rounds of a sweep along a boundary: runs the sweep, asks `surveymc refine` for the next points, runs these, and so on
# until the boundary is as fine as [refine] of the config wants it; then one result of all rounds.
#   scripts/slurm/refine.sh [options of sweep.sh] CONFIG OUTDIR [-- --set KEY=VALUE, --seed, --trials as in surveymc run]
# Each round is a folder OUTDIR/round-0, round-1, .. of sweep.sh; the result is OUTDIR/<config>.h5. Run it again after an
# interruption: rounds that are done are not run again. Waits for the queue.
# Environment: SURVEYMC as in sweep.sh; SURVEYMC_LOCAL=yes runs the rounds here, without Slurm; SURVEYMC_WAIT, seconds
# between two looks at the queue (10); SURVEYMC_ROUNDS, at most so many (20).
set -euo pipefail
die() { echo "refine.sh: $*" >&2; exit "${code:-64}"; }
case ${1:-} in --help | -h) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
home=$(cd "$(dirname "$0")/../.." && pwd)
source "$home/scripts/slurm/job.sh"
trap - TERM INT USR1
SURVEYMC=${SURVEYMC:-$(find_program surveymc)} || die "surveymc is not built"
case $SURVEYMC in */*) SURVEYMC=$(realpath "$SURVEYMC") ;; esac
export SURVEYMC
before=() names=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
  case $1 in
    --dry-run) die "--dry-run: what the next round runs is only known when this one is done" ;;
    -*) [ $# -ge 2 ] || die "$1: needs a value"; before+=("$1" "$2"); shift 2 ;;
    *) names+=("$1"); shift ;;
  esac
done
[ $# = 0 ] || shift
changes=("$@")
[ ${#names[@]} = 2 ] || die "must be given CONFIG and OUTDIR (--help)"
[ -f "${names[0]}" ] || code=65 die "${names[0]}: no such config"
config=$(realpath "${names[0]}") name=$(basename "${names[0]}" .toml)
mkdir -p "${names[1]}"
out=$(realpath "${names[1]}")

sweep() { # sweep CONFIG FOLDER: its result is FOLDER/<config>.h5
  local result=$2/$(basename "$1" .toml).h5
  if [ -n "${SURVEYMC_LOCAL:-}" ]; then
    mkdir -p "$2"
    [ -f "$result" ] || "$SURVEYMC" run "$1" -o "$result" --resume --quiet "${options[@]}"
    return
  fi
  until [ -f "$result" ]; do
    "$home/scripts/slurm/sweep.sh" "${before[@]}" "$1" "$2" -- "${options[@]}"
    while [ -n "$(squeue -h -o %j | grep "^smc-$(printf %s "$2" | cksum | cut -d' ' -f1)" || true)" ]; do
      sleep "${SURVEYMC_WAIT:-10}"
    done
    [ -f "$result" ] || { code=75 die "$result: is not there after its jobs have ended: see $2/logs, then run refine.sh again"; }
  done
}

results=()
options=("${changes[@]}")  # the configs of later rounds have them already
for ((round = 0; round < ${SURVEYMC_ROUNDS:-20}; ++round)); do
  sweep "$config" "$out/round-$round"
  results+=("$out/round-$round/$(basename "$config" .toml).h5")
  options=()
  all=${results[0]}
  if [ ${#results[@]} -gt 1 ]; then
    all=$out/$name.h5
    "$SURVEYMC" merge --quiet --overwrite -o "$all" "${results[@]}"
  fi
  next=$out/$name-$((round + 1)).toml
  rm -f "$next"
  "$SURVEYMC" refine "$all" -o "$next" --overwrite
  if [ ! -f "$next" ]; then
    [ "$all" = "$out/$name.h5" ] || cp "$all" "$out/$name.h5"
    echo "$((round + 1)) round(s): $out/$name.h5"
    exit 0
  fi
  config=$next
done
code=1 die "the boundary is not as fine as [refine] wants it after ${SURVEYMC_ROUNDS:-20} rounds"
