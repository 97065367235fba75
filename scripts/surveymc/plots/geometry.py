"""Error ellipses.

Frames and units are those of docs/conventions.md: north, east, vertical (down) in metres; azimuths in degrees clockwise
from north. On maps east is the abscissa and north the ordinate.
"""

import fractions

import numpy as np

from .reading import PlotError


def ellipse_axes(covariance):
    """Semi axes of the 1-sigma ellipse of a covariance [[nn, ne], [ne, ee]] (m2) and the azimuth of the major one.

    Returns (semi_major, semi_minor, azimuth_deg): the axes are the square roots of the eigenvalues (m), the azimuth
    is that of the eigenvector of the larger one, clockwise from north, in [0, 180). Eigenvalues that rounding made
    negative count as 0: the ellipse is a line. PlotError if the matrix is not a covariance.

    The closed form with an exact determinant, not a general eigenvalue routine: the minor axis of a position error is
    easily a thousandth of the major one, and a general routine loses the square of that in relative accuracy.
    """
    c = np.asarray(covariance, float)
    if c.shape != (2, 2) or not np.all(np.isfinite(c)):
        raise PlotError("a covariance must be 2x2 and finite")
    nn, ne, ee = c[0, 0], (c[0, 1] + c[1, 0]) / 2, c[1, 1]
    major2 = (nn + ee + np.hypot(nn - ee, 2 * ne)) / 2
    if major2 == 0 and nn == 0 and ee == 0:
        return 0.0, 0.0, 0.0
    exact = fractions.Fraction
    minor2 = float(exact(nn) * exact(ee) - exact(ne) ** 2) / major2 if major2 > 0 else -1.0
    if min(nn, ee) < 0 or minor2 < -1e-9 * major2:  # stored elements carry about 1e-15 of the largest
        raise PlotError(f"not a covariance: [[{nn:g}, {ne:g}], [{ne:g}, {ee:g}]] has a negative eigenvalue")
    azimuth = np.degrees(np.arctan2(2 * ne, nn - ee)) / 2
    return float(np.sqrt(major2)), float(np.sqrt(max(minor2, 0.0))), float(azimuth % 180)


def ellipse_points(covariance, k=1.0, centre=(0.0, 0.0), count=361):
    """Points x of the k-sigma ellipse (x - centre)' C^-1 (x - centre) = k^2; returns (north, east), closed.

    covariance: [[nn, ne], [ne, ee]] in m2; centre: (north, east) in m. A singular covariance gives a line.
    """
    major, minor, azimuth = ellipse_axes(covariance)
    return ellipse_points_from_axes(major, minor, azimuth, k, centre, count)


def ellipse_points_from_axes(major, minor, azimuth_deg, k=1.0, centre=(0.0, 0.0), count=361):
    """As ellipse_points, from semi axes (m) and the azimuth of the major one."""
    t = np.linspace(0, 2 * np.pi, count)
    along, across = k * major * np.cos(t), k * minor * np.sin(t)
    ca, sa = np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))
    return centre[0] + along * ca - across * sa, centre[1] + along * sa + across * ca


def is_line(major, minor):
    """Whether an ellipse is degenerate: a minor axis below 1e-6 of the major one is rounding of the covariance, whose
    elements carry 1e-15 of the *square* of the major axis."""
    return minor < 1e-6 * major


def rotate_to_axes(north, east, azimuth_deg):
    """(along, across) the direction azimuth_deg; across is positive to its right (azimuth + 90 deg)."""
    ca, sa = np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))
    return ca * north + sa * east, -sa * north + ca * east


def map_turned(north, east, azimuth_deg):
    """(along, left): the map turned until the direction azimuth_deg points to the right; what lies to its left is up.

    A map that is turned, not mirrored: an ellipse has the shape that it has on the map.
    """
    along, right = rotate_to_axes(north, east, azimuth_deg)
    return along, -right


def ellipse_coverage(k):
    """Probability that a normally distributed point lies inside its k-sigma ellipse."""
    return -np.expm1(-k * k / 2)


COVARIANCE = ("nn_m2", "ne_m2", "nv_m2", "ne_m2", "ee_m2", "ev_m2", "nv_m2", "ev_m2", "vv_m2")


def covariances(table):
    """The 3x3 matrices (north, east, vertical; m2) of all rows of a table; of one row, given as a dict, its matrix."""
    elements = np.array([table[c] for c in COVARIANCE])
    return np.moveaxis(elements.reshape(3, 3, *elements.shape[1:]), (0, 1), (-2, -1))
