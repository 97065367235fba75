#!/usr/bin/python3
"""cpack's packages on a system of their own: test_packages.py CPACK BUILD_FOLDER [SUITE [MIRROR]]

Makes the .deb and the tarball, a minimal Debian by debootstrap, and uses both in it by chroot: the tarball before anything
is installed, the .deb with what apt installs for it. Needs root, debootstrap and a mirror; skipped (77) without. Minutes:
label nightly. An existing root folder in SURVEYMC_CHROOT is used instead of a new one.
"""
import glob
import os
import shutil
import subprocess
import sys
import tempfile

cpack, build = sys.argv[1:3]
suite, mirror = (sys.argv[3:] + ["bookworm", "http://deb.debian.org/debian"][len(sys.argv[3:]):])[:2]
missing = [p for p in ("debootstrap", "chroot", "unshare", "dpkg-shlibdeps") if not shutil.which(p, path=os.environ["PATH"] + ":/usr/sbin:/sbin")]
if os.geteuid() != 0 or missing:
    print(f"skipped: needs root and {', '.join(missing) or 'nothing else'}")
    sys.exit(77)


def call(*command, **options):
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
    assert done.returncode == 0, f"{' '.join(map(str, command))}: {done.stdout[-3000:]}"
    return done.stdout


def in_root(root, *words, **options):
    """A command in the root, with /proc (from which the loader knows $ORIGIN) mounted for it alone."""
    return call("unshare", "--mount", "sh", "-c", 'mount -t proc proc "$0/proc" && exec chroot "$0" "$@"', root, *words, **options)


def use(root, program, share):
    """Runs an example with the installed program in the root and looks into its result."""
    def inside(*words):
        return in_root(root, "/usr/bin/env", "-i", "PATH=/usr/bin:/bin:/usr/sbin:/sbin", "HOME=/root", *words)

    assert inside(program, "--version").startswith("surveymc ")
    inside(program, "run", f"{share}/configs/examples/own_well_uncertainty.toml", "-o", "/tmp/out.h5")
    assert "covariance_by_source" in inside(program, "show", "/tmp/out.h5")
    inside(program, "rerun", "/tmp/out.h5")
    os.remove(os.path.join(root, "tmp/out.h5"))
    return inside


with tempfile.TemporaryDirectory(prefix="surveymc-packages-") as folder:
    call(cpack, "-B", folder, cwd=build)
    (deb,), (tarball,) = glob.glob(folder + "/*.deb"), glob.glob(folder + "/*.tar.gz")
    root = os.environ.get("SURVEYMC_CHROOT") or os.path.join(folder, "root")
    if not os.path.exists(os.path.join(root, "usr/bin/env")):
        made = subprocess.run(["debootstrap", "--variant=minbase", suite, root, mirror], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if made.returncode:
            print(f"skipped: debootstrap: {made.stdout[-500:]}")
            sys.exit(77)

    name = os.path.basename(tarball).removesuffix(".tar.gz")
    call("tar", "-xzf", tarball, "-C", os.path.join(root, "opt"))
    use(root, f"/opt/{name}/bin/surveymc", f"/opt/{name}/share/surveymc")
    licences = os.path.join(root, "opt", name, "share/doc/surveymc/licences")
    with open(os.path.join(licences, "README.txt"), encoding="utf-8") as file:
        index = file.read()
    for library in os.listdir(os.path.join(root, "opt", name, "lib/surveymc")):
        if not os.path.islink(os.path.join(root, "opt", name, "lib/surveymc", library)):
            named = [line.split(":")[0] for line in index.splitlines() if library.split(".so")[0] in line]
            assert named and os.path.getsize(os.path.join(licences, named[0])) > 0, f"{library}: {index}"
    print("the tarball runs on a minimal root, with nothing installed")

    shutil.copy(deb, os.path.join(root, "tmp/surveymc.deb"))
    for file in ("/etc/resolv.conf", *glob.glob("/etc/apt/apt.conf.d/*proxy*")):
        if os.path.exists(file):
            shutil.copy(file, os.path.join(root, file.lstrip("/")))
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive", "LC_ALL": "C"}
    in_root(root, "apt-get", "update", env=environment)
    in_root(root, "apt-get", "install", "-y", "--no-install-recommends", "/tmp/surveymc.deb", env=environment)
    inside = use(root, "surveymc", "/usr/share/surveymc")
    code = ("import surveymc; r = surveymc.run('/usr/share/surveymc/configs/examples/own_well.toml', trials=50);"
            "print(len(r.table('position')), len(surveymc.plot(r)))")
    rows, figures = inside("python3", "-c", code).split()
    assert int(rows) > 0 and int(figures) > 0
    assert "--readings" in inside("surveymc", "import", "--help")
    inside("surveymc", "run", "/usr/share/surveymc/configs/reliability/fig1.toml", "-o", "/tmp/fig1.h5")
    inside("surveymc", "report", "/tmp/fig1.h5", "-o", "/tmp/report")
    assert "No figure" not in open(os.path.join(root, "tmp/report/index.html"), encoding="utf-8").read()
    in_root(root, "apt-get", "remove", "-y", "surveymc", env=environment)
    assert not os.path.exists(os.path.join(root, "usr/bin/surveymc"))
    print("the package installs, runs, draws and is removed")
