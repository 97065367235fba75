"""Axes of sensors that do not lie along the axes of the tool: which axis of the file, with which sign, is x, y, z."""

import argparse
import re

from .problem import shown


def turns(value):
    """--axes g=-y-x+z,b=+x+y-z: {"g": [(axis from 0, is negative) for x, y, z]}."""
    found = {}
    for part in value.split(","):
        hit = re.fullmatch(r"\s*([gb])=([+-][xyz])([+-][xyz])([+-][xyz])\s*", part, re.I)
        if not hit or {word[1].lower() for word in hit.groups()[1:]} != set("xyz"):
            raise argparse.ArgumentTypeError(f"'{shown(part)}': must be g= or b= and the three axes with signs, such as g=-y-x+z,b=+x+y-z")
        found[hit[1].lower()] = [("xyz".index(word[1].lower()), word[0] == "-") for word in hit.groups()[1:]]
    return found


def turn(stations, wanted):
    """Takes the readings of `stations` to the tool's axes; digits stay as they are."""
    for kind, axes in wanted.items():
        at = [stations.roles.index(kind + axis) for axis in "xyz"]
        for texts, values in zip(stations.texts, stations.values):
            old_texts, old_values = [texts[i] for i in at], [values[i] for i in at]
            for i, (axis, is_negative) in zip(at, axes):
                texts[i] = negative(old_texts[axis]) if is_negative else old_texts[axis]
                values[i] = -old_values[axis] if is_negative else old_values[axis]


def negative(text):
    return text[1:] if text.startswith("-") else "-" + text.removeprefix("+")


def said(wanted):
    """Lines of the account, as (word, text)."""
    names = {"g": "accelerometers", "b": "magnetometers"}
    return [("axes", f"{names[kind]} x, y, z are {', '.join('+-'[minus] + 'xyz'[axis] for axis, minus in axes)} of the file (--axes)")
            for kind, axes in wanted.items()]
