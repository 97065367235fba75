#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::position_covariance {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows stations = Rows(result.tables, "covariance").with("semi_major_m");
  if (stations.empty()) {
    answer.say("No station has a covariance: the error models do not hold there.");
    return;
  }
  constexpr double kSigmas = 2;
  const bool is_one_well = stations.point().text.empty();
  const Rows at = is_one_well ? stations.last() : stations.at_largest("semi_major_m");
  // In a vertical hole the azimuth, and with it the high side, means nothing.
  constexpr double kVertical = 5;  // deg
  const double md = at.number("md_m");
  const Rows there = Rows(result.tables, "ellipsoid").between("md_m", md, md);
  if (is_one_well && there.number("inclination_deg") < kVertical) {
    answer.say(
        "At {} the position is known to {} by {} sideways, the long axis towards {}, and {} in depth, at two sigma.",
        {at.figure("md_m"), at.figure("semi_major_m").times(kSigmas), at.figure("semi_minor_m").times(kSigmas),
         at.figure("major_azimuth_deg"), at.figure("sd_vertical_m").times(kSigmas)});
  } else {
    answer.say(
        "At {}{}{} the position is known to {} across the hole, {} along its high side and {} along it, at two "
        "sigma.",
        {at.figure("md_m"), at.point(), is_one_well ? "" : ", the least known station of all,",
         at.figure("sd_lateral_m").times(kSigmas), at.figure("sd_high_side_m").times(kSigmas),
         at.figure("sd_along_hole_m").times(kSigmas)});
    answer.say("The horizontal ellipse there has half axes of {} and {} at two sigma; the long one points to {}.",
               {at.figure("semi_major_m").times(kSigmas), at.figure("semi_minor_m").times(kSigmas),
                at.figure("major_azimuth_deg")});
  }
  answer.say_verdicts(Rows(result.tables, "published"), "published elements of covariances", "What was published");
}

}  // namespace surveymc::studies::position_covariance
