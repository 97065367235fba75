#pragma once
/// Do the covariances of a chained solution claim what the cost says? Near horizontal east or west they do not: the
/// readings see the azimuth through Bh sinA alone, whose slope vanishes there, and only its curvature and the prior of
/// the axial bias hold the azimuth. The cost is then no parabola, and Gauss-Newton's covariance is too small.
///
/// Given the axial bias b of a station, its azimuth is well determined (b_z - b = Bh cosA sinI + Bd cosI). So the cost
/// is minimised at values of b, and the posterior of the azimuth is the mixture over b of the Gaussians found there, by
/// Laplace's approximation of all other unknowns (Tierney and Kadane 1986; nested as in Rue, Martino and Chopin 2009):
///   p(b) ~ det(H(b))^-1/2 exp(-J(b)/2),    azimuth | b ~ N(A(b), s(b)^2)
/// J(b): minimum of the cost over all else, H(b): half its Hessian there. A second minimum is part of the mixture, so
/// its interval holds both. Other stations' biases stay free: a run so long that its bias walks from one side to the
/// other has more minima than are looked for here.
#include "chained/mode_search.h"

namespace surveymc::chained {

struct AxialProfileOptions {
  double cutoff = 20;      ///< J(b) - J beyond which values of b do not count: 4.5 sd
  double parabola = 0.25;  ///< claims hold if J rises by 4 (1 -+ parabola) at 2 claimed sd to both sides: sd to 12 %
  double confidence = 0.95;
  int max_points = 400;  ///< values of b
};

/// Of one station. Angles in rad, azimuth from magnetic north; fields in nT.
struct AxialProfile {
  int station = 0;                             ///< from 0
  double bias = 0, claimed_sd = 0;             ///< axial bias at the lowest minimum, and its sd by the covariance
  double rise_low = 0, rise_high = 0;          ///< J at bias -+ 2 claimed sd, less its minimum; 4 where the claims hold
  bool parabola = false;                       ///< the claims hold: nothing below was computed but by the covariance
  double mean_bias = 0, sd_bias = 0;           ///< of p(b)
  double azimuth = 0, azimuth_claimed_sd = 0;  ///< at the lowest minimum; NaN in a vertical hole
  double azimuth_mean = 0, azimuth_sd = 0;     ///< of the mixture
  double azimuth_low = 0, azimuth_high = 0;    ///< its central interval
  bool complete = true;                        ///< false: max_points, or a minimum that was not found
};

/// `modes`: minima of the same readings, lowest first; not empty. `always`: the mixture even where the claims hold.
AxialProfile profile_azimuth(const Model& model, const Readings& readings, const std::vector<Solution>& modes,
                             int station, const AxialProfileOptions& options = {}, bool always = false);

}  // namespace surveymc::chained
