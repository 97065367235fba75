/// Precompiled for the library, the studies and the command line: what nearly every file of them reads first.
/// Nothing of the project stands here, so that no edit of ours rebuilds all. Files include what they use all the same:
/// a build with -D CMAKE_DISABLE_PRECOMPILE_HEADERS=ON must pass (scripts/check_includes.sh, not in CI).
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <complex>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
