"""What ends an import, in words: place, value, rule, way out."""

import re

USAGE, DATA, IO = 64, 65, 74


class Problem(Exception):
    """Ends the import with an exit code; nothing has been written then."""

    def __init__(self, text, code=DATA):
        super().__init__(text)
        self.code = code


def shown(value, most=60):
    """A value of the file as it may stand in a message: one line, not long, no control characters."""
    text = "".join(c if c.isprintable() else "?" for c in " ".join(str(value).split()))
    return text if len(text) <= most else text[: most - 3] + "..."


def as_keys(text):
    """A message with the keys of surveymc's configs for this script's options."""
    text = re.sub(r"--(skip-lines|columns) (\d[\d,-]*|\w+=[^ ;:]+)", lambda m: f'survey.{m[1].replace("-", "_")} = "{m[2]}"', text)
    text = re.sub(r"--([a-z][a-z-]+)(?= [\w.]+[|=]| \d)", lambda m: f"survey.{m[1].replace('-', '_')} =", text)
    return re.sub(r"--([a-z][a-z-]+)", lambda m: f"survey.{m[1].replace('-', '_')}", text)
