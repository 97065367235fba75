#!/usr/bin/python3
"""The container image, built of the Containerfile and used: test_container.py CPACK BUILD_FOLDER [SUITE [MIRROR]]

buildah builds it with chroot isolation, so that no daemon and no registry is needed: what stands for docker.io/library/debian is a
minimal system of debootstrap, and the package is the .deb of the build folder (--build-arg PACKAGE=made). Needs root, buildah,
debootstrap and a mirror; skipped (77) without. Minutes: label nightly. SURVEYMC_CHROOT: as in test_packages.py.
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

cpack, build = sys.argv[1], os.path.abspath(sys.argv[2])
suite, mirror = (sys.argv[3:] + ["bookworm", "http://deb.debian.org/debian"][len(sys.argv[3:]):])[:2]
given = os.environ.get("SURVEYMC_CHROOT")
missing = [p for p in ("buildah", *(() if given else ("debootstrap",))) if not shutil.which(p, path=os.environ["PATH"] + ":/usr/sbin:/sbin")]
if os.geteuid() != 0 or missing:
    print(f"skipped: needs root and {', '.join(missing) or 'nothing else'}")
    sys.exit(77)


def call(*command, **options):
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
    assert done.returncode == 0, f"{' '.join(map(str, command))}: {done.stdout[-3000:]}"
    return done.stdout.strip()


# The driver vfs copies the system in every step; /tmp may be a small part of the memory.
roomy = None if shutil.disk_usage(tempfile.gettempdir()).free > 16e9 else build
with tempfile.TemporaryDirectory(prefix="surveymc-container-", dir=roomy) as folder:
    os.environ["TMPDIR"] = folder

    def buildah(*words):
        return call("buildah", "--root", f"{folder}/storage", "--runroot", f"{folder}/run", "--storage-driver", "vfs", *words)

    base = given or f"{folder}/base"
    if not given:
        made = subprocess.run(["debootstrap", "--variant=minbase", suite, base, mirror], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if made.returncode:
            print(f"skipped: debootstrap: {made.stdout[-500:]}")
            sys.exit(77)
    empty = buildah("from", "scratch")
    buildah("add", "--quiet", empty, base, "/")
    buildah("commit", "--quiet", empty, "docker.io/library/debian:12-slim")
    buildah("rm", empty)

    with open(os.path.join(build, "CMakeCache.txt"), encoding="utf-8") as file:
        source = re.search(r"(?m)^CMAKE_HOME_DIRECTORY:INTERNAL=(.*)$", file.read())[1]
    context = f"{folder}/context"
    os.makedirs(f"{context}/build")
    shutil.copy(f"{source}/Containerfile", context)
    call(cpack, "-G", "DEB", "-B", f"{context}/build", cwd=build)
    shutil.rmtree(f"{context}/build/_CPack_Packages", ignore_errors=True)
    words = ["bud", "--isolation", "chroot", "--layers", "--pull-never", "--build-arg", "PACKAGE=made", "--build-arg", "REVISION=0123abc", "-t", "surveymc"]
    buildah(*words, context)
    again = buildah(*words, context)
    assert again.count("Using cache") >= 2, again  # built in layers: nothing is installed twice

    image = json.loads(buildah("inspect", "--type", "image", "surveymc"))["OCIv1"]["config"]
    assert image["Entrypoint"] == ["surveymc"] and image["User"] not in ("", "0", "root") and image["WorkingDir"] == "/work", image
    assert image["Labels"]["org.opencontainers.image.revision"] == "0123abc", image["Labels"]
    used = buildah("from", "--pull-never", "surveymc")

    def inside(*command):
        return buildah("run", "--isolation", "chroot", used, "--", *command)

    version = inside("surveymc", "--version")
    assert version.startswith(f"surveymc {image['Labels']['org.opencontainers.image.version']} "), version
    assert inside("id", "-u") != "0"
    inside("surveymc", "new", "position_covariance", "-o", "well.toml")
    assert "the position is known to" in inside("surveymc", "run", "well.toml")
    assert ".svg" in inside("surveymc", "plot", "results/well.h5", "-o", "figures")
    inside("surveymc", "rerun", "results/well.h5")
    found = inside("sh", "-c", "command -v gcc clang cmake || true; ls /package 2>/dev/null || true")
    assert not found, f"in the image: {found}"
    print("the image is built in layers, has its revision, and runs as no root")
