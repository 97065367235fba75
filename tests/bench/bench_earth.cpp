/// Reference fields of places.
#include "bench_setup.h"
#include "earth/geodesy.h"
#include "earth/geomagnetic_model.h"

namespace surveymc::bench {
namespace {

/// Items: places all over the globe, each with its field, secular variation, elements and gravity.
void reference_field_of_place(benchmark::State& state) {
  constexpr int kPlaces = 1000;
  std::vector<earth::Place> places;
  for (int k = 0; k < kPlaces; ++k)  // golden angle: even over the sphere
    places.push_back({std::asin(2 * (k + 0.5) / kPlaces - 1), std::fmod(2.399963 * k, 2 * kPi) - kPi, 10.0 * k});
  time_calls(state, kPlaces, [&] {
    for (const earth::Place& p : places) {
      const earth::MagneticField field = earth::wmm2025().field(p, 2026.5);
      benchmark::DoNotOptimize(earth::magnetic_elements(field.vector));
      benchmark::DoNotOptimize(earth::elements_per_year(field.vector, field.per_year));
      benchmark::DoNotOptimize(earth::normal_gravity(p));
    }
  });
}
BENCHMARK(reference_field_of_place)->Name("reference_field");

}  // namespace
}  // namespace surveymc::bench
