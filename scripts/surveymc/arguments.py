"""Command lines of the scripts: where one is wrong, the script ends as the program does."""

import argparse
import difflib
import os
import re
import sys

USAGE = 64  # exit code; argparse's own is 2


def nearest(word, names, least=0.6):
    """The name that is most like a word, whatever the case; None if none is like it. `least`: likeness, 0 to 1."""
    small = {str(name).casefold(): str(name) for name in names}
    close = difflib.get_close_matches(str(word).casefold(), small, 1, least)
    return small[close[0]] if close else None


class Parser(argparse.ArgumentParser):
    """Says which option may be meant by an unknown one."""

    def __init__(self, **options):
        super().__init__(prog=os.path.basename(sys.argv[0]), **options)

    def error(self, message):
        unknown = re.search(r"unrecognized arguments: (--[\w-]+)", message)
        near = unknown and nearest(unknown[1], self._option_string_actions, 0.7)
        self.print_usage(sys.stderr)
        self.exit(USAGE, f"{self.prog}: {message}{f'; did you mean {near}?' if near else ''}\n")
