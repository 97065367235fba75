"""Can this be a survey, can these be readings? What cannot is refused; what is hardly true is said."""

import math
from statistics import median

from .problem import Problem

FOOT = 0.3048
DEEPEST_M = 20000.0
STEEP_DEG_PER_30M = 30.0  # no rotary steerable or short-radius motor in common use builds as fast
SHORTEST_LEG_M = 1.0  # below it the printed digits of the angles make any rate


def metres(stations, row):
    return stations.values[row][0] * (FOOT if stations.heads[0] == "md_ft" else 1.0)


def dogleg_deg(a, b):
    """Angle between two directions (inclination, azimuth in degrees), by half-angle sines: exact for small ones."""
    i, j = math.radians(a[1]), math.radians(b[1])
    half = math.sin((j - i) / 2) ** 2 + math.sin(i) * math.sin(j) * math.sin(math.radians(b[2] - a[2]) / 2) ** 2
    return math.degrees(2 * math.asin(min(1.0, math.sqrt(half))))


def depths(stations, file, options):
    """Depths must increase; for readings they may repeat. A depth that jumps out and back is named, not the one behind it."""
    head, warnings = stations.heads[0], []
    md = [row[0] for row in stations.values]
    for k, place in enumerate(stations.places):
        where = f"{file}:{place}: {head} = {stations.texts[k][0]}"
        if md[k] < 0:
            raise Problem(f"{where}: must not be negative; is the column right (--columns md=...)?")
        if metres(stations, k) > DEEPEST_M and not options.accept_depths:
            raise Problem(f"{where}: must be at most {DEEPEST_M:.0f} m, deeper than any well; are unit and decimal mark right "
                          "(--depth-unit, --decimal)? --accept-depths takes it")
        if k == 0 or md[k] > md[k - 1] or (options.readings and md[k] == md[k - 1]):
            continue
        before = f"{stations.texts[k - 1][0]} ({stations.places[k - 1]})"
        line = place.rsplit(" ", 1)[-1]
        if md[k] == md[k - 1]:
            raise Problem(f"{where}: must be greater than the one before, {before}; one depth stands twice: leave one out: --skip-lines {line}")
        if k >= 2 and md[k] > md[k - 2]:
            out = stations.places[k - 1]
            raise Problem(f"{file}:{out}: {head} = {stations.texts[k - 1][0]}: must be between its neighbours, {stations.texts[k - 2][0]} and "
                          f"{stations.texts[k][0]}: it jumps out and back; correct it, or leave it out: --skip-lines {out.rsplit(' ', 1)[-1]}")
        raise Problem(f"{where}: must be greater than the one before, {before}; correct it, or leave it out: --skip-lines {line}")
    legs = [b - a for a, b in zip(md, md[1:]) if b > a]
    if len(legs) >= 5:
        usual = median(legs)
        for k in range(2, len(md)):  # the first leg comes from the tie-on
            if md[k] - md[k - 1] > 20 * usual:
                warnings.append(f"{file}:{stations.places[k]}: {head} = {stations.texts[k][0]}: {md[k] - md[k - 1]:g} after the one before, "
                                f"where legs are {usual:g}: is a digit wrong, or a part of the survey missing?")
    return warnings


def survey(stations, file, options):
    """(warnings, largest inclination, largest dogleg in deg/30 m with its places)."""
    need(stations, file, 2)
    for k, place in enumerate(stations.places):
        for c, head in enumerate(stations.heads[1:], 1):
            value, where = stations.values[k][c], f"{file}:{place}: {head} = {stations.texts[k][c]}"
            if head.startswith("incl") and not 0 <= value <= 180:
                raise Problem(f"{where}: must be in [0, 180] degrees from vertical; is the column right (--columns inc=...)?")
            if head.startswith("azi") and not 0 <= value <= 360:
                raise Problem(f"{where}: must be in [0, 360] degrees; "
                              + ("azimuths below zero must be written plus 360" if -360 <= value < 0 else "is the column right (--columns azi=...)?"))
            if head.startswith("toolf") and not -360 <= value <= 360:
                raise Problem(f"{where}: must be in [-360, 360] degrees; is the column right, or --no-toolface?")
    warnings = depths(stations, file, options)
    if max(r[1] for r in stations.values) <= math.pi and max(r[2] for r in stations.values) <= 2 * math.pi and \
            max(r[2] for r in stations.values) > 0 and not options.angle_unit:
        warnings.append(f"{file}: no inclination is above 3.15 deg and no azimuth above 6.29 deg: the heading says degrees; are they radians? "
                        "--angle-unit deg says no")
    steepest, at = 0.0, 0
    for k in range(1, len(stations.values)):
        angle = dogleg_deg(stations.values[k - 1], stations.values[k])
        leg = metres(stations, k) - metres(stations, k - 1)
        rate = angle * 30 / max(leg, SHORTEST_LEG_M)
        where = f"{file}:{stations.places[k - 1]} to {stations.places[k]}"
        if rate > steepest:
            steepest, at = rate, k
        if (angle > 179.999 or rate >= 180) and not options.accept_doglegs:
            raise Problem(f"{where}: the hole turns by {angle:.4g} deg over {leg:.4g} m: must be below 180 deg and 180 deg/30 m; "
                          "correct the station, or take it as it is: --accept-doglegs")
        if rate > STEEP_DEG_PER_30M:
            warnings.append(f"{where}: dogleg {rate:.3g} deg/30 m: no common tool drills more than {STEEP_DEG_PER_30M:g}: is an angle wrong?")
    return warnings, max(r[1] for r in stations.values), (steepest, at)


def readings(stations, file, options):
    """(warnings, how many rows repeat a depth). Vectors must be as long as gravity and the field can be."""
    need(stations, file, 1)
    warnings = depths(stations, file, options)
    per_g = {"mg": 1000.0, "mps2": 9.80665}[stations.heads[1].rsplit("_", 1)[1]]
    per_ut = {"uT": 1.0, "nT": 1000.0}[stations.heads[4].rsplit("_", 1)[1]]
    for k, place in enumerate(stations.places):
        g = math.hypot(*stations.values[k][1:4]) / per_g
        b = math.hypot(*stations.values[k][4:7]) / per_ut
        if not 0.5 < g < 2:
            raise Problem(f"{file}:{place}: gx, gy, gz: their vector is {g:.4g} g long: must be in (0.5, 2): is the unit right "
                          "(--gravity-unit), are the columns (--columns)?")
        if not 5 < b < 300:  # instruments that nobody has calibrated read twice the field
            raise Problem(f"{file}:{place}: bx, by, bz: their vector is {b:.4g} uT long: must be in (5, 300): is the unit right "
                          "(--field-unit), are the columns (--columns)?")
    return warnings, sum(b[0] == a[0] for a, b in zip(stations.values, stations.values[1:]))


def need(stations, file, fewest):
    if len(stations.values) < fewest:
        count = len(stations.values)
        raise Problem(f"{file}: {count} station{'' if count == 1 else 's'}: must be at least {fewest}")
