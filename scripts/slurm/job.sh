# What every job of surveymc does; sourced by array.sbatch, mpi.sbatch and merge.sbatch, which say where it is.
# shellcheck shell=bash
export OMP_WAIT_POLICY="${OMP_WAIT_POLICY:-passive}"  # GCC's OpenMP reads it when it is loaded

# The program: SURVEYMC, or the build of this checkout, or the one on the PATH.
find_program() { # find_program surveymc|surveymc-mpi
  local home
  home=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
  if [ -x "$home/build/$1" ]; then echo "$home/build/$1"; else command -v "$1"; fi
}

# number NAME VALUE: the value without leading zeros, with which bash would read it as octal; else ends the script.
number() {
  local digits=${2#"${2%%[!0]*}"}
  case $digits in '' | *[!0-9]* | ??????????*) echo "${0##*/}: $1 $2: must be a whole number from 1 to 999999999" >&2; exit 64 ;; esac
  echo "$digits"
}

child='' signalled='' forward_as=TERM
# Slurm's signal reaches this shell, which bash would act on only when the child has ended: hand it on.
forward() {
  signalled=yes
  [ -z "$child" ] || kill -s "$forward_as" "$child" 2>/dev/null || true
}
trap forward TERM INT USR1

# run COMMAND...: its exit code; 75 if a signal came before it could start or catch it.
run() {
  local rc again
  [ -z "$signalled" ] || return 75
  "$@" &
  child=$!
  [ -z "$signalled" ] || kill -s "$forward_as" "$child" 2>/dev/null || true  # it came just now
  wait "$child" && rc=0 || rc=$?
  while [ "$rc" -gt 128 ] && [ -n "$signalled" ]; do  # the signal has ended the wait, not the child
    wait "$child" 2>/dev/null && again=0 || again=$?
    [ "$again" != 127 ] || break  # the child was waited for: it died by the signal
    rc=$again
    [ "$rc" -gt 128 ] && kill -0 "$child" 2>/dev/null || break
  done
  child=''
  if [ "$rc" -gt 128 ] && [ -n "$signalled" ]; then rc=75; fi
  return "$rc"
}

# finish CODE: ends the job. 75 puts it back in the queue, unless somebody has cancelled it.
finish() {
  local task=$SLURM_JOB_ID
  [ -z "${SLURM_ARRAY_TASK_ID:-}" ] || task=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID
  [ "$1" = 75 ] || exit "$1"
  if [ "$(squeue -h -j "$task" -o %T 2>/dev/null)" != RUNNING ]; then
    echo "$task: interrupted and not running any more: not put back in the queue" >&2
  elif [ "${SLURM_RESTART_COUNT:-0}" -ge "${SURVEYMC_MAX_RESTARTS:-1000}" ]; then
    echo "$task: interrupted for the ${SLURM_RESTART_COUNT}th time: gives up (SURVEYMC_MAX_RESTARTS)" >&2
  else
    echo "$task: interrupted: back in the queue" >&2
    scontrol requeue "$task"
  fi
  exit 75
}
