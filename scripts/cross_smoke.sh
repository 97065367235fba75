#!/usr/bin/env bash
# The smoke configs give the same content hash on aarch64: scripts/cross_smoke.sh PROGRAM SMOKE_FOLDER [BUILD_FOLDER] builds
# surveymc with Debian's cross compiler, runs each config under qemu-user, and compares it with what PROGRAM of this machine wrote
# in SMOKE_FOLDER (build/surveymc and build/smoke, which ctest fills). BUILD_FOLDER (build-aarch64) gets Debian's packages for
# arm64 from the sources that apt knows, and the sources of NLopt and GeographicLib, which are compiled without contraction:
# those of Debian for arm64 fuse sums and products. SURVEYMC_DEBIAN_LIBRARIES=1 runs with them. Some 20 minutes of processor
# time, once. Exit 77 where a tool or the packages cannot be had: scripts/bootstrap.sh cross installs the tools.
set -euo pipefail
program=$(realpath "${1:?program}")
smoke=$(realpath "${2:?folder of smoke results}")
cd "$(dirname "$0")/.."
build=$(realpath -m "${3:-build-aarch64}")
for tool in aarch64-linux-gnu-g++ qemu-aarch64 apt-get dpkg-deb; do
  command -v "$tool" >/dev/null || { echo "skipped: no $tool"; exit 77; }
done
mkdir -p "$build"
exec 9>"$build/lock"
flock 9
export SURVEYMC_SYSROOT=$build/root
root=$build/root sources=$build/sources plain=$build/plain
libraries=$root/usr/lib/aarch64-linux-gnu
packages=(libc6-dev libstdc++6 libhdf5-dev libnlopt-cxx-dev libfmt-dev libtomlplusplus-dev libgeographiclib-dev
  libxxhash-dev libeigen3-dev libboost-dev libcli11-dev)

if [ ! -e "$root/complete" ]; then
  rm -rf "$root" "$sources" "$plain" "$build/apt"
  mkdir -p "$root" "$sources" "$plain" "$build"/apt/{parts,lists/partial,cache/archives/partial}
  : >"$build/apt/status"
  shopt -s nullglob
  for file in /etc/apt/sources.list.d/*.sources; do
    sed -e 's/^Types:.*/Types: deb deb-src/' -e '/^Architectures:/d' "$file" >"$build/apt/parts/${file##*/}"
  done
  for file in /etc/apt/sources.lis[t] /etc/apt/sources.list.d/*.list; do
    sed -nE 's/arch=[^] ]+//; /^deb /{p;s/^deb /deb-src /p}' "$file" >"$build/apt/parts/${file##*/}"
  done
  shopt -u nullglob
  apt=(apt-get -q -o APT::Architecture=arm64 -o APT::Architectures::=arm64 -o APT::Sandbox::User=root -o Dir::State::status="$build/apt/status"
    -o Dir::State::lists="$build/apt/lists" -o Dir::Cache="$build/apt/cache" -o Dir::Etc::sourcelist=/none -o Dir::Etc::sourceparts="$build/apt/parts")
  if ! { { "${apt[@]}" update || true; } && "${apt[@]}" install -y --no-install-recommends --download-only "${packages[@]}" &&
    (cd "$sources" && "${apt[@]}" source --download-only nlopt geographiclib); } >"$build/apt/log" 2>&1; then
    tail -n 3 "$build/apt/log"
    echo "skipped: no packages for arm64"
    exit 77
  fi
  for package in "$build"/apt/cache/archives/*.deb; do dpkg-deb -x "$package" "$root"; done
  find "$root" -type l -lname '/*' | while read -r link; do  # within the folder
    ln -snf "$(realpath -m --relative-to="$(dirname "$link")" "$root$(readlink "$link")")" "$link"
  done
  # CMake asks HDF5's compiler for its folders: that of this machine does not know these.
  printf '#!/bin/sh\necho aarch64-linux-gnu-gcc -I%s -L%s -lhdf5_hl -lhdf5 -lsz -lz -ldl -lm\n' \
    "$root/usr/include/hdf5/serial" "$libraries/hdf5/serial" >"$root/h5cc"
  chmod +x "$root/h5cc"
  (cd "$sources" && for file in *.orig.tar.gz; do tar xf "$file"; done)
  touch "$root/complete"
fi
cross=(-G Ninja -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/aarch64.cmake" -DCMAKE_BUILD_TYPE=Release -DCMAKE_SKIP_RPATH=ON)

# NLopt and GeographicLib without contraction, as libraries in the place of Debian's: what the program uses of them.
name_of() { aarch64-linux-gnu-objdump -p "$1" | sed -n 's/^ *SONAME *//p'; }
if [ ! -e "$plain/complete" ]; then
  mkdir -p "$plain/geographic"
  options=()
  for part in PYTHON OCTAVE MATLAB GUILE SWIG TESTS; do options+=("-DNLOPT_$part=OFF"); done
  cmake -S "$sources"/nlopt-*/ -B "$plain/nlopt" "${cross[@]}" -DCMAKE_C_FLAGS=-ffp-contract=off -DCMAKE_CXX_FLAGS=-ffp-contract=off \
    "${options[@]}" >"$plain/log"
  ninja -C "$plain/nlopt" nlopt >>"$plain/log"
  for name in nlopt nlopt_cxx; do ln -sf nlopt/libnlopt.so "$plain/$(name_of "$libraries/lib$name.so")"; done
  for name in Math Utility SphericalEngine CircularEngine Geocentric UTMUPS TransverseMercator PolarStereographic MGRS NormalGravity Ellipsoid \
    EllipticFunction AlbersEqualArea DMS; do
    aarch64-linux-gnu-g++ --sysroot="$root" -std=c++17 -O2 -fPIC -ffp-contract=off -c "$sources"/GeographicLib-*/src/$name.cpp \
      -o "$plain/geographic/$name.o"
  done
  name=$(name_of "$libraries/libGeographicLib.so")
  aarch64-linux-gnu-g++ --sysroot="$root" -shared -Wl,-soname,"$name" "$plain"/geographic/*.o -o "$plain/$name"
  touch "$plain/complete"
fi

# Less optimisation: the build takes longer than the runs, and no bit depends on it.
cmake -S . -B "$build" "${cross[@]}" -DCMAKE_CXX_FLAGS_RELEASE="-O1 -DNDEBUG" -DSURVEYMC_TESTS=OFF -DSURVEYMC_MPI=OFF >"$build/log"
cmake --build "$build" --target surveymc >>"$build/log" 2>&1 || { tail -n 20 "$build/log" >&2; exit 1; }

mkdir -p "$build/smoke"
emulator=(qemu-aarch64 -L "$root")
[ -n "${SURVEYMC_DEBIAN_LIBRARIES:-}" ] || emulator+=(-E LD_LIBRARY_PATH="$plain")
exec /usr/bin/python3 tests/formats/compare_machines.py "$program" "$smoke" "$build/smoke" "${emulator[@]}" "$build/surveymc"
