"""Words and numbers of figures: what readers call a key, a quantity, a value."""

import math
import re

import numpy as np

from .. import streams
from .reading import MOST_POINTS, text_attribute


SIGMA = "\N{GREEK SMALL LETTER SIGMA}"


def name_of(values):
    """Values of a point as part of a file's name: other points have other names."""
    return re.sub(r"[^A-Za-z0-9.+-]+", "_", " ".join(str(v) for v in values)).strip("_")


def plain_text(text):
    """A text of the user for a figure: a dollar sign in it begins no formula, and what is not seen is an escape."""
    return streams.visible(text).replace("$", r"\$")


def title_of(file):
    """The title of a result, or of what experiment it is."""
    return plain_text(text_attribute(file, "title")) or text_attribute(file, "experiment").replace("_", " ").capitalize()


# What readers of a figure call a key of the sweep and its values; others are named by the last part of the key.
POINT_WORDS = {
    "estimator.name": "{}", "estimator.method": "{}", "error_model.name": "{}", "error_model": "{}", "drilling.mode": "{}", "mode": "{}",
    "noise.scale": "noise \N{MULTIPLICATION SIGN} {}", "noise.law": "{} noise",
    "noise.reference.per": "reference drawn per {}", "sensor_errors.multiplier": "errors \N{MULTIPLICATION SIGN} {}",
    "errors.multiplier": "errors \N{MULTIPLICATION SIGN} {}", "errors.vertical": "lateral errors as {}", "sensor.spread.axial_bias_nT": "axial bias sd {} nT", "well.stations": "{} stations", "well.kind": "{} well",
    "spacing_m": "stations {} m apart", "drilling.sequence": "toolface sequence {}",
    "model.truth_references": "references {} in truth", "factor": "error \N{MULTIPLICATION SIGN} {}",
    "problem.name": "{}", "sampling.method": "method {}"}
POINT_SWITCHES = {
    "reference_law.each_term": {"false": "one V an element", "true": "a V each term"},
    "reference_law.shared_mixing": {"false": "a V each element", "true": "one V for all"}}
VALUE_WORDS = {
    "msa": "MSA", "msa_weighted": "weighted MSA", "msa_joint": "joint MSA", "wls": "WLS", "wls_consider": "WLS with considered reference",
    "sse": "single station", "sse_axial": "single station, axial correction", "mse_fixed": "many stations, references fixed",
    "mse_shared": "many stations, references shared", "gaussian": "normal",
    "form": "FORM", "sorm": "SORM", "nees": "NEES", "nis": "NIS", "aakr_sprt": "AAKR-SPRT", "aakr_kf_sprt": "AAKR-KF-SPRT", "aakr_cusum": "AAKR-CUSUM", "aakr_threshold": "AAKR, threshold",
    "channel_sprt": "SPRT of each channel", "bias_filter": "filter of biases", "gx": "$g_x$", "gy": "$g_y$", "gz": "$g_z$", "bx": "$b_x$", "by": "$b_y$", "bz": "$b_z$", "bonferroni": "Bonferroni"}
OF_SOMETHING = ("random", "walk", "offset", "scale", "wide")  # last parts of keys that say nothing without the one before
COLUMN_WORDS = {  # of tables, where the name with spaces says too little
    "p_miss": "share of misses", "p_detected": "share detected", "p_named": "share that names the right sensor",
    "p_healthy_blamed": "share that blames a healthy sensor", "p_all_found": "share that finds all", "delay_q50": "median delay",
    "delay_q50_stations": "median delay (stations)", "share_sd": "share of attitudes beyond the tolerance, by sd",
    "share_error": "share of attitudes beyond the tolerance, by errors", "sd_median": "median sd", "error_median": "median error",
    "worse_share": "share of directions made worse", "ratio_median": "median ratio", "ratio_best": "least ratio",
    "sd_lateral_median": "median sd across the hole", "sd_lateral_largest": "largest sd across the hole",
    "external_azimuth": "effect on the azimuth", "external_inclination": "effect on the inclination",
    "external_toolface": "effect on the toolface", "ratio_major": "predicted over Monte Carlo, major axis",
    "ratio_minor": "predicted over Monte Carlo, minor axis", "ratio_rms": "rms ratio", "position": "effect on the final position",
    "relative_half_width": "relative half width of the interval", "residual_sd": "sd of the residuals", "md": "measured depth",
    "total": "total field", "multiplier": "errors, multiplied by", "semi_major": "semi-major axis", "semi_minor": "semi-minor axis"}
POINT_UNITS = {"nT": "nT", "deg": "\N{DEGREE SIGN}", "mps2": "m/s\N{SUPERSCRIPT TWO}", "mg": "mg", "m": "m", "z": "z", "h": "h"}


def value_name(value):
    """A value of a key as readers know it."""
    if isinstance(value, (float, np.floating)):
        return f"{value:.4g}" if abs(value) < 1e4 else f"{value:g}"
    return VALUE_WORDS.get(str(value), plain_text(str(value).replace("_", " ")))


def point_name(keys, point):
    """'test 1, noise \N{MULTIPLICATION SIGN} 0.1': a sweep point in words, its case first. keys: of the sweep; point: their values."""
    parts = []
    for key, value in sorted(zip(keys, point), key=lambda kv: kv[0] != "case"):
        if key == "case":
            parts.append(re.sub(r"\b(msa|msa_weighted|msa_joint|wls)\b", lambda word: VALUE_WORDS[word[0]],
                                plain_text(str(value))))
            continue
        if key in POINT_SWITCHES and str(value).lower() in POINT_SWITCHES[key]:
            parts.append(POINT_SWITCHES[key][str(value).lower()])
            continue
        if key in POINT_WORDS:
            parts.append(POINT_WORDS[key].format(value_name(value)))
            continue
        name, _, ending = key.rsplit(".", 1)[-1].rpartition("_")
        unit = POINT_UNITS.get(ending, "") if name else ""
        words = (name if unit else key.rsplit(".", 1)[-1]).replace("_", " ")
        if key.count(".") and words.split()[0] in OF_SOMETHING:
            words = f"{key.split('.')[-2].replace('_', ' ')} {words}"
        words = f"sd of {words}" if key.startswith("sigma.") else words
        gap = "" if unit == POINT_UNITS["deg"] else " "
        parts.append(f"{words} {value_name(value)}{gap + unit if unit else ''}")
    return ", ".join(parts)


def answer_of(result):
    """The first sentence of what a run has found, its keys in words; "" in a result of an older program."""
    def pair(found):
        try:
            return point_name([found[1]], [float(found[2])])
        except ValueError:
            return point_name([found[1]], [found[2]])

    said = next((s for s in result.answer if "too many for a sentence" not in s), "")
    return re.sub(r"\b([a-z]\w*(?:\.\w+)+|[a-z]\w*_(?:nT|mps2|mg|deg|m|z|h)) = ([^,()]+)", pair, plain_text(said))


def quantity_name(name):
    """What readers call a quantity, a formulation or a code of a table: "3σ of gain z" for "sigma3_gain_z"."""
    if name in VALUE_WORDS:
        return VALUE_WORDS[name]
    found = re.fullmatch(r"(sigma3|mean|sd)_(\w+)", name)
    if found:
        return f"{ {'sigma3': '3' + SIGMA, 'mean': 'mean', 'sd': 'sd'}[found[1]]} of {quantity_name(found[2])}"
    return plain_text(name.replace("_", " "))


def axis_name(name):
    """A key or a column as the label of an axis, its unit in brackets: "inclination (\N{DEGREE SIGN})" for "inclination_deg"."""
    parts = name.split(".")
    name = parts[-2] if parts[-1] == "name" and len(parts) > 1 else parts[-1]
    stem, _, ending = name.rpartition("_")
    unit = POINT_UNITS.get(ending, "") if stem else ""
    text = COLUMN_WORDS.get(stem if unit else name) or quantity_name(stem if unit else name)
    if len(parts) > 1 and name.split("_")[0] in OF_SOMETHING:
        text = f"{quantity_name(parts[-2])} {text}"
    elif len(parts) > 1 and parts[0] in ("sigma", "noise"):
        text = f"{'sd' if parts[0] == 'sigma' else 'noise'} of {text}"
    return f"{text} ({unit})" if unit else text


def point_title(title, keys, points, number):
    """Title of a figure of one sweep point; its number where not all points are drawn."""
    if not keys:
        return title
    of_all = f" (point {number} of 0 to {len(points) - 1})" if len(points) > MOST_POINTS else ""
    return f"{title}: {point_name(keys, points[number])}{of_all}"


def cut(line, length):
    """A line of at most this length; no backslash is left without what it stands before."""
    return line if len(line) <= length else line[:length - 1].rstrip("\\") + "\N{HORIZONTAL ELLIPSIS}"


def counts_text(counts):
    """'7 168', or '7 168 to 21 504' where points, or tests, differ."""
    least, most = int(min(counts)), int(max(counts))
    return grouped(least) if least == most else f"{grouped(least)} to {grouped(most)}"


def trials_text(table):
    """'19 935 of 20 000 trials' of a table that counts them; of rows that differ, ranges."""
    run, failed = np.asarray(table["trials"]).astype(int), np.asarray(table["failed"]).astype(int)
    if not failed.any():
        return f"{counts_text(run)} trials"
    return f"{counts_text(run - failed)} of {counts_text(run)} trials ({counts_text(failed)} did not converge)"


def grouped(count):
    """12345 as '12 345'."""
    return f"{count:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def number(value, digits=3):
    """A number for people: `digits` significant digits, no exponent between 1e-4 and 1e5, '-' for none."""
    if not np.isfinite(value):
        return "\N{EN DASH}"
    if value == 0:
        return "0"
    size = int(np.floor(np.log10(abs(value))))
    value = round(value, digits - 1 - size)
    size = int(np.floor(np.log10(abs(value))))  # 9.996 became 10
    text = f"{value:.{max(digits - 1 - size, 0)}f}" if -4 <= size < 5 else f"{value:.{digits - 1}e}"
    return text.replace("-", "\N{MINUS SIGN}")


def plain_size(value):
    """A tick of a logarithmic axis for people: 0.02, 500; of very small and large ones with a power of ten."""
    if 1e-4 <= abs(value) < 1e6 or value == 0:
        return f"{value:g}"
    exponent = math.floor(math.log10(abs(value)) + 1e-9)
    first = f"{value / 10.0**exponent:.3g}"
    return f"$10^{{{exponent}}}$" if first == "1" else f"${first}\\times10^{{{exponent}}}$"
