#include "sensor/gross_stations.h"

#include <numeric>

#include "random/choice.h"

namespace surveymc::sensor {
namespace {

constexpr double kDecay = 0.35;  // of a casing's field from a station to the next, by the distance to the casing's end

/// The stations in error of one trial, in the order of gross_decay().
std::vector<int> wrong_stations(const GrossStations& g, const random::Stream& stream, std::uint64_t trial,
                                int stations) {
  if (g.kind == GrossKind::scattered)
    return random::choose(stream, trial, random::Channel::gross_choice, 0, stations, g.count);
  std::vector<int> some(static_cast<std::size_t>(g.count));
  std::iota(some.begin(), some.end(),
            g.kind == GrossKind::casing
                ? 0
                : random::choose_one(stream, trial, random::Channel::gross_choice, 0, stations - g.count + 1));
  return some;
}

}  // namespace

const std::vector<std::string>& gross_kind_names() {
  static const std::vector<std::string> names{"scattered", "casing", "stretch"};
  return names;
}

double gross_decay(GrossKind kind, int k) {
  if (kind != GrossKind::casing) return 1;
  const double distance = 1 + kDecay * k;
  return 1 / (distance * distance);
}

std::vector<char> add_gross_errors(const GrossStations& g, const random::Stream& stream, std::uint64_t first_trial,
                                   const std::vector<double>& frames, survey::ReadingBlock& r) {
  const auto stations = static_cast<std::size_t>(r.stations);
  const int lanes = r.groups() * simd::kGroup;
  std::vector<char> wrong(static_cast<std::size_t>(lanes) * stations, 0);
  if (g.count == 0) return wrong;
  for (int t = 0; t < lanes; ++t) {
    const std::uint64_t trial = first_trial + static_cast<std::uint64_t>(t);
    const int group = t / simd::kGroup, lane = t % simd::kGroup;
    const std::vector<int> chosen = wrong_stations(g, stream, trial, r.stations);
    const auto error = [&](int station, int axis) {
      return g.size * stream.normal(trial, random::Channel::gross_size, static_cast<std::uint32_t>(4 * station + axis));
    };
    const std::array<double, 3> shared{error(0, 0), error(0, 1), error(0, 2)};
    for (int i = 0; i < g.count; ++i) {
      const int k = chosen[static_cast<std::size_t>(i)];
      wrong[static_cast<std::size_t>(t) * stations + static_cast<std::size_t>(k)] = 1;
      const double* frame = frames.data() + static_cast<std::size_t>(k) * 9;
      for (int axis = 0; axis < 3; ++axis) {
        const double along = g.kind == GrossKind::scattered
                                 ? error(k, axis)
                                 : frame[axis] * shared[0] + frame[3 + axis] * shared[1] + frame[6 + axis] * shared[2];
        r.magnetic.row(group, 3 * k + axis)[lane] += gross_decay(g.kind, i) * along;
      }
    }
  }
  return wrong;
}

}  // namespace surveymc::sensor
