/// Tables of the study `robustness_map`.
#include <cmath>

#include "compare/table_rows.h"
#include "robustness_map/study.h"

namespace surveymc::studies::robustness_map {

store::Table breakdown_table(const Scenario& s, const std::vector<double>& variance_ratios, const stats::Tally& tally) {
  const stats::Moments& m = tally.moments;
  const double confidence = s.verdict.confidence;
  const double parameters = s.fit.parameters.size();
  compare::TableRows t(
      "breakdown",
      "what the right stations contribute to the lateral error of the last position, by loss, over the "
      "fit that knows which stations are wrong" +
          compare::at_confidence(s.verdict));
  for (std::size_t e = 0; e <= s.losses.size(); ++e) {
    const auto mean = [&](Component c) { return m.count > 0 ? m.mean[component(e, c)] : kNaN; };
    const compare::Estimate rms = compare::rms_estimate(m, component(e, kSquare), confidence),
                            nees = compare::mean_estimate(m, component(e, kNees), confidence),
                            ratio = rms_ratio(m, e, 0, confidence);
    t.word("loss",
           "informed: least squares of the right stations; least_squares; l1, huber, cauchy; tukey, which "
           "starts at the least median of squares",
           estimator_name(s, e));
    t.word("kind", "of the gross errors", sensor::gross_kind_names()[static_cast<std::size_t>(s.gross.kind)]);
    t.word("parameters", "that are estimated", s.fit.parameters.name());
    t.count("stations", "that are measured", s.stations());
    t.count("wrong", "of them, in every trial", s.gross.count);
    t.number("size_nT", "nT", "one sd of a gross error along each axis", s.gross.size);
    t.estimate("rms_m", "m", "root mean square of the contribution", rms.value, rms.interval);
    t.estimate("ratio", "1", "of rms_m to that of the informed fit", ratio.value, ratio.interval);
    t.number("predicted_ratio", "1", "to first order where no station is wrong",
             s.gross.count > 0 || e == 0 ? kNaN : std::sqrt(variance_ratios[e - 1]));
    t.estimate(
        "nees", "1",
        "mean squared distance of the estimate from the truth by the covariance that is claimed, over the number "
        "of parameters: 1 if the claim holds",
        nees.value / parameters, {nees.interval.lo / parameters, nees.interval.hi / parameters});
    t.number("right_weight", "1", "mean weight of the right stations", mean(kRightWeight));
    t.number("wrong_weight", "1", "mean weight of the wrong stations", s.gross.count > 0 ? mean(kWrongWeight) : kNaN);
    t.count("trials", "realisations", tally.trials);
    t.count("failed", "of them without a solution by some loss", tally.failed);
  }
  return t.take();
}

}  // namespace surveymc::studies::robustness_map
