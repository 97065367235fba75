#pragma once
/// What a run cannot tell of the parameters of a set: combinations without effect, and what it knows better than the
/// priors do.
///
/// Two measures. The rank is one of geometry alone: combinations whose condition index is below kHopelessCondition,
/// columns scaled to unit length (estimate/observability.h). What is learnt is against the priors: singular values of
/// J diag(prior sd) above 1, J in units of the residuals' noise; of such a combination the run knows more than the
/// prior.
///
/// Laws, which docs/studies/msa_parameters.md shows by its table:
///   (a) constant inclination: abz and asz are one, whatever the azimuth does: cosI is the same at all stations
///   (b) constant direction: mbz and msz are one
///   (c) slide, which is constant toolface: a cross-axial bias of the magnetometers is a rotation of the triad
///   (d) rz is lost in straight and in vertical holes: it turns the field about the hole, as a change of toolface does
#include <string>
#include <vector>

#include "estimate/observability.h"
#include "multistation/model.h"

namespace surveymc::multistation {

struct SetObservability {
  estimate::Observability combinations;  ///< from the weakest
  Eigen::VectorXd against_prior;         ///< singular values of J diag(prior sd), falling
  int rank = 0;                          ///< combinations that have an effect
  int learnt = 0;                        ///< combinations of which the run knows more than the priors
};

/// `jacobian`: as of jacobian(). Parameters without prior (infinite sd) count as learnt where they have an effect:
/// their prior is taken as 1e6 of the table's.
SetObservability set_observability(const Eigen::MatrixXd& jacobian, const ParameterSet& set,
                                   const PerParameter<double>& prior_sd);

/// The weakest combination j of a set in words: "abz against asz".
std::string combination_name(const SetObservability& o, const ParameterSet& set, int j);

}  // namespace surveymc::multistation
