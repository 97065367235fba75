"""Command lines of the scripts: where one is wrong, the script ends as the program does."""

import argparse
import difflib
import os
import re
import sys

USAGE = 64  # exit code; argparse's own is 2


class Parser(argparse.ArgumentParser):
    """Says which option may be meant by an unknown one."""

    def __init__(self, **options):
        super().__init__(prog=os.path.basename(sys.argv[0]), **options)

    def error(self, message):
        unknown = re.search(r"unrecognized arguments: (--[\w-]+)", message)
        near = unknown and difflib.get_close_matches(unknown[1], self._option_string_actions, 1, 0.7)
        self.print_usage(sys.stderr)
        self.exit(USAGE, f"{self.prog}: {message}{f'; did you mean {near[0]}?' if near else ''}\n")
