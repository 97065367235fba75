#!/usr/bin/python3
"""Table and figure of a comparison: who does how many Monte-Carlo MSA runs per second, and do the answers agree?

    report.py ROUNDS.jsonl [-o FOLDER]

ROUNDS.jsonl has one line per peer and round, as run.sh makes it. Prints the tables and writes compare_peers.csv, .png
and .svg. Exit code 1 if a peer's mean or standard deviation of any parameter differs from another's by more than
chance allows, if a run of a peer did not converge, or if surveymc's answer depends on its number of threads.
"""

import argparse
import csv
import io
import json
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../scripts"))

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from surveymc import streams  # noqa: E402
from msa_case import PARAMETERS, UNITS  # noqa: E402
from surveymc.plots import drawing, reading, saving, wording  # noqa: E402

# In the order of the tables: name, label, colour. `surveymc_1` is what the others are compared with.
PEERS = (
    ("surveymc_1", "surveymc", "#0072B2"),
    ("surveymc_2", "surveymc, 2 threads", "#56B4E9"),
    ("tiny", "Ceres TinySolver", "#D55E00"),
    ("normal_cholesky", "Ceres, normal equations", "#D55E00"),
    ("qr", "Ceres, QR", "#D55E00"),
    ("leastsq", "SciPy leastsq", "#777777"),
    ("least_squares", "SciPy least_squares", "#777777"),
)
OURS, OURS_2 = "surveymc_1", "surveymc_2"
MAX_Z = 4.5  # about 200 comparisons: chance exceeds it once in a thousand reports


class Peer:
    """All rounds of one peer: rates, and estimates pooled over the rounds."""

    def __init__(self, rounds):
        self.rounds = rounds
        self.version = rounds[0]["version"]
        self.rates = np.array([r["runs"] / r["seconds"] for r in rounds])
        self.rate = float(np.median(self.rates))
        self.cpu_rate = float(np.median([r["runs"] / r["cpu_seconds"] for r in rounds]))
        threads = 2 if rounds[0]["peer"] == OURS_2 else 1
        self.busy = float(np.median([r["cpu_seconds"] / (threads * r["seconds"]) for r in rounds]))
        self.runs = sum(r["runs"] for r in rounds)
        self.failed = sum(r["failed"] for r in rounds)
        self.evaluations = self.optional(lambda r: r["evaluations"])
        self.noise_share = self.optional(lambda r: r["noise_seconds"] / r["seconds"])
        n = np.array([r["runs"] - r["failed"] for r in rounds], float)[:, None]
        means, sds = (np.array([r[k] for r in rounds]) for k in ("mean", "sd"))
        self.mean = (n * means).sum(axis=0) / n.sum()
        squares = ((n - 1) * sds**2 + n * (means - self.mean) ** 2).sum(axis=0)
        self.sd = np.sqrt(squares / (n.sum() - 1))
        kurtosis = np.average([r["kurtosis"] for r in rounds], axis=0, weights=n[:, 0])
        self.mean_error = self.sd / math.sqrt(n.sum())
        self.sd_error = self.sd * np.sqrt((kurtosis - 1) / (4 * n.sum()))

    def optional(self, value):
        return float(np.median([value(r) for r in self.rounds])) if "evaluations" in self.rounds[0] else math.nan


def read(path):
    rounds = {}
    try:
        with open(path) as f:
            for line in f:
                r = json.loads(line)
                rounds.setdefault(r["peer"], []).append(r)
    except (OSError, ValueError, KeyError) as error:
        raise reading.PlotError(f"{path}: cannot be read: {error}") from None
    unknown = set(rounds) - {name for name, _, _ in PEERS}
    if unknown or OURS not in rounds:
        raise reading.PlotError(f"{path}: needs rounds of {OURS}" + (f", does not know {unknown}" if unknown else ""))
    return {name: Peer(rounds[name]) for name, _, _ in PEERS if name in rounds}


def processor():
    try:
        with open("/proc/cpuinfo") as f:
            return next(line.split(":", 1)[1].strip() for line in f if line.startswith("model name"))
    except (OSError, StopIteration):
        return "unknown processor"


def share(value):
    return "-" if math.isnan(value) else f"{100 * value:.0f} %"


def print_speed(peers):
    ours = peers[OURS]
    count = len(ours.rounds)
    print(f"\nMonte-Carlo MSA, runs per second: median of {count} round{'s' if count > 1 else ''}; {processor()}")
    print(f"{'':<24} {'runs/s':>9} {'min':>9} {'max':>9} {'per CPU s':>9}  {'surveymc /':>10}  {'evaluations':>11}"
          f" {'noise':>6} {'failed':>7}")
    for name, label, _ in PEERS:
        if name not in peers:
            continue
        p = peers[name]
        evaluations = "-" if math.isnan(p.evaluations) else f"{p.evaluations:.2f}"
        print(f"{label:<24} {p.rate:9.3g} {p.rates.min():9.3g} {p.rates.max():9.3g} {p.cpu_rate:9.3g}"
              f"  {ours.rate / p.rate:10.3g}  {evaluations:>11} {share(p.noise_share):>6} {p.failed:>7}")
    ceres, scipy = best(peers, "Ceres"), best(peers, "SciPy")
    for label, name in (ceres, scipy):
        if name:
            print(f"surveymc is {ours.rate / peers[name].rate:.3g} times the fastest of {label}"
                  f" ({dict((n, t) for n, t, _ in PEERS)[name]})")
    if OURS_2 in peers:
        print(f"two threads are {peers[OURS_2].rate / ours.rate:.3g} times one")
    starved = [label for name, label, _ in PEERS if name in peers and peers[name].busy < 0.95]
    if starved:
        print("NOTE: the machine was busy: no full core was left for " + ", ".join(starved))
    print("evaluations: calls of the model per run, with or without Jacobian; noise: its share of the time")
    print("versions: " + "; ".join(dict.fromkeys(p.version for p in peers.values())))


def best(peers, family):
    """(family, name of its fastest peer or None)"""
    names = [n for n, label, _ in PEERS if label.startswith(family) and n in peers]
    return family, max(names, key=lambda n: peers[n].rate, default=None)


def print_answers(peers):
    """Prints the standard deviations; returns what is wrong with the answers."""
    wrong = []
    shown = [(name, label) for name, label, _ in PEERS if name in peers and name != OURS_2]
    worst = 0.0
    for i, (a, label_a) in enumerate(shown):
        for b, label_b in shown[:i]:
            for what in ("mean", "sd"):
                va, vb, ea, eb = (getattr(peers[p], k) for k in (what, what + "_error") for p in (a, b))
                z = (va - vb) / np.hypot(ea, eb)
                worst = max(worst, float(np.max(np.abs(z))))
                wrong += [f"{what} of {p}: {label_a} and {label_b} differ by {zi:.1f} standard errors"
                          for p, zi in zip(PARAMETERS, z) if not abs(zi) <= MAX_Z]
    print("\nstandard deviations of the estimates (in brackets: from surveymc's, in standard errors)")
    print(f"{'':<9} {'':<3}" + "".join(f" {label:>23}" for _, label in shown))
    print(f"{'runs':<9} {'':<3}" + "".join(f" {peers[n].runs:>23}" for n, _ in shown))
    ours = peers[OURS]
    for i, (parameter, unit) in enumerate(zip(PARAMETERS, UNITS)):
        cells = []
        for name, _ in shown:
            p = peers[name]
            z = (p.sd[i] - ours.sd[i]) / math.hypot(p.sd_error[i], ours.sd_error[i])
            cells.append(f"{p.sd[i]:.5g}" + ("" if name == OURS else f" ({z:+.1f})"))
        print(f"{parameter:<9} {unit:<3}" + "".join(f" {c:>23}" for c in cells))
    for name, label, _ in PEERS:
        if name in peers and peers[name].failed:
            wrong.append(f"{label}: {peers[name].failed} of {peers[name].runs} runs did not converge")
    if OURS_2 in peers:
        one, two = ([(r["runs"], r["mean"], r["sd"]) for r in peers[n].rounds] for n in (OURS, OURS_2))
        if one != two:
            wrong.append("surveymc: one and two threads give different answers")
    print(f"means and standard deviations, all pairs: at most {worst:.1f} standard errors apart (limit {MAX_Z})")
    return wrong


def write_csv(peers, folder):
    path = os.path.join(folder, "compare_peers.csv")
    ours = peers[OURS].rate
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    out.writerow(["peer", "version", "rounds", "runs", "failed", "runs_per_s", "runs_per_s_min", "runs_per_s_max", "runs_per_cpu_s",
                  "surveymc_ratio", "evaluations", "noise_share"] +
                 [f"{what}_{p}{'_nT' if u == 'nT' else ''}" for what in ("mean", "sd") for p, u in zip(PARAMETERS, UNITS)])
    for name, label, _ in PEERS:
        if name in peers:
            p = peers[name]
            numbers = [p.rate, p.rates.min(), p.rates.max(), p.cpu_rate, ours / p.rate, p.evaluations, p.noise_share]
            out.writerow([label, p.version, len(p.rounds), p.runs, p.failed] + ["" if math.isnan(v) else f"{v:.5g}" for v in numbers] +
                         [f"{v:.9g}" for v in (*p.mean, *p.sd)])
    saving.write(path, text.getvalue().encode(), lambda name: False)
    print(path)


def draw(peers, folder):
    drawing.use_style()
    shown = [(label, colour, peers[name]) for name, label, colour in PEERS if name in peers]
    figure, axes = plt.subplots(figsize=(7.2, 0.75 + 0.36 * len(shown)), layout="constrained")
    y = np.arange(len(shown))[::-1]
    rates = np.array([p.rate for _, _, p in shown])
    spread = np.array([[p.rate - p.rates.min(), p.rates.max() - p.rate] for _, _, p in shown]).T
    axes.barh(y, rates, color=[c for _, c, _ in shown], height=0.66)
    axes.errorbar(rates, y, xerr=spread, fmt="none", color="black", linewidth=0.8, capsize=2)
    ours = peers[OURS].rate
    for at, (_, _, p) in zip(y, shown):
        ratio = p.rate / ours
        note = "" if p is peers[OURS] else (f"\N{MULTIPLICATION SIGN} {wording.number(ratio)}" if ratio > 1 else
                                            f"1 / {wording.number(1 / ratio, 2 if ratio > 0.1 else 3)}")
        axes.annotate(f"{thousands(p.rate)}   {note}", (max(p.rates.max(), p.rate), at), (6, 0),
                      textcoords="offset points", va="center", fontsize=9)
    axes.set_yticks(y, [label for label, _, _ in shown])
    axes.set_xscale("log")
    low = 10 ** math.floor(math.log10(rates.min() * 0.7))
    axes.set_xlim(low, rates.max() * (rates.max() / low) ** 0.38)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("runs per second, and relative to surveymc")
    axes.set_title("Monte-Carlo MSA of 53 stations, one thread unless said otherwise")
    saving.save(figure, folder, "compare_peers")


def thousands(value):
    """932 145 as '932 000': three significant digits."""
    rounded = round(value, 2 - int(math.floor(math.log10(value))))
    return f"{rounded:,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rounds", help="file of run.sh, a line of JSON per peer and round")
    parser.add_argument("-o", "--output", metavar="FOLDER", default="results")
    a = parser.parse_args()
    peers = read(a.rounds)
    folder = saving.figures_folder(a.output, a.rounds)
    print_speed(peers)
    wrong = print_answers(peers)
    print()
    write_csv(peers, folder)
    draw(peers, folder)
    if wrong:
        raise reading.PlotError("the answers do not agree: " + "; ".join(wrong), 1)


if __name__ == "__main__":
    streams.run(main)
