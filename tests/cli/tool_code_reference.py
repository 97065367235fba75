"""Covariances of tool codes, written from the rules of docs/conventions.md and nothing of the program: an oracle for tests.

Formulas are evaluated by Python, station by station. Every draw (an error that stations share) keeps the sum of its effects.
"""
import math
import tomllib
from pathlib import Path

import numpy as np

RAD = math.pi / 180
UNITS = {"m": 1, "1/m": 1, "-": 1, "m/s2": 1, "nT": 1, "deg": RAD, "deg.nT": RAD, "deg/hr": RAD / 3600, "deg/sqr(hr)": RAD / 60}
NAMES = {"sin": math.sin, "cos": math.cos, "tan": math.tan, "abs": abs, "sqrt": math.sqrt, "max": max, "min": min,
         "sign": lambda x: 1 if x >= 0 else -1, "pi": math.pi, "rad": RAD, "__builtins__": {}}


def read(*files):
    """Functions and models of TOML files, by name. Of `extends` it knows one step, without `remove`."""
    functions, models = {}, {}
    for file in files:
        content = tomllib.loads(Path(file).read_text())
        functions |= {f["name"]: f for f in content.get("function", [])}
        models |= {m["name"]: m for m in content.get("model", [])}
    for name, m in models.items():
        if "extends" in m:
            base = models[m["extends"]]
            terms = {t["code"]: t for t in base["terms"] + m["terms"]}
            models[name] = base | m | {"terms": list(terms.values())}
    return functions, models


def evaluate(formula, variables):
    return eval(formula.lower().replace("^", "**"), NAMES, variables)  # noqa: S307: shipped formulas


def tangents(inclination, azimuth):
    return np.stack([np.sin(inclination) * np.cos(azimuth), np.sin(inclination) * np.sin(azimuth), np.cos(inclination)], -1)


def vertical_depths(md, t):
    beta = 2 * np.arctan2(np.linalg.norm(t[1:] - t[:-1], axis=1), np.linalg.norm(t[1:] + t[:-1], axis=1))
    ratio = np.where(beta > 1e-6, np.tan(beta / 2) / np.maximum(beta / 2, 1e-9), 1 + beta ** 2 / 12)
    return md[0] + np.concatenate([[0], np.cumsum(np.diff(md) / 2 * ratio * (t[1:, 2] + t[:-1, 2]))])


def initialisations(gyro, stations, inclination, azimuth):
    """Of each station of a leg: its section, and (inclination, azimuth) at the initialisation; None: stationary."""
    gate, before = gyro["initialise_at_deg"], stations[0] - 1
    section, held, out = 0, None, []
    listed = azimuth[before]
    for k in stations:
        if gate == "leg start":
            held = inclination[before], azimuth[before]
        elif inclination[k] >= gate * RAD:
            held = held or (gate * RAD, listed)
        else:
            section += held is not None
            held, listed = None, azimuth[k]
        out.append((section, held))
    return out


def covariances(md, inclination, azimuth, legs, functions, field):
    """NEV covariance of every station. Radians, azimuths true; legs: (from_md, model); field: total, dip, g, declination,
    latitude."""
    n, t = len(md), tangents(inclination, azimuth)
    tvd = vertical_depths(md, t)
    leg_of = [max(i for i, (start, _) in enumerate(legs) if i == 0 or depth > start + 1e-3) for depth in md]
    draws = {}
    for number, (_, model) in enumerate(legs):
        stations = [k for k in range(1, n) if leg_of[k] == number]
        parameters, gyro = model.get("parameters", {}), model.get("gyro")
        factor = parameters.get("NoiseReductionFactor", 1)
        states = initialisations(gyro, stations, inclination, azimuth) if gyro else [(0, None)] * len(stations)
        for term in model["terms"]:
            f, size, mode = functions[term["function"]], term["magnitude"] * UNITS[term["unit"]], term["mode"]
            kind, running, running_section = f.get("kind", "station"), 0.0, -1
            for k, (section, held) in zip(stations, states):
                turn = (azimuth[k] - azimuth[k - 1] + math.pi) % (2 * math.pi) - math.pi
                v = {"md": md[k], "mdprev": md[k - 1], "tvd": tvd[k], "inc": inclination[k], "incprev": inclination[k - 1],
                     "azt": azimuth[k], "azprev": azimuth[k] - (0 if inclination[k - 1] < 1e-4 * RAD else turn),
                     "azm": azimuth[k] - field["declination"], "dip": field["dip"], "bfield": field["total"],
                     "gfield": field["g"], "latitude": field["latitude"], "earthrate": 15.041067 * RAD / 3600,
                     "mincourselength": parameters.get("MinCourseLength_m", 10), "noisereductionfactor": 1 if gyro else factor,
                     "xcltortuosity": parameters.get("XCLTortuosity_deg_per_100ft", 1) * RAD / 30.48}
                depth = tilt = lateral = 0.0
                if kind == "continuous":
                    if section != running_section:
                        running, running_section = 0.0, section
                    for zone in gyro["zones"]:
                        if zone["axis"] == f["axis"] and zone["from_deg"] * RAD <= inclination[k] and (
                                zone is gyro["zones"][-1] or inclination[k] < zone["to_deg"] * RAD):
                            speed = zone["speed_m_per_h"] / 3600
                            running = evaluate(f["azimuth"], v | {"previous": running, "runningspeed": speed})
                            break
                    if held is None:
                        continue
                    lateral = running * math.sin(inclination[k])
                else:
                    if kind == "stationary" and held is not None:
                        v |= {"inc": held[0], "azt": held[1], "noisereductionfactor": factor}
                    depth, tilt = (evaluate(f.get(key, "0"), v) for key in ("depth", "inclination"))
                    lateral = (evaluate(f["lateral"], v) if "lateral" in f
                               else math.sin(inclination[k]) * evaluate(f.get("azimuth", "0"), v))
                ci, si = math.cos(inclination[k]), math.sin(inclination[k])
                ca, sa = math.cos(azimuth[k]), math.sin(azimuth[k])
                angle = size * (tilt * np.array([ci * ca, ci * sa, -si]) + lateral * np.array([-sa, ca, 0.0]))
                length = md[k] - md[k - 1]
                if kind == "course":
                    own = beyond = length * angle
                else:
                    doubled = 2 if k == 1 and model["first_leg"] == "doubled" else 1
                    own = beyond = size * depth * (t[k - 1] + t[k]) / 2 + doubled * length / 2 * angle
                    if k + 1 < n:
                        beyond = own - size * depth * (t[k] + t[k + 1]) / 2 + (md[k + 1] - md[k]) / 2 * angle
                if mode in "GW":
                    shared_by = "well"
                elif mode == "S":
                    shared_by = (number, section if f.get("per_section") else "leg")
                else:
                    in_section = kind in ("stationary", "continuous") and held is not None
                    shared_by = (number, section) if in_section else k
                draws.setdefault((term["code"], mode, shared_by), []).append((k, beyond, own))
    c = np.zeros((n, 3, 3))
    for effects in draws.values():
        total = np.zeros((n, 3))
        for k, beyond, own in effects:
            total[k] += own
            total[k + 1:] += beyond
        c += total[:, :, None] * total[:, None, :]
    return c
