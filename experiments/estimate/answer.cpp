#include <cmath>

#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::estimate {

using compare::Rows;

namespace {

/// A reading is blamed only where the others fit without its station.
void say_suspect(compare::Answer& answer, const store::Result& result) {
  const Rows suspect = Rows(result.tables, "suspect_readings").where("judgement", "most likely").first();
  if (suspect.empty()) return;
  const Rows without = Rows(result.tables, "without_suspect").first();
  const Rows test = Rows(result.tables, "tests").where("test", "variance_factor").last();
  const double s0 = without.number("s0");
  if (s0 * s0 <= test.number("critical_high"))
    answer.say("The reading {} at {}{} is most likely wrong, by {}.",
               {suspect.word("reading"), suspect.figure("md_m"), suspect.point(), suspect.figure("error")});
  else
    answer.say("Readings and reference do not fit together{}, and no single reading explains it.", {suspect.point()});
}

/// Where the covariance is not to be believed.
void say_profile(compare::Answer& answer, const store::Result& result) {
  const Rows profile(result.tables, "intervals");
  if (profile.empty()) return;
  const Rows differs = profile.where("covariance", "differs"), worst = profile.at_largest("shift");
  if (worst.empty()) return;
  if (differs.empty()) {
    answer.say("The covariance holds: by the profile no end of an interval moves by more than {} of its half width{}.",
               {worst.figure("shift"), worst.point()});
    return;
  }
  answer.say(
      "The covariance does not hold for {} of {} intervals: that of {} is {} to {} by the profile, {} to {} by the "
      "covariance{}.",
      {differs.count(), profile.count(), worst.word("quantity"), worst.figure("profile_low"),
       worst.figure("profile_high"), worst.figure("first_low"), worst.figure("first_high"), worst.point()});
}

/// Of the estimator "multistation": what the run justifies, and whether that predicts what the fit has not seen.
void say_sets(compare::Answer& answer, const store::Result& result) {
  const Rows sets(result.tables, "sets"), justified = sets.where("judgement", "justified").first();
  if (justified.empty()) return;
  answer.say("The run justifies the set of parameters \"{}\"{}.", {justified.word("set"), justified.point()});
  const Rows taken = sets.where("taken", "yes").first();
  answer.say(
      "Of stations that the fit has not seen, set \"{}\" by {} takes the spread of the total field from {} to {}, and "
      "that of the dip from {} to {}.",
      {taken.word("set"), taken.word("loss"), taken.figure("raw_sd_total_field_nT"), taken.figure("sd_total_field_nT"),
       taken.figure("raw_sd_dip_deg"), taken.figure("sd_dip_deg")});
  if (const Rows turned = taken.with("axis_rms_deg"); !turned.empty())
    answer.say("The axis that the instrument was turned about scatters by {} instead of {}.",
               {turned.figure("axis_rms_deg"), turned.figure("raw_axis_rms_deg")});
}

}  // namespace

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows stations = Rows(result.tables, "stations").with("sd_azimuth_deg");
  const Rows last = stations.last();
  const Rows corrected = stations.at_largest("azimuth_change_deg", [](double x) { return std::abs(x); });
  if (!last.empty())
    answer.say("At {}{} the azimuth is {} from magnetic north and {} from true north, with an sd of {}.",
               {last.figure("md_m"), last.point(), last.figure("azimuth_magnetic_deg").with_decimals(2),
                last.figure("azimuth_true_deg").with_decimals(2), last.figure("sd_azimuth_deg")});
  const Rows parameters = Rows(result.tables, "parameters").at_point_of(Rows(result.tables, "parameters").last());
  const Rows x = parameters.where("quantity", "bias_x_nT"), y = parameters.where("quantity", "bias_y_nT"),
             z = parameters.where("quantity", "bias_z_nT");
  const auto bias = [](const Rows& of) {
    return compare::Phrase("{} (sd {})", {of.figure("estimate").with_unit("nT"), of.figure("sd").with_unit("")});
  };
  if (!x.empty() && !y.empty() && !z.empty())
    answer.say("The magnetometer biases{} are {} in x, {} in y and {} in z.", {x.point(), bias(x), bias(y), bias(z)});
  const double sign = corrected.number("azimuth_change_deg") < 0 ? -1 : 1;
  if (!corrected.empty())
    answer.say("The correction turns the azimuth by at most {}, at {}{}.",
               {corrected.figure("azimuth_change_deg").times(sign), corrected.figure("md_m"), corrected.point()});
  const Rows tests = Rows(result.tables, "tests").without("test", "perfect_tool");
  if (!tests.empty())
    answer.say("{} of {} tests of the readings reject.", {tests.where("decision", "rejected").count(), tests.count()});
  say_profile(answer, result);
  say_sets(answer, result);
  say_suspect(answer, result);
}

}  // namespace surveymc::studies::estimate
