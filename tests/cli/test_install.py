#!/usr/bin/python3
"""`cmake --install` into an empty folder, and what is in it: test_install.py CMAKE BUILD_FOLDER

Configs, scripts, package, pages and commands are used from there, as a user has them who has no source tree.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

cmake, build = sys.argv[1:3]
source = Path(__file__).resolve().parents[2]


def call(*command, **options):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, **options)
    assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
    return done.stdout


with tempfile.TemporaryDirectory(prefix="surveymc-install-") as name:
    moved = Path(name) / "moved"
    prefix = Path(name) / "prefix"
    subprocess.run([cmake, "--install", build, "--prefix", prefix], check=True, stdout=subprocess.DEVNULL)
    prefix.rename(moved)  # it works wherever it is put
    share, bin_folder, work = moved / "share/surveymc", moved / "bin", Path(name) / "work"
    work.mkdir()
    for path in ["share/man/man1/surveymc.1", "share/man/man1/surveymc-run.1", "share/doc/surveymc/copyright", "share/bash-completion/completions/surveymc",
                 "share/doc/surveymc/LICENSE", "share/doc/surveymc/README.md"]:
        assert (moved / path).stat().st_size > 0, path
    licences = moved / "share/doc/surveymc/licences"
    if shutil.which("dpkg-query"):  # the licence of all that is compiled in: of HDF5 where it is a static library
        index = (licences / "README.txt").read_text()
        linked = subprocess.run(["ldd", moved / "bin/surveymc"], capture_output=True, text=True, check=True).stdout
        for file in ("Core", "version.hpp", "CLI.hpp", "philox.h", "xxhash.h", *([] if "libhdf5" in linked else ["libhdf5.a"])):
            named = re.search(rf"(?m)^(\S+[.]txt): {re.escape(file)}, compiled into", index)
            assert named and "opyright" in (licences / named[1]).read_text(), f"{file}: {index}"
        assert any(f.stat().st_size > 0 for f in (licences / "common-licenses").iterdir())
    for part, pattern in (("configs", "**/*.toml"), ("configs", "**/*.csv"), ("docs", "*.md"), ("docs", "studies/*"), ("docs", "tutorials/*"),
                          ("scripts", "surveymc/**/*.py")):
        there = moved / "share/doc/surveymc" if part == "docs" else share
        for file in (source / part).glob(pattern):
            assert (there / part / file.relative_to(source / part)).is_file(), file
    left = [f for f in share.rglob("*") if f.name in ("__pycache__", "run_all.sh", "bootstrap.sh", "check_layers.py", "sanitize.sh")]
    assert not left, left

    environment = {**os.environ, "PYTHONPATH": str(moved / "lib/python3/dist-packages"), "PYTHONDONTWRITEBYTECODE": "1",
                   "PATH": f"{bin_folder}:/usr/bin:/bin", "MPLBACKEND": "Agg"}
    environment.pop("SURVEYMC", None)
    options = {"cwd": work, "env": environment}
    call("surveymc", "run", share / "configs/examples/own_well_uncertainty.toml", "-o", "out.h5", **options)
    assert "covariance_by_source" in call("surveymc", "show", "out.h5", **options)
    (work / "survey.txt").write_text("Measured Depth (ft);Incl (deg);Azimuth Grid (deg)\n1000;2.1;45\n1095;4.8;46.2\n")
    call("surveymc", "import", "survey.txt", "-o", "survey.csv", **options)
    assert (work / "survey.csv").read_text().startswith("md_ft,inclination_deg,azimuth_deg")
    assert "out_along.svg" in call("surveymc", "plot", "out.h5", "-o", "figures", **options)
    call("surveymc", "report", "out.h5", "-o", "mine", "--no-figures", **options)
    assert "own well" in (work / "mine/index.html").read_text().lower()
    code = ("import surveymc; print(surveymc.find_program()); r = surveymc.run('%s', trials=50); print(len(r.table('position')))"
            % (share / "configs/examples/own_well.toml"))
    said = call("/usr/bin/python3", "-c", code, **options).split()
    assert Path(said[0]).resolve() == (bin_folder / "surveymc").resolve() and int(said[1]) > 0, said
    call("surveymc", "studies", "--quick", "--no-report", "--only", "reliability/fig1", **options)
    assert (work / "results/quick/reliability/fig1.h5").exists()
print("installed, moved, and used from there")
