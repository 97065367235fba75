#!/usr/bin/python3
"""The packages on a system of their own: test_packages.py CPACK BUILD_FOLDER [SUITE [MIRROR]]

Makes the .deb and the tarball by cpack and the wheel by pip, a minimal Debian by debootstrap, and uses each in a copy of it by
chroot: the tarball before anything is installed, the wheel in an environment beside Debian's packages, the .deb with what apt
installs for it. None of them has a compiler, before or after. Says how many seconds it takes until a figure of an own well is there: less than
three minutes. Needs root, debootstrap, pip and a mirror; skipped (77) without. Minutes: label nightly. An existing root folder in
SURVEYMC_CHROOT is copied instead of a new one.
"""
# Debian has what the wheel depends on, but does not tell pip so of h5py: --no-deps.
import glob
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time

cpack, build = sys.argv[1], os.path.abspath(sys.argv[2])
suite, mirror = (sys.argv[3:] + ["bookworm", "http://deb.debian.org/debian"][len(sys.argv[3:]):])[:2]
given = os.environ.get("SURVEYMC_CHROOT")
needed = ("chroot", "unshare", "dpkg-shlibdeps", "pip") + (() if given else ("debootstrap",))
missing = [p for p in needed if not shutil.which(p, path=os.environ["PATH"] + ":/usr/sbin:/sbin")]
if os.geteuid() != 0 or missing:
    print(f"skipped: needs root and {', '.join(missing) or 'nothing else'}")
    sys.exit(77)
APT = {**{k: v for k, v in os.environ.items() if k != "TMPDIR"}, "DEBIAN_FRONTEND": "noninteractive", "LC_ALL": "C"}
LIBRARIES = ["python3-h5py", "python3-matplotlib", "python3-munkres", "python3-pandas", "python3-xarray", "python3-jinja2", "python3-xxhash"]
LONGEST_S = 180


def call(*command, **options):
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
    assert done.returncode == 0, f"{' '.join(map(str, command))}: {done.stdout[-3000:]}"
    return done.stdout


class Root:
    """A copy of the minimal system."""

    def __init__(self, base, folder, name):
        self.path = os.path.join(folder, name)
        call("cp", "-a", base, self.path)
        for file in ("/etc/resolv.conf", *glob.glob("/etc/apt/apt.conf.d/*proxy*")):
            if os.path.exists(file):
                shutil.copy(file, self.inside(file))
        self.has_no_compiler()

    def inside(self, path):
        return os.path.join(self.path, path.lstrip("/"))

    def has_no_compiler(self):
        for compiler in ("cc", "gcc", "g++", "clang", "cmake"):
            assert not os.path.lexists(self.inside(f"/usr/bin/{compiler}")), compiler

    def as_root(self, *words):
        """A command in it, with /proc (from which the loader knows $ORIGIN) mounted for it alone."""
        return call("unshare", "--mount", "sh", "-c", 'mount -t proc proc "$0/proc" && exec chroot "$0" "$@"', self.path, *words, env=APT)

    def __call__(self, *words):
        """The same with an empty environment, in the folder /root."""
        return self.as_root("/usr/bin/env", "-i", "-C", "/root", "PATH=/usr/bin:/bin:/usr/sbin:/sbin", "HOME=/root", *words)

    def files_named(self, word):
        """Paths that have the word, of what users and caches have not written."""
        found = call("find", self.path, "-xdev", "-iname", f"*{word}*", "-not", "-path", "*/var/log/*", "-not", "-path", "*/var/cache/*",
                     "-not", "-path", "*/root/*", "-not", "-path", "*/tmp/*")
        return [line.removeprefix(self.path) for line in found.splitlines()]


def processor_s():
    """Of all commands so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def own_well(root, program, begin, what):
    """What a newcomer types: a config, its result, its figures."""
    root(program, "new", "position_covariance", "-o", "well.toml")
    assert "the position is known to" in root(program, "run", "well.toml")
    root(program, "plot", "results/well.h5", "-o", "figures")
    figures = os.listdir(root.inside("/root/figures"))
    assert any(name.endswith(".svg") for name in figures), figures
    root.has_no_compiler()
    seconds, worked = time.monotonic() - begin[0], processor_s() - begin[1]
    said = f"{what}: {seconds:.0f} s ({worked:.0f} s of a processor) from an empty system to {len(figures)} figures of an own well"
    assert worked < LONGEST_S, said  # others may be at work here: the time that passes is theirs, too
    print(said, flush=True)


def use(root, program, share):
    """Runs an example with the installed program and looks into its result."""
    assert root(program, "--version").startswith("surveymc ")
    root(program, "run", f"{share}/configs/examples/own_well_uncertainty.toml", "-o", "/tmp/out.h5")
    assert "covariance_by_source" in root(program, "show", "/tmp/out.h5")
    root(program, "rerun", "/tmp/out.h5")


def tarball_runs(root, tarball):
    name = os.path.basename(tarball).removesuffix(".tar.gz")
    call("tar", "-xzf", tarball, "-C", root.inside("/opt"))
    use(root, f"/opt/{name}/bin/surveymc", f"/opt/{name}/share/surveymc")
    licences = root.inside(f"/opt/{name}/share/doc/surveymc/licences")
    with open(os.path.join(licences, "README.txt"), encoding="utf-8") as file:
        index = file.read()
    for library in os.listdir(root.inside(f"/opt/{name}/lib/surveymc")):
        if not os.path.islink(root.inside(f"/opt/{name}/lib/surveymc/{library}")):
            named = [line.split(":")[0] for line in index.splitlines() if library.split(".so")[0] in line]
            assert named and os.path.getsize(os.path.join(licences, named[0])) > 0, f"{library}: {index}"
    print("the tarball runs on a minimal root, with nothing installed", flush=True)


def wheel_runs(root, wheel):
    begin = time.monotonic(), processor_s()
    root.as_root("apt-get", "update")
    root.as_root("apt-get", "install", "-y", "--no-install-recommends", "python3-venv", *LIBRARIES)
    shutil.copy(wheel, root.inside("/tmp"))
    root("python3", "-m", "venv", "--system-site-packages", "/opt/env")
    root("/opt/env/bin/pip", "install", "--no-index", "--no-deps", f"/tmp/{os.path.basename(wheel)}")
    own_well(root, "/opt/env/bin/surveymc", begin, "wheel")
    use(root, "/opt/env/bin/surveymc", root.as_root("sh", "-c", "echo /opt/env/lib/python3*/site-packages/surveymc/_native/share/surveymc").strip())
    code = "import surveymc; print(surveymc.find_program()); r = surveymc.run('well.toml'); print(len(surveymc.plot(r)))"
    program, figures = root("/opt/env/bin/python", "-c", code).split()
    assert program.startswith("/opt/env/lib/") and program.endswith("/surveymc/_native/bin/surveymc") and int(figures) > 0, program
    assert "--readings" in root("/opt/env/bin/surveymc", "import", "--help")
    root("/opt/env/bin/surveymc", "report", "results/well.h5", "-o", "/tmp/report")
    root("/opt/env/bin/surveymc", "studies", "--quick", "--no-report", "--only", "reliability/fig1")
    assert os.path.exists(root.inside("/root/results/quick/reliability/fig1.h5"))
    assert os.path.getsize(root.inside("/opt/env/share/man/man1/surveymc-run.1")) > 0
    root("/opt/env/bin/pip", "uninstall", "-y", "surveymc")
    assert root.files_named("surveymc") == [], root.files_named("surveymc")
    print("the wheel installs, runs, draws and is removed", flush=True)


def deb_runs(root, deb):
    begin = time.monotonic(), processor_s()
    shutil.copy(deb, root.inside("/tmp/surveymc.deb"))
    root.as_root("apt-get", "update")
    root.as_root("apt-get", "install", "-y", "--no-install-recommends", "/tmp/surveymc.deb")
    own_well(root, "surveymc", begin, ".deb")
    use(root, "surveymc", "/usr/share/surveymc")
    code = ("import surveymc; r = surveymc.run('/usr/share/surveymc/configs/examples/own_well.toml', trials=50);"
            "print(len(r.table('position')), len(surveymc.plot(r)))")
    rows, figures = root("python3", "-c", code).split()
    assert int(rows) > 0 and int(figures) > 0
    assert "--readings" in root("surveymc", "import", "--help")
    root("surveymc", "run", "/usr/share/surveymc/configs/reliability/fig1.toml", "-o", "/tmp/fig1.h5")
    root("surveymc", "report", "/tmp/fig1.h5", "-o", "/tmp/report")
    with open(root.inside("/tmp/report/index.html"), encoding="utf-8") as file:
        assert "No figure" not in file.read()
    doc = root.inside("/usr/share/doc/surveymc")
    with open(f"{doc}/copyright", encoding="utf-8") as file:
        text = file.read()
    assert text.startswith("Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n") and "musl" in text
    with open(f"{doc}/licences/README.txt", encoding="utf-8") as file:
        assert len(re.findall(r"(?m)^\S+\.txt: .*, compiled into the program$", file.read())) >= 7
    assert os.path.getsize(root.inside("/usr/share/man/man1/surveymc-run.1")) > 0
    assert glob.glob(root.inside("/usr/share/surveymc/scripts/surveymc/**/__pycache__"))  # what Python, run by root, has left
    root.as_root("apt-get", "purge", "-y", "surveymc")
    assert root.files_named("surveymc") == [], root.files_named("surveymc")
    print("the package installs, runs, draws, and leaves nothing behind", flush=True)


# /tmp may be a small part of the memory; five systems need about 3 GB.
roomy = None if shutil.disk_usage(tempfile.gettempdir()).free > 6e9 else build
with tempfile.TemporaryDirectory(prefix="surveymc-packages-", dir=roomy) as folder:
    os.environ["TMPDIR"] = folder
    call(cpack, "-B", folder, cwd=build)
    (deb,), (tarball,) = glob.glob(folder + "/*.deb"), glob.glob(folder + "/*.tar.gz")
    with open(os.path.join(build, "CMakeCache.txt"), encoding="utf-8") as file:
        source = re.search(r"(?m)^CMAKE_HOME_DIRECTORY:INTERNAL=(.*)$", file.read())[1]
    call("pip", "wheel", "--no-deps", "--no-index", f"--config-settings=build-dir={build}", "-w", folder, source)
    (wheel,) = glob.glob(folder + "/*.whl")
    base = given or os.path.join(folder, "base")
    if not given:
        made = subprocess.run(["debootstrap", "--variant=minbase", suite, base, mirror], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if made.returncode:
            print(f"skipped: debootstrap: {made.stdout[-500:]}")
            sys.exit(77)
    print(", ".join(f"{os.path.basename(p)} {os.path.getsize(p) / 1e6:.1f} MB" for p in (deb, tarball, wheel)), flush=True)
    tarball_runs(Root(base, folder, "tarball"), tarball)
    wheel_runs(Root(base, folder, "wheel"), wheel)
    deb_runs(Root(base, folder, "deb"), deb)
