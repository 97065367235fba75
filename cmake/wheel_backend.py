"""Builds the wheel of surveymc (PEP 517, pyproject.toml): the program with its libraries, and the Python package around it.

    pip wheel --no-deps .                                            compiles the program: minutes
    pip wheel --no-deps --config-settings=build-dir=build .          takes the program of a build folder

It needs nothing but Python, CMake and what the program is built of: no other package, and no network. A wheel holds what the
tarball of cpack holds, as surveymc/_native; the command surveymc is a script that starts surveymc/_native/bin/surveymc, so
that the Python of an environment draws with the packages of that environment.
"""
import base64
import hashlib
import os
import pathlib
import re
import stat
import subprocess
import tarfile
import tempfile
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
OPTIONS = ["-DCMAKE_BUILD_TYPE=Release", "-DSURVEYMC_TESTS=OFF", "-DSURVEYMC_MPI=OFF"]
# "#!python" becomes the Python of the environment that the wheel is installed in.
SCRIPT = '''#!python
import importlib.util
import os
import sys

found = importlib.util.find_spec("surveymc")  # does not import it
program = os.path.join(found.submodule_search_locations[0], "_native", "bin", "surveymc")
os.environ.setdefault("SURVEYMC_PYTHON", sys.executable)
os.execv(program, [sys.argv[0], *sys.argv[1:]])
'''


def _call(*command):
    subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)


def _tarball(build, folder):
    """Makes the tarball of the program in a build folder, which is configured and built if it is not there."""
    if not (build / "CMakeCache.txt").exists():
        generator = ["-G", "Ninja"] if not subprocess.run(["which", "ninja"], capture_output=True).returncode else []
        _call("cmake", "-S", ROOT, "-B", build, *generator, *OPTIONS)
    _call("cmake", "--build", build, "--target", "surveymc", "--parallel", os.cpu_count() or 1)
    _call("cmake", "-E", "chdir", build, "cpack", "-G", "TGZ", "-B", folder)
    (path,) = pathlib.Path(folder).glob("surveymc-*.tar.gz")
    return path


def _platform():
    """What pip asks for: the C library must be as new as the one that the program was linked with."""
    machine = os.uname().machine
    major, minor = re.search(r"glibc (\d+)\.(\d+)", os.confstr("CS_GNU_LIBC_VERSION")).groups()
    return f"manylinux_{major}_{minor}_{machine}"


def _metadata(project):
    lines = ["Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {project['version']}", f"Summary: {project['description']}",
             f"License: {project['license']['text']}", f"Requires-Python: {project['requires-python']}",
             *(f"Classifier: {c}" for c in project["classifiers"]), *(f"Requires-Dist: {d}" for d in project["dependencies"]),
             "Description-Content-Type: text/markdown", ""]
    return "\n".join(lines) + "\n" + (ROOT / project["readme"]).read_text(encoding="utf-8")


class _Wheel:
    """A zip archive with the table RECORD of its files; each of them has the same time, so that equal contents are equal bytes."""

    def __init__(self, path):
        self.archive, self.record = zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED), []

    def add(self, name, data, executable=False):
        info = zipfile.ZipInfo(name)
        info.compress_type = zipfile.ZIP_DEFLATED
        info.external_attr = (stat.S_IFREG | (0o755 if executable else 0o644)) << 16
        self.archive.writestr(info, data)
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        self.record.append(f"{name},sha256={digest},{len(data)}")

    def close(self, record):
        self.record.append(f"{record},,")
        self.archive.writestr(zipfile.ZipInfo(record), "\n".join(self.record) + "\n")
        self.archive.close()


def _files(tarball):
    """{path in the wheel: (bytes, executable)} of the files of the tarball. A link becomes the file itself: a wheel has no links.
    Of a library with three names only the one that is asked for is taken."""
    with tarfile.open(tarball) as tar:
        members = {m.name.split("/", 1)[1]: m for m in tar.getmembers() if "/" in m.name}
        linked = {os.path.normpath(os.path.join(os.path.dirname(name), m.linkname)) for name, m in members.items()
                  if m.issym() and name.startswith("lib/surveymc/")}
        for name, member in members.items():
            if name.startswith("lib/python3/") or name in linked or member.isdir():
                continue
            target = member
            while target.issym():
                target = members[os.path.normpath(os.path.join(os.path.dirname(target.name.split("/", 1)[1]), target.linkname))]
            package = name.removeprefix("share/surveymc/scripts/")
            if package != name and not package.startswith("surveymc/"):
                continue  # scripts for clusters and for the Python package alone
            place = package if package != name else f"surveymc/_native/{name}"
            yield place, tar.extractfile(target).read(), bool(target.mode & 0o111)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    del metadata_directory
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    given = (config_settings or {}).get("build-dir")
    with tempfile.TemporaryDirectory(prefix="surveymc-wheel-") as folder:
        build = pathlib.Path(os.path.join(ROOT, given)) if given else pathlib.Path(folder) / "build"
        tarball = _tarball(build, os.path.join(folder, "package"))
        base, tag = f"{project['name']}-{project['version']}", f"py3-none-{_platform()}"
        name = f"{base}-{tag}.whl"
        wheel = _Wheel(os.path.join(wheel_directory, name))
        for path, data, executable in _files(tarball):
            manual = re.search(r"share/(man/man1/.*|bash-completion/.*)", path)  # where man and bash look, beside bin/
            wheel.add(f"{base}.data/data/{manual[0]}" if manual else path, data, executable)
        wheel.add(f"{base}.data/scripts/surveymc", SCRIPT.encode(), True)
        info = f"{base}.dist-info"
        wheel.add(f"{info}/METADATA", _metadata(project).encode())
        wheel.add(f"{info}/WHEEL", f"Wheel-Version: 1.0\nGenerator: surveymc\nRoot-Is-Purelib: false\nTag: {tag}\n".encode())
        wheel.add(f"{info}/LICENSE", (ROOT / "LICENSE").read_bytes())
        wheel.close(f"{info}/RECORD")
    return name


def build_sdist(sdist_directory, config_settings=None):
    """The files of the revision that is checked out."""
    del config_settings
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    base = f"{project['name']}-{project['version']}"
    with tempfile.TemporaryDirectory() as folder:
        information = pathlib.Path(folder) / "PKG-INFO"
        information.write_text(_metadata(project), encoding="utf-8")
        _call("git", "-C", ROOT, "archive", "--format=tar.gz", f"--prefix={base}/", f"--add-file={information}", "-o",
              os.path.abspath(os.path.join(sdist_directory, f"{base}.tar.gz")), "HEAD")
    return f"{base}.tar.gz"
