"""The findings at the head of the report: one sentence of a result, made of its own numbers, for each kind of study."""

import dataclasses
import re

import numpy as np

from ..plots import wording
from .text import counts_sentence, grouped
from .text import number as html_number

MOST = 3  # sentences at the head of the page
NORTH_EAST = ("sigma3_north", "sigma3_east", "sigma_north", "sigma_east")


@dataclasses.dataclass
class Headline:
    """One finding. rank: its place (smaller is first); sentence: plain text; result: id of its part of the page."""

    rank: int
    sentence: str
    result: str
    figure: str = ""


def number(value, digits):
    """A number as plain text: 2.2·10⁻¹²."""
    superscript = str.maketrans("0123456789\N{MINUS SIGN}", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
    return re.sub("<sup>(.*?)</sup>", lambda power: power[1].translate(superscript), html_number(value, digits))


def percent(share):
    """A share of 1 in whole percent; below 1 % with one digit."""
    return f"{100 * share:.1f} %" if 0 < share < 0.0095 else f"{100 * share:.0f} %"


def _point(frame, row):
    keys = [k for k in frame.attrs["sweep_keys"] if k in frame]
    return wording.point_name(keys, [row[k] for k in keys])


def _msa_position(result):
    frame = result.table("position")
    rows = frame[(frame["formulation"] == "joint") & frame["quantity"].isin(NORTH_EAST) & np.isfinite(frame["ratio"])]
    if not len(rows):
        return ""
    off = (rows["ratio"] - 1).abs()
    worst = rows.loc[off.idxmax()]
    where = _point(frame, worst)
    return (f"The joint covariance predicts how uncertain the position is after multi-station analysis: north and east are within "
            f"{percent(off.median())} of Monte Carlo in the median of {len(rows)} comparisons, and within {percent(off.max())} at worst"
            + (f" ({where})." if where else "."))


def _position_covariance(result):
    published = result.table("published") if "published" in result.tables else ()
    if len(published):  # the table is there without rows where a config names no published values
        worst = published["difference_over_trace"].abs().max(skipna=False)
        come_out = "are reproduced" if (published["verdict"] == "agrees").all() else "are held against those computed"
        return (f"{grouped(len(published))} published elements of the covariance of {result.title} {come_out}; the largest "
                f"difference is {number(float(worst), 2)} of the trace." if np.isfinite(worst) else "")
    frame = result.table("covariance")
    last = frame.iloc[-1]
    if not all(np.isfinite(last[c]) for c in ("md_m", "semi_major_m", "semi_minor_m", "major_azimuth_deg")):
        return ""
    named = ", ".join(filter(None, (result.title, _point(frame, last))))
    return (f"{named}: at {number(float(last['md_m']), 5)} m the position is known to {number(float(last['semi_major_m']), 3)} by "
            f"{number(float(last['semi_minor_m']), 3)} m (one-sigma ellipse, major axis at azimuth {last['major_azimuth_deg']:.0f}°).")


def _gross_error(result):
    frame = result.table("detection")
    found = frame[frame["quantity"].str.startswith("detection_") & ~frame["quantity"].isin(("detection_any", "detection_general"))
                  & (frame["formulation"] == "nonlinear")]["monte_carlo"]
    right = frame[frame["quantity"] == "identified"]["monte_carlo"]
    if not len(found) or not len(right):
        return ""
    return (f"Detection is not identification: the test of the wrong reading finds the gross errors of \N{LEFT DOUBLE QUOTATION MARK}"
            f"{result.title}\N{RIGHT DOUBLE QUOTATION MARK} in {percent(found.min())} to {percent(found.max())} of the runs, but the "
            f"reading alone is blamed in {percent(right.min())} to {percent(right.max())}.")


def _msa_benefit(result):
    frame = result.table("summary")
    rows = frame[frame["quantity"] == "azimuth"]
    return (f"Multi-station analysis is no gift: in {percent(rows['worse_share'].min())} to {percent(rows['worse_share'].max())} of the "
            f"directions of the hole the azimuth is worse after it than before ({result.title}).")


def _reliability_well(result):
    frame = result.table("worst_stations")
    row = frame.loc[frame["position_m"].where(np.isfinite(frame["position_m"])).idxmax()]
    return (f"The worst undetected error of one reading ({row['observation']} at {number(float(row['md_m']), 5)} m) moves the end "
            f"of the well by {number(float(row['position_m']), 3)} m ({result.title}).")


OF = {"msa_position": _msa_position, "position_covariance": _position_covariance, "gross_error_detection": _gross_error,
      "msa_benefit": _msa_benefit, "reliability_well": _reliability_well}


def sentence(result, counts):
    """The finding of a result. counts: its verdict counts, which speak where the experiment has no sentence of its own."""
    try:
        own = OF[result.experiment](result) if result.experiment in OF else ""
    except (KeyError, ValueError):  # a result that has not all that a sentence needs
        own = ""
    judged = sum(counts[k] for k in ("agrees", "differs as expected", "undecided", "differs"))
    return own or (f"{result.title}: of {grouped(judged)} predictions and published values, {counts_sentence(counts)}." if judged else "")


def chosen(candidates):
    """At most MOST headlines, the best of each study. candidates: [(experiment, Headline)]."""
    best = {}
    for experiment, headline in candidates:
        if headline.sentence and (experiment not in best or headline.rank < best[experiment].rank):
            best[experiment] = headline
    return sorted(best.values(), key=lambda h: h.rank)[:MOST]
