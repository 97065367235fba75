#!/usr/bin/env bash
# Rounds of a sweep along a boundary: runs the sweep, asks `surveymc refine` for the next points, runs these, and so on
# until the boundary is as fine as [refine] of the config wants it; then one result of all rounds.
#   scripts/slurm/refine.sh [options of sweep.sh] CONFIG OUTDIR [-- --set KEY=VALUE, --seed, --trials as in surveymc run]
# Each round is a folder OUTDIR/round-0, round-1, .. of sweep.sh; the result is OUTDIR/<config>.h5, and another file of that name
# is kept. Run it again after an interruption: rounds that are done are not run again, if they are of the same config with the
# same options. Waits for the queue.
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
rounds=$(number SURVEYMC_ROUNDS "${SURVEYMC_ROUNDS:-20}")
wait=$(number SURVEYMC_WAIT "${SURVEYMC_WAIT:-10}")
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
  local result
  result=$2/$(basename "$1" .toml).h5
  if [ -n "${SURVEYMC_LOCAL:-}" ]; then
    mkdir -p "$2"
    "$SURVEYMC" run "$1" -o "$result" --resume --quiet "${options[@]}"  # computes and replaces nothing that is of this config
    return
  fi
  until [ -f "$result" ]; do
    "$home/scripts/slurm/sweep.sh" "${before[@]}" "$1" "$2" -- "${options[@]}"
    while [ -n "$(squeue -h -o %j | grep "^smc-$(printf %s "$2" | cksum | cut -d' ' -f1)" || true)" ]; do
      sleep "$wait"
    done
    [ -f "$result" ] || { code=75 die "$result: is not there after its jobs have ended: see $2/logs, then run refine.sh again"; }
  done
  is_of_config "$result" "$2/parts" "$1" || code=74 die \
    "$result: is of another config, seed or options, or damaged: choose another OUTDIR, or remove $2"
}

# is_of_config RESULT PARTS CONFIG. Of more than 10,000 points, `check` only knows the hash that is in the parts.
is_of_config() {
  local there now
  there=$("$SURVEYMC" show "$1" --list --json | sed -n 's/^"config_hash": "\([0-9a-f]*\)".*/\1/p') || return 1
  now=$("$SURVEYMC" check "$3" "${options[@]}" | sed -n 's/^# .*config hash \([0-9a-f]*\)$/\1/p') || return 1
  [ "$there" != "$now" ] || return 0
  [ -d "$2" ] && [ -z "$("$SURVEYMC" plan "$3" "${options[@]}" --missing "$2")" ]
}

# deliver FILE: whole or not at all, as OUTDIR/<config>.h5. Another file of that name is kept as <config>.1.h5, or the next free number.
deliver() {
  local result copy kept number=1
  result=$(realpath "$out/$name.h5")  # through links
  [ -f "$result" ] || [ ! -e "$result" ] || code=74 die "$result: must be a regular file, or none yet"
  if cmp -s "$1" "$result"; then return; fi
  copy=$(mktemp -p "$(dirname "$result")" .surveymc-XXXXXXXX.tmp)
  cp --preserve=mode "$1" "$copy" || { rm -f "$copy"; code=74 die "$result: cannot write"; }
  if [ -f "$result" ]; then
    until kept=${result%.h5}.$number.h5; ln "$result" "$kept" 2>/dev/null; do
      [ -e "$kept" ] || { rm -f "$copy"; code=74 die "$kept: cannot write"; }
      number=$((number + 1))
    done
    echo "refine.sh: $result: another one was there: kept as $kept" >&2
  fi
  mv -f -T "$copy" "$result"
}

results=()
options=("${changes[@]}")  # the configs of later rounds have them already
for ((round = 0; round < rounds; ++round)); do
  folder=$out/round-$round
  sweep "$config" "$folder"
  results+=("$folder/$(basename "$config" .toml).h5")
  options=()
  all=${results[0]}
  if [ ${#results[@]} -gt 1 ]; then
    all=$folder/rounds.h5
    "$SURVEYMC" merge --quiet --overwrite -o "$all" "${results[@]}"
  fi
  next=$out/$name-$((round + 1)).toml following=$out/round-$((round + 1))
  [ ! -e "$next" ] || [ -d "$following" ] || code=74 die "$next: is there, and is not of refine.sh: choose another OUTDIR"
  mkdir -p "$following"
  rm -f "$next"
  "$SURVEYMC" refine "$all" -o "$next" --overwrite
  if [ ! -f "$next" ]; then
    rmdir "$following" 2>/dev/null || true
    deliver "$all"
    echo "$((round + 1)) round(s): $out/$name.h5"
    exit 0
  fi
  config=$next
done
deliver "$all"
code=1 die "the boundary is not as fine as [refine] wants it after $rounds rounds"
