"""The commands of surveymc that are written in Python:

    surveymc plot RESULT.h5             its figures
    surveymc report RESULT.h5 ...       pages of results
    surveymc import FILE -o well.csv    a survey or readings in another form to CSV
    surveymc studies                    runs all studies of configs/

The program starts this folder with Python. Where only the package is installed, they are `python3 -m surveymc plot ...`.
"""

import importlib
import importlib.util
import os
import shutil
import subprocess
import sys

_DRAWS = ("numpy", "h5py", "xxhash", "matplotlib")
_PAGE = (*_DRAWS, "pandas", "xarray", "jinja2")
COMMANDS = {"plot": ("surveymc.plots.__main__", _DRAWS), "report": ("surveymc.report.__main__", _PAGE),
            "import": ("surveymc.importer.__main__", ()), "studies": ("surveymc.run_studies", _PAGE)}  # module, packages
OLDEST = (3, 11)
USAGE, NO_MEANS = 64, 71  # exit codes of the program
_PROBE = ("import sys, importlib.util as u; "
          "sys.exit(sys.version_info < tuple(map(int, sys.argv[1].split('.'))) or None in map(u.find_spec, sys.argv[2:]))")


def _other_python(needs):
    """The python3 that is first in PATH, if it is another one and has these packages."""
    other = shutil.which("python3")
    if not other or os.environ.get("SURVEYMC_PYTHON") or os.path.samefile(other, sys.executable):
        return None
    oldest = ".".join(map(str, OLDEST))
    has_all = not subprocess.run([other, "-c", _PROBE, oldest, *needs], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                 stderr=subprocess.DEVNULL).returncode
    return other if has_all else None


def main():
    # Not the folder that it was started from: neither this one, whose modules are no packages of their own, nor the
    # user's, whose files are none of ours.
    here = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
    sys.path[0] = here
    name = sys.argv[1] if len(sys.argv) > 1 else ""
    if name not in COMMANDS:
        says = "a command is missing" if not name else f"{name}: is no command of the Python side"
        print(f"surveymc: {says}: must be one of {', '.join(COMMANDS)}", file=sys.stderr)
        return USAGE
    module, needs = COMMANDS[name]
    missing = [n for n in needs if importlib.util.find_spec(n) is None]
    if missing or sys.version_info < OLDEST:
        if other := _other_python(needs):
            os.execv(other, [other, os.path.join(here, "surveymc"), *sys.argv[1:]])
        lacks = f"lacks {', '.join(missing)}" if missing else f"is older than {'.'.join(map(str, OLDEST))}"
        debian = f"sudo apt install {' '.join('python3-' + n for n in missing)}; or " if missing else ""
        print(f"surveymc {name}: {sys.executable} {lacks}: {debian}name a Python that has {', '.join(needs) or 'it'} in the "
              "environment variable SURVEYMC_PYTHON", file=sys.stderr)
        return NO_MEANS
    del sys.argv[1]
    return importlib.import_module(module).command()


if __name__ == "__main__":
    sys.exit(main())
