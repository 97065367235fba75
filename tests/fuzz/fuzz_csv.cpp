/// Tables of users: surveys, six-axis readings, and time series of sensors, each by its own reader.
#include <cmath>
#include <memory>

#include "config/input_table.h"
#include "config/readings_csv.h"
#include "config/sensor_csv.h"
#include "config/survey_csv.h"
#include "fuzz_input.h"

using namespace surveymc;

namespace {

bool rises(const std::vector<double>& x) {
  for (std::size_t i = 1; i < x.size(); ++i)
    if (!(x[i - 1] < x[i])) return false;
  return true;
}

void read_table(const std::string& text) {
  const config::InputTable table = config::parse_csv(text, "fuzz.csv");
  promise(table.names.size() == table.columns.size(), "every column has a name");
  for (const std::vector<double>& column : table.columns) {
    promise(column.size() == table.rows(), "every row is as long as the header");
    for (const double x : column) promise(std::isfinite(x), "every cell is finite");
  }
  for (const auto north :
       {config::AzimuthReference::true_north, config::AzimuthReference::magnetic, config::AzimuthReference::grid})
    is_accepted([&] { config::survey_from_table(table, {config::ToolfaceZero::x, north, 0.1, -0.1}, false); });
  is_accepted([&] { config::tvd_from_table(table); });
  for (const auto sign : {config::AccelerometerSign::gravity, config::AccelerometerSign::specific_force})
    is_accepted([&] {
      const survey::SixAxisReadings readings = config::readings_from_table(table, {sign, 9.8, 50000});
      promise(rises(readings.md) && readings.md.size() == table.rows(), "measured depths of readings increase");
    });
}

void read_sensors(const std::string& text, const char* time) {
  config::SensorCsvReader reader({"fuzz.csv", std::make_shared<const std::string>(text), {}, text.size()},
                                 {time, {"p_kPa", "t_degC"}, true, 1.5});
  double latest = -INFINITY;
  std::uint64_t rows = 0;
  for (config::SensorBlock block; reader.next(block, 7); rows += block.time_h.size()) {
    promise(block.values.size() == 2 * block.time_h.size(), "good rows are complete");
    for (const double t : block.time_h) {
      promise(latest < t, "good rows are in order");
      latest = t;
    }
    for (const double x : block.values) promise(std::isfinite(x), "sensors of good rows are finite");
  }
  promise(reader.found().good_rows == rows, "good rows are counted");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(text_of(data, size));
  is_accepted([&] { read_table(text); });
  for (const char* time : {"timestamp", "time_s"}) is_accepted([&] { read_sensors(text, time); });
  return 0;
}
