#!/usr/bin/env bash
# Installs what is missing of the Debian packages that surveymc needs, and says so. Run it as often as you like.
#   scripts/bootstrap.sh              to build and plot
#   scripts/bootstrap.sh report       what the report and the Python reader need on top
#   scripts/bootstrap.sh import       what surveymc import needs to read WITSML and Excel
#   scripts/bootstrap.sh docs         what the documentation site needs (scripts/build_docs.sh)
#   scripts/bootstrap.sh cross        what the tests of other processors need (nightly)
#   scripts/bootstrap.sh test style   what the tests and the style checks need on top
set -euo pipefail

packages=(clang-19 libomp-19-dev lld-19 g++ cmake ninja-build git libeigen3-dev libhdf5-dev libnlopt-dev libnlopt-cxx-dev libfmt-dev
  libcli11-dev libtomlplusplus-dev libboost-dev libgeographiclib-dev libxxhash-dev libbenchmark-dev
  python3 python3-numpy python3-h5py python3-matplotlib python3-xxhash)
for part in "$@"; do
  case "$part" in
    report) packages+=(python3-pandas python3-xarray python3-jinja2 libjs-three) ;;
    import) packages+=(python3-lxml python3-openpyxl) ;;
    test) packages+=(python3-lxml python3-openpyxl catch2 libmuparser-dev librandom123-dev libopenmpi-dev openmpi-bin hdf5-tools netcdf-bin
      python3-pandas python3-xarray python3-jinja2 libjs-three python3-netcdf4 python3-h5netcdf python3-jsonschema python3-yaml python3-nbclient python3-nbformat python3-ipykernel
      poppler-utils dpkg-dev file
      chromium chromium-driver python3-selenium python3-pip python3-setuptools python3-wheel mandoc
      python3-sphinx python3-myst-parser furo python3-nbconvert python3-pil
      slurm-wlm munge parallel snakemake libclang-rt-19-dev) ;;
    docs) packages+=(python3-sphinx python3-myst-parser furo python3-nbconvert python3-nbclient python3-nbformat python3-ipykernel
      python3-pandas python3-xarray python3-pil) ;;
    style) packages+=(clang-format) ;;
    cross) packages+=(g++-aarch64-linux-gnu qemu-user) ;;
    *) echo "bootstrap.sh: unknown part '$part': must be report, import, test, docs, style or cross" >&2; exit 64 ;;
  esac
done

if ! command -v dpkg-query >/dev/null; then
  echo "bootstrap.sh: this is no Debian system: install the equivalents of: ${packages[*]}" >&2
  exit 1
fi
missing=()
for p in "${packages[@]}"; do
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$p" 2>/dev/null)" = installed ] || missing+=("$p")
done
if [ ${#missing[@]} -eq 0 ]; then
  echo "bootstrap: all ${#packages[@]} packages are installed"
  exit 0
fi
echo "bootstrap: installing ${missing[*]}"
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "bootstrap.sh: run this as root: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { "${as_root[@]}" apt-get update && "${as_root[@]}" apt-get install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
  tail -n 20 "$log" >&2
  echo "bootstrap.sh: apt-get failed (above)" >&2
  exit 1
fi
echo "bootstrap: done"
