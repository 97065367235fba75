#!/usr/bin/env bash
# The same Monte-Carlo MSA by surveymc, Ceres and SciPy, in turn on one core: who does how many runs per second, and do
# they agree? README.md says what is compared and how fair it is.
#   tests/bench/compare_peers/run.sh [--quick] [--rounds N] [--core K] [--surveymc PROGRAM] [--verify] [-o FOLDER]
# --quick: 2 short rounds; --verify: only compare the answers on identical readings; --core: pin one-thread programs to
# this core; --surveymc: use this program instead of building build/surveymc; -o: where to write (results).
set -euo pipefail
cd "$(dirname "$0")/../../.."
here=tests/bench/compare_peers
config=configs/bench/msa_traj4.toml
build=build/compare_peers

rounds=5 runs_ours=1000000 runs_ceres=100000 runs_tiny=200000 runs_scipy=10000
surveymc='' output=results verify_only=no pin=()
usage() { sed -n '4,6s/^# *//p' "$here/run.sh" >&2; exit 64; }
while [ $# -gt 0 ]; do
  case "$1" in
    --quick) rounds=2 runs_ours=300000 runs_ceres=30000 runs_tiny=60000 runs_scipy=3000 ;;
    --verify) verify_only=yes ;;
    --rounds | --core | --surveymc | -o)
      [ $# -ge 2 ] || usage
      case "$1" in
        --rounds) [[ "$2" =~ ^[1-9][0-9]*$ ]] || usage; rounds=$2 ;;
        --core) pin=(taskset -c "$2") ;;
        --surveymc) surveymc=$2 ;;
        -o) output=$2 ;;
      esac
      shift ;;
    *) usage ;;
  esac
  shift
done

# --- what is needed -----------------------------------------------------------------------------------------------
if command -v dpkg-query >/dev/null; then
  missing=()
  for p in libceres-dev python3-scipy; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$p" 2>/dev/null)" = installed ] || missing+=("$p")
  done
  if [ ${#missing[@]} -gt 0 ]; then
    echo "compare_peers: installing ${missing[*]}"
    as_root=()
    if [ "$(id -u)" -ne 0 ]; then
      command -v sudo >/dev/null || { echo "run.sh: run this as root: apt-get install ${missing[*]}" >&2; exit 1; }
      as_root=(sudo)
    fi
    export DEBIAN_FRONTEND=noninteractive
    log=$(mktemp)
    if ! { "${as_root[@]}" apt-get update &&
      "${as_root[@]}" apt-get install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
      tail -n 20 "$log" >&2
      echo "run.sh: apt-get failed (above)" >&2
      exit 1
    fi
    rm -f "$log"
  fi
else
  echo "compare_peers: no Debian system: the equivalents of libceres-dev and python3-scipy must be there"
fi

# --- build ------------------------------------------------------------------------------------------------------
mkdir -p "$build"
if [ -z "$surveymc" ]; then
  scripts/bootstrap.sh
  {
    { [ -f build/CMakeCache.txt ] || cmake --preset release -DSURVEYMC_TESTS=OFF; } &&
      cmake --build build --target surveymc
  } >"$build/build.log" 2>&1 ||
    { tail -n 20 "$build/build.log" >&2; echo "run.sh: surveymc does not build (above)" >&2; exit 1; }
  surveymc=build/surveymc
fi
ceres=$build/ceres_msa
if [ ! -x "$ceres" ] || [ "$here/ceres_msa.cpp" -nt "$ceres" ]; then
  # -Wno-maybe-uninitialized: GCC 12 warns about the "undefined" vectors of its own AVX-512 header.
  g++ -std=c++20 -O3 -march=native -fno-math-errno -fno-trapping-math -DNDEBUG -Wall -Wextra -Wno-maybe-uninitialized \
    -isystem /usr/include/eigen3 "$here/ceres_msa.cpp" -o "$ceres" -lceres -lglog
fi

# --- the same minima? -------------------------------------------------------------------------------------------
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 PYTHONDONTWRITEBYTECODE=1
python=/usr/bin/python3 # Debian's, which has SciPy and h5py
[ -x "$python" ] || python=python3
"$python" "$here/verify.py" "$config" --surveymc "$surveymc" --ceres "$ceres"
[ "$verify_only" = no ] || exit 0

# --- rounds: everybody in turn, so that a slow minute of the machine hits all ----------------------------------------
geometry=$build/geometry.txt
"$python" "$here/scipy_msa.py" "$config" --geometry "$geometry"
results=$build/rounds.jsonl
: >"$results"
echo
for ((round = 1; round <= rounds; ++round)); do
  echo "round $round of $rounds" >&2
  seed=$((2019 + round))
  {
    # Two threads must be free of the pin and of OMP_NUM_THREADS.
    "${pin[@]}" "$python" "$here/surveymc_msa.py" "$surveymc" "$config" --threads 1 --runs $runs_ours --seed $seed
    env -u OMP_NUM_THREADS "$python" "$here/surveymc_msa.py" "$surveymc" "$config" --threads 2 \
      --runs $runs_ours --seed $seed
    for solver in normal_cholesky qr; do "${pin[@]}" "$ceres" "$geometry" $solver --runs $runs_ceres --seed $seed; done
    "${pin[@]}" "$ceres" "$geometry" tiny --runs $runs_tiny --seed $seed
    for solver in least_squares leastsq; do
      "${pin[@]}" "$python" "$here/scipy_msa.py" "$config" --solver $solver --runs $runs_scipy --seed $seed
    done
  } >>"$results"
done
"$python" "$here/report.py" "$results" -o "$output"
