#!/usr/bin/env bash
# Computes a sweep on a Slurm cluster: submits an array of what is missing, and behind it the merge.
#   scripts/slurm/sweep.sh [options] CONFIG OUTDIR [-- --set KEY=VALUE, --seed, --trials as in surveymc run]
# Run it as often as you like: what is done, queued or running is not submitted again. Writes OUTDIR/parts/,
# OUTDIR/logs/ and at the end OUTDIR/<config>.h5.
#   --tasks N           at most so many tasks, each a range of points of about the same cost (1000)
#   --group N           N points a task, instead; for points of seconds: make a task last minutes
#   --shards N          the parts are N shards of the trials of every point, instead of ranges of points; then --group is
#                       the number of shards a task runs, one after the other (1)
#   --cpus N            cores a task (1)
#   --concurrent N      at most so many tasks at once
#   --max-seconds S     a task stops then, and goes on later (else 120 s before the job's time limit, by Slurm's signal)
#   --sbatch OPTION     an option of sbatch for all jobs, e.g. --sbatch --partition=long; may be repeated.
#                       sbatch's own variables (SBATCH_PARTITION, SBATCH_ACCOUNT, SBATCH_TIMELIMIT, ...) work, too
#   --dry-run           print what would be submitted; where Slurm does not answer, as if its queue were empty
# Environment: SURVEYMC is the program (build/surveymc here, else the one on the PATH), seen by all nodes, as are CONFIG,
# its files and OUTDIR. Every option above can be given as SURVEYMC_SHARDS, SURVEYMC_GROUP, SURVEYMC_CPUS, ...
set -euo pipefail

die() { echo "sweep.sh: $*" >&2; exit "${code:-64}"; }
usage() { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; }

shards=${SURVEYMC_SHARDS:-} group=${SURVEYMC_GROUP:-} tasks=${SURVEYMC_TASKS:-1000} cpus=${SURVEYMC_CPUS:-1} concurrent=${SURVEYMC_CONCURRENT:-}
max_seconds=${SURVEYMC_MAX_SECONDS:-} dry_run='' sbatch_options=() names=()
while [ $# -gt 0 ]; do
  case $1 in
    --help | -h) usage; exit 0 ;;
    --dry-run) dry_run=yes; shift ;;
    --) shift; break ;;
    --shards | --group | --tasks | --cpus | --concurrent | --max-seconds | --sbatch)
      [ -n "${2:-}" ] || die "$1: needs a value"
      case $1 in
        --shards) shards=$2 ;;
        --group) group=$2 ;;
        --tasks) tasks=$2 ;;
        --cpus) cpus=$2 ;;
        --concurrent) concurrent=$2 ;;
        --max-seconds) max_seconds=$2 ;;
        --sbatch) sbatch_options+=("$2") ;;
      esac
      shift 2 ;;
    -*) die "unknown option $1 (--help)" ;;
    *) names+=("$1"); shift ;;
  esac
done
changes=("$@")
[ ${#names[@]} = 2 ] || die "must be given CONFIG and OUTDIR (--help)"

home=$(cd "$(dirname "$0")/../.." && pwd)
source "$home/scripts/slurm/job.sh"
trap - TERM INT USR1
for option in shards group tasks cpus concurrent max_seconds; do
  given=${!option}
  name=${option^^}
  [ -z "$given" ] || given=$(number "--${option//_/-} or SURVEYMC_$name" "$given")
  printf -v "$option" %s "$given"
done
SURVEYMC=${SURVEYMC:-$(find_program surveymc)} || die "surveymc is not built: cmake --preset release && cmake --build build"
case $SURVEYMC in */*) SURVEYMC=$(realpath "$SURVEYMC") ;; esac
for tool in sbatch squeue scontrol; do
  [ -n "$dry_run" ] || command -v $tool >/dev/null || die "$tool is missing: this needs Slurm"
done
[ -f "${names[0]}" ] || code=65 die "${names[0]}: no such config"
config=$(realpath "${names[0]}")
mkdir -p "${names[1]}/parts" "${names[1]}/logs"
out=$(realpath "${names[1]}")
result=$out/$(basename "$config" .toml).h5
logs=${out//%/%%}/logs  # as sbatch reads it
# The jobs of this folder and this kind of parts, to be found again in the queue
job=smc-$(printf %s "$out" | cksum | cut -d' ' -f1)
kind=${shards:-p}.${group:-t$tasks}
exec 9>"$out/logs/.lock"
locked=0
flock -n -E 99 9 2>/dev/null || locked=$?
[ $locked != 99 ] || code=75 die "$out: another sweep.sh is at work there"
[ $locked = 0 ] || echo "sweep.sh: $out: this file system has no locks: run one sweep.sh at a time there" >&2

plan=("$SURVEYMC" plan "$config" "${changes[@]}" ${shards:+--shards "$shards"})
if [ -z "$shards" ]; then
  [ -z "$group" ] || tasks=$((($("${plan[@]}" --count) + group - 1) / group))
  plan+=(--groups "$tasks")
fi
count=$("${plan[@]}" --count)
missing=$("${plan[@]}" --missing "$out/parts")
if [ -n "$shards" ]; then SURVEYMC_RANGES='' group=${group:-1}; else SURVEYMC_RANGES=$out/logs/ranges.$kind group=1; fi
[ -n "$shards" ] || "${plan[@]}" >"$SURVEYMC_RANGES"
SURVEYMC_FOLDERS=''
[ "$count" -le 1000 ] || SURVEYMC_FOLDERS=yes

# "0-3,7" -> a number a line
numbers() { tr , '\n' | awk -F- 'NF { for (i = $1; i <= $NF; ++i) print i }'; }
# numbers, rising -> "0-3,7"
as_list() { awk 'NR == 1 { a = b = $1; next } $1 == b + 1 { b = $1; next } { printf "%s,", (a == b ? a : a "-" b); a = b = $1 }
  END { if (NR) print (a == b ? a : a "-" b) }'; }

todo=$(printf %s "$missing" | numbers | awk -v g="$group" '{ t = int($1 / g) } t != last || NR == 1 { print t; last = t }')
if ! queue=$(squeue -h -r -o '%j %K %A %F %t' | awk -v job="$job" 'index($1, job) == 1'); then  # one line a task
  [ -n "$dry_run" ] || code=71 die "squeue: Slurm does not answer: run this where sbatch works; without Slurm:" \
    "surveymc run $config --resume -o $result"
  echo "sweep.sh: squeue: Slurm does not answer: as if its queue were empty" >&2
  queue=''
fi
if other=$(printf '%s\n' "$queue" | awk -v mine="$job.$kind." -v merge="$job.merge" '$1 != "" && $1 != merge && index($1, mine) != 1 { print $4 }' | sort -u) && [ -n "$other" ]; then
  code=75 die "$out: jobs with other --shards, --tasks or --group are still in the queue ($(echo $other)): wait, or scancel them"
fi
queued=$(printf '%s\n' "$queue" | awk -v mine="$job.$kind." 'index($1, mine) == 1 { print substr($1, length(mine) + 1) + $2 }' | sort -n)
todo=$(comm -23 <(printf '%s\n' $todo | sort) <(printf '%s\n' $queued | sort) | awk NF | sort -n)

if [ -z "$missing" ] && [ -z "$queued" ] && [ -f "$result" ] && [ -z "$(find "$out/parts" -name '*.part' -newer "$result" -print -quit)" ]; then
  echo "all $count parts are done: $result"
  exit 0
fi
if [ -z "$todo" ] && printf '%s\n' "$queue" | grep -q "^$job.merge "; then
  echo "nothing to submit: $(printf '%s\n' $queued | awk NF | wc -l) tasks and the merge are in the queue"
  exit 0
fi

submit() { # submit SBATCH_OPTIONS... -- SCRIPT ARGUMENTS...: the job's number
  local options=()
  while [ "$1" != -- ]; do options+=("$1"); shift; done
  shift
  if [ -n "$dry_run" ]; then echo "sbatch ${options[*]} ${sbatch_options[*]} $*" >&2; echo 0; return; fi
  sbatch --parsable "${options[@]}" "${sbatch_options[@]}" "$@" | cut -d';' -f1
}
export SURVEYMC SURVEYMC_RANGES SURVEYMC_FOLDERS SURVEYMC_HOME=$home SURVEYMC_SHARDS=$shards SURVEYMC_GROUP=$group SURVEYMC_COUNT=$count SURVEYMC_FIRST=0
jobs=$(printf '%s\n' "$queue" | awk -v job="$job.merge" '$1 != "" && $1 != job { print $4 }' | sort -u)

# Slurm numbers the tasks of an array below MaxArraySize: one array for each so many.
largest=$(scontrol show config 2>/dev/null | awk '$1 == "MaxArraySize" { print $3 }') || true
largest=${largest:-1001}
for ((SURVEYMC_FIRST = 0; SURVEYMC_FIRST * group < count; SURVEYMC_FIRST += largest)); do
  list=$(printf '%s\n' $todo | awk -v a="$SURVEYMC_FIRST" -v n="$largest" 'NF && $1 >= a && $1 < a + n { print $1 - a }' | as_list)
  [ -n "$list" ] || continue
  id=$(submit --array="$list${concurrent:+%$concurrent}" --job-name="$job.$kind.$SURVEYMC_FIRST" --cpus-per-task="$cpus" \
    --output="$logs/%A_%a.log" -- "$home/scripts/slurm/array.sbatch" "$config" "$out/parts" \
    ${max_seconds:+--max-seconds "$max_seconds"} "${changes[@]}")
  echo "array $id: tasks $list"
  jobs="$jobs $id"
done

# The merge that waits already would not wait for the new array.
[ -n "$dry_run" ] || scancel --quiet --state=PENDING --name="$job.merge" 2>/dev/null || true
dependency=$(printf ':%s' $jobs)
id=$(submit ${jobs:+--dependency="afterany$dependency"} --job-name="$job.merge" --output="$logs/merge.log" -- \
  "$home/scripts/slurm/merge.sbatch" "$config" "$out/parts" "$result" "${changes[@]}")
echo "merge $id: $result"
