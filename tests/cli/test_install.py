#!/usr/bin/python3
"""`cmake --install` into an empty folder, and what is in it: test_install.py CMAKE BUILD_FOLDER"""
import subprocess
import sys
import tempfile
from pathlib import Path

cmake, build = sys.argv[1:3]
with tempfile.TemporaryDirectory(prefix="surveymc-install-") as name:
    prefix = Path(name)
    subprocess.run([cmake, "--install", build, "--prefix", prefix], check=True, stdout=subprocess.DEVNULL)
    program = prefix / "bin/surveymc"
    for path in ["share/man/man1/surveymc.1", "share/bash-completion/completions/surveymc",
                 "share/zsh/site-functions/_surveymc", "share/fish/vendor_completions.d/surveymc.fish",
                 "share/surveymc/error_models/iscwsa_mwd_rev4.toml", "share/surveymc/examples/own_well.toml",
                 "share/doc/surveymc/LICENSE"]:
        assert (prefix / path).stat().st_size > 0, path
    example = prefix / "share/surveymc/examples/own_well_uncertainty.toml"
    subprocess.run([program, "run", example, "-o", prefix / "out.h5"], check=True, capture_output=True)
    shown = subprocess.run([program, "show", prefix / "out.h5"], check=True, capture_output=True, text=True).stdout
    assert "covariance_by_source" in shown, shown
    assert program.stat().st_mode & 0o111
print("installed, and an example run from there")
