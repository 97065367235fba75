"""The common task of the peers, written down once more from docs/conventions.md and shared by the Python scripts here:
config and survey -> noise-free readings, and the noise of any trial by its address.

Fields are in nT, vectors in the tool frame; arrays are (3, stations) unless stated.
"""

import csv
import io
import math
import os
import sys
import tomllib

import numpy as np

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../scripts"))
from surveymc import streams  # noqa: E402
from surveymc import whole_file  # noqa: E402

PARAMETERS = ("gain_x", "gain_y", "gain_z", "bias_x", "bias_y", "bias_z")
UNITS = ("1", "1", "1", "nT", "nT", "nT")
STUDY_MSA_POSITION = 1  # part of the address of its random numbers
MAGNETOMETER_NOISE = 0  # channel


class Case:
    """What a config such as configs/bench/msa_traj4.toml asks for: an ideal tool with magnetometer noise only.

    clean, down  noise-free readings (nT) and direction of gravity (unit), (3, stations)
    total        total field, nT, the scale of the biases
    bh, bv       horizontal and vertical reference field, nT
    noise        standard deviation of a reading, nT
    seed, step_tolerance
    """

    def __init__(self, path):
        with open(path, "rb") as f:
            config = tomllib.load(f)
        survey, field = config["survey"], config["field"]
        noise, estimator = config["noise"], config["estimator"]
        known = {"experiment", "title", "seed", "trials", "outputs", "control_variate", "survey", "field", "noise", "estimator", "verdict"}
        if (set(config) - known or set(field) != {"total_nT", "dip_deg"} or set(noise) != {"magnetometer_nT"}
                or estimator["name"] != "msa" or survey.get("azimuth_reference", "true") != "true"):
            raise SystemExit(f"{path}: the peers know an ideal tool with magnetometer noise only, azimuths from true"
                             " north without declination, estimator msa")
        with open(os.path.join(os.path.dirname(path), survey["file"]), newline="") as f:
            rows = list(csv.DictReader(f))
        t, i, a = (np.radians([float(r[k]) for r in rows])
                   for k in ("toolface_deg", "inclination_deg", "azimuth_deg"))
        if survey["toolface_zero"] == "x":
            t = t + math.pi / 2
        dip = math.radians(field["dip_deg"])
        si, ci, sa, ca, st, ct = np.sin(i), np.cos(i), np.sin(a), np.cos(a), np.sin(t), np.cos(t)
        sd, cd = math.sin(dip), math.cos(dip)
        self.total = field["total_nT"]
        self.bh, self.bv = self.total * cd, self.total * sd
        self.down = np.array([-si * st, -si * ct, ci])
        self.clean = self.total * np.array([cd * ci * ca * st + cd * sa * ct - sd * si * st,
                                            cd * ci * ca * ct - cd * sa * st - sd * si * ct,
                                            cd * si * ca + sd * ci])
        self.stations = len(rows)
        self.noise = noise["magnetometer_nT"]
        self.seed = config["seed"]
        self.step_tolerance = estimator["step_tolerance"]

    def readings(self, trial):
        """The magnetometer readings of one trial of surveymc, nT: index 3 station + axis of the noise channel."""
        count = 3 * self.stations
        draws = philox_normals(self.seed, STUDY_MSA_POSITION, trial, MAGNETOMETER_NOISE, count)
        return self.clean + self.noise * draws.reshape(self.stations, 3).T

    def write_geometry(self, path):
        """For the C++ peers. First line: stations, total, bh, bv, noise, step tolerance; then a line per station:
        clean x y z, down x y z. 17 digits."""
        text = io.StringIO()
        head = (self.total, self.bh, self.bv, self.noise, self.step_tolerance)
        text.write(" ".join([str(self.stations)] + [f"{v:.17g}" for v in head]) + "\n")
        np.savetxt(text, np.vstack([self.clean, self.down]).T, fmt="%.17g")
        try:
            whole_file.write(path, text.getvalue().encode(), lambda name: True)
        except OSError as error:
            raise streams.Failure(f"{path}: cannot write: {error.strerror}", streams.CANNOT_WRITE) from None


def philox4x32(counter, key):
    """Philox 4x32-10 (Salmon et al., SC'11). counter: four arrays or numbers, key: two numbers, 32 bits each.
    Returns four uint64 arrays of 32-bit words."""
    low32, by32 = np.uint64(0xFFFFFFFF), np.uint64(32)
    c0, c1, c2, c3 = np.broadcast_arrays(*(np.asarray(c, np.uint64) for c in counter))
    k0, k1 = key
    for _ in range(10):
        p0, p1 = c0 * np.uint64(0xD2511F53), c2 * np.uint64(0xCD9E8D57)
        c0, c1 = (p1 >> by32) ^ c1 ^ np.uint64(k0), p1 & low32
        c2, c3 = (p0 >> by32) ^ c3 ^ np.uint64(k1), p0 & low32
        k0, k1 = (k0 + 0x9E3779B9) & 0xFFFFFFFF, (k1 + 0xBB67AE85) & 0xFFFFFFFF
    return c0, c1, c2, c3


def philox_normals(seed, study, trial, channel, count):
    """Standard normals with indices 0 .. count-1 of (seed, study, trial, channel), as lib/random/stream.h has them."""
    call = np.arange((count + 3) // 4, dtype=np.uint64)
    words = philox4x32((trial & 0xFFFFFFFF, trial >> 32, call, study << 16 | channel),
                       (seed & 0xFFFFFFFF, seed >> 32))
    pairs = [_box_muller(words[0], words[1]), _box_muller(words[2], words[3])]
    return np.array(pairs).reshape(4, -1).T.ravel()[:count]


def _box_muller(w0, w1):
    """Two normals from two words: 39 bits for the radius, two signs, 22 for the angle in the first quadrant, radius and
    angle at the middle of their steps. In double here; surveymc's are singles, right to 1e-7 of a standard deviation."""
    u = ((w0 >> np.uint64(1) << np.uint64(8) | w1 >> np.uint64(24)).astype(float) + 0.5) * 2.0**-39
    angle = np.pi / 2 * ((w1 & np.uint64(0x3FFFFF)).astype(float) + 0.5) * 2.0**-22
    sign0, sign1 = (1.0 - 2.0 * (w1 >> np.uint64(bit) & np.uint64(1)).astype(float) for bit in (23, 22))
    radius = np.sqrt(-2 * np.log(u))
    return sign0 * radius * np.cos(angle), sign1 * radius * np.sin(angle)
