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


def as_keys(text, prefix="survey."):
    """A message with the keys of surveymc's configs for this script's options: with its value, a key is as a config has it."""
    def key(option):
        return prefix + option.replace("-", "_")

    def choice(m):
        words = [f'"{w}"' for w in m[2].split("|")]
        return f"{key(m[1])} = {', '.join(words[:-1])} or {words[-1]}"

    text = re.sub(r"--(skip-lines|columns) (\d[\d,-]*|\w+=[^ ;:]+)", lambda m: f'{key(m[1])} = "{m[2]}"', text)
    text = re.sub(r"--([a-z][a-z-]+) (\w+(?:\|\w+)+)", choice, text)
    text = re.sub(r"--([a-z][a-z-]+) ([A-Z]+)\b", lambda m: f'{key(m[1])} = "{m[2]}"', text)
    text = re.sub(r"--(decimal|unusual) (point|comma|allow)\b", lambda m: f'{key(m[1])} = "{m[2]}"', text)
    text = re.sub(r"--([a-z][a-z-]+)(?= [\w.]+=| \d)", lambda m: f"{key(m[1])} =", text)
    return re.sub(r"--([a-z][a-z-]+)", lambda m: key(m[1]), text)
