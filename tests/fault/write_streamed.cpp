/// Writes a small result with streamed maps, whose values are computed while they are written: write_streamed FILE
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "store/result_file.h"

using namespace surveymc;

int main(int argc, char** argv) {
  if (argc != 2) return 64;
  store::Result r{.provenance = {.title = "streamed maps", .experiment = "none"}};
  std::vector<double> across(1000), along(300);
  for (std::size_t i = 0; i < across.size(); ++i) across[i] = static_cast<double>(i);
  for (std::size_t i = 0; i < along.size(); ++i) along[i] = static_cast<double>(i) / 2;
  const std::vector<store::Axis> axes{{"across", "m", "across", across}, {"along", "m", "along", along}};
  const auto values = [](std::size_t first, std::size_t count) {
    std::vector<std::vector<double>> piece(2, std::vector<double>(count));
    for (std::size_t i = 0; i < count; ++i) {
      piece[0][i] = std::sqrt(static_cast<double>(first + i));
      piece[1][i] = 1 / (1 + static_cast<double>(first + i));
    }
    return piece;
  };
  r.streams.push_back({{{"root", "1", "root", axes, {}}, {"inverse", "1", "inverse", axes, {}}}, values});
  try {
    store::check_output_path(argv[1]);  // as `run` does: it removes what a crash has left
    store::write_result(argv[1], r);
  } catch (const IoError& e) {
    std::fprintf(stderr, "error: %s\n", e.what());
    return 74;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "error: not enough memory\n");
    return 70;
  }
  return 0;
}
