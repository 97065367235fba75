#pragma once
#include <string_view>

namespace surveymc::earth {

/// The text of lib/earth/wmm2025.cof as it was when the program was built.
std::string_view shipped_wmm2025();

}  // namespace surveymc::earth
