"""One horizontal error ellipse, and the points to draw it."""

import dataclasses

import numpy as np


@dataclasses.dataclass(frozen=True)
class Ellipse:
    """A horizontal one-sigma error ellipse: (x - centre)' C^-1 (x - centre) = 1 with x = (north, east).

    center_north, center_east, semi_major, semi_minor are in metres; azimuth_deg is the direction of the major axis,
    clockwise from north. `row` has all columns of the table for this ellipse (ratios, coverage, verdict, ...).
    """

    center_north: float
    center_east: float
    semi_major: float
    semi_minor: float
    azimuth_deg: float
    row: dict = dataclasses.field(default_factory=dict, repr=False, compare=False)

    @property
    def covariance(self):
        """C = [[nn, ne], [ne, ee]] in m2, whose eigenvectors are the axes."""
        t = np.radians(self.azimuth_deg)
        axes = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
        return axes @ np.diag([self.semi_major**2, self.semi_minor**2]) @ axes.T

    def outline(self, k=1.0, count=361):
        """Points of the k-sigma ellipse: (north, east), two arrays of `count` metres; the last point is the first."""
        t = np.linspace(0, 2 * np.pi, count)
        along, across = k * self.semi_major * np.cos(t), k * self.semi_minor * np.sin(t)
        ca, sa = np.cos(np.radians(self.azimuth_deg)), np.sin(np.radians(self.azimuth_deg))
        return self.center_north + along * ca - across * sa, self.center_east + along * sa + across * ca

    def plot(self, k=1.0, axes=None, **look):
        """Draws the k-sigma ellipse on a map of matplotlib (east to the right, north up, equal scales); returns the axes.

        axes: where to draw (a new figure); look: of the line, as matplotlib's plot() takes it.
        """
        import matplotlib.pyplot as plt

        if axes is None:
            axes = plt.figure().add_subplot(aspect="equal", xlabel="east (m)", ylabel="north (m)")
        north, east = self.outline(k)
        axes.plot(east, north, **look)
        return axes
