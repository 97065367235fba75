#include "scenario/drawn_reference.h"

#include <array>

#include <fmt/format.h>

#include "scenario/reference_laws.h"

namespace surveymc::scenario {
namespace {

/// The errors of the reference that are new at every station become a function of time.
void read_disturbed(config::ConfigReader& c, const survey::Survey& survey, const DisturbedWell& well,
                    const survey::ReferenceField& field, DrawnReference& r, sensor::NoiseModel& noise) {
  r.disturbance = read_disturbance(c, survey, well);
  if (!r.disturbance) return;
  const disturbance::Disturbance& d = *r.disturbance;
  c.require(noise.reference == sensor::ReferenceNoise::per_station, "disturbance.kind",
            "takes the place of the reference's errors at every station: noise.reference.per must be \"station\"");
  c.require(!r.laws.any(), "disturbance.kind",
            "takes the place of noise.reference, of which the laws of reference_law are: give one of the two. "
            "error_model_monte_carlo and corrected_codes have both, laws of what lasts (modes \"G\", \"W\") beside a "
            "disturbance of what is new at every station");
  constexpr std::array<disturbance::Element, 2> kElements{disturbance::kTotal, disturbance::kDip};
  std::vector<disturbance::StationDraw> draws;
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(survey.size()); ++k)
    for (std::uint32_t i = 0; i < kElements.size(); ++i)
      draws.push_back({k, kElements[i], i, random::Channel::reference_field, 2 * k + i});
  r.disturbed = std::make_shared<const disturbance::StationDisturbance>(d, field, draws);
  const std::array<double*, 2> sizes{&noise.reference_total, &noise.reference_dip};
  c.require(!d.match_variance || *sizes[0] > 0 || *sizes[1] > 0, "disturbance.match",
            "\"variance\" is that of noise.reference, whose errors are 0: give noise.reference.total_nT or dip_deg");
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double own = r.disturbed->sizes()[kElements[i]];
    if (!d.match_variance) *sizes[i] = own;
    c.require(d.keeps_normals() || *sizes[i] == 0 || own > 0, "disturbance.match",
              fmt::format("the disturbance does not change the {}, which noise.reference has",
                          random::reference_elements()[kElements[i]]));
    *sizes[i] *= d.scale;
  }
}

}  // namespace

survey::LaneArray DrawnReference::made(const random::Stream& stream, std::uint64_t first_trial, bool antithetic,
                                       int groups) const {
  if (!disturbed) return {};
  survey::LaneArray rows(groups, static_cast<int>(disturbed->draws().size()));
  disturbed->fill(stream, first_trial, antithetic, groups, rows);
  return rows;
}

random::ReferenceLaws read_drawn_laws(config::ConfigReader& c, sensor::NoiseModel& noise) {
  const random::ReferenceLaws laws = read_reference_laws(c, {.declination = false, .modes = false, .terms = false});
  c.require(!laws.any() || noise.reference != sensor::ReferenceNoise::none, "reference_law",
            "is of a reference that is drawn: give noise.reference.per");
  noise.reference_total *= laws.of(random::ReferenceElement::total).sd;
  noise.reference_dip *= laws.of(random::ReferenceElement::dip).sd;
  return laws;
}

DrawnReference read_drawn_reference(config::ConfigReader& c, const survey::Survey& survey, const DisturbedWell& well,
                                    const survey::ReferenceField& field, sensor::NoiseModel& noise) {
  DrawnReference r;
  r.laws = read_drawn_laws(c, noise);
  read_disturbed(c, survey, well, field, r, noise);
  return r;
}

std::vector<compare::LawDraw> law_draws(const sensor::ReferenceMixing& mixing) {
  std::vector<compare::LawDraw> out;
  for (const std::uint32_t which : {1u, 0u})  // index of Channel::reference_field: total field 0, dip 1
    if (!mixing.slot_of.empty() && mixing.slot_of[which] >= 0)
      out.push_back({which == 1 ? random::ReferenceElement::dip : random::ReferenceElement::total,
                     mixing.slots[static_cast<std::size_t>(mixing.slot_of[which])], random::Channel::reference_field,
                     which});
  return out;
}

void require_tables_of(config::ConfigReader& c, const DrawnReference& r, compare::TailRule& tails,
                       const PredictionOrders& orders, const compare::CalibrationRule& calibration) {
  require_orders_of(c, r.laws, r.disturbance.has_value(), orders);
  set_beside_laws(c, r.disturbance, r.laws, tails);
  c.require(!r.laws.any() || !calibration.on, "calibration",
            "is of a claimed normal distribution: not together with reference_law, whose table `tails` says how often "
            "errors are beyond so many sd");
}

}  // namespace surveymc::scenario
