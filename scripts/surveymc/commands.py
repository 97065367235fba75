"""The commands that pip installs: each is one of the scripts."""

import os
import runpy
import sys

from .figures import scripts_folder


def _script(name):
    folder = scripts_folder()
    sys.path.insert(0, folder)  # the scripts share modules
    runpy.run_path(os.path.join(folder, name), run_name="__main__")


def import_survey():
    _script("import_survey.py")


def draw_result():
    _script("draw_result.py")


def report():
    _script("report.py")
