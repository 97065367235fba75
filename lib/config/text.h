#pragma once
/// Small helpers for text that users write or read. Internal to the module.
#include <string>
#include <string_view>

namespace surveymc::config {

/// Without blanks and tabs at both ends.
std::string_view trimmed(std::string_view s);

/// For messages: not longer than a terminal line, cut between characters.
std::string shortened(std::string_view s);

/// As a TOML string.
std::string in_quotes(std::string_view s);

}  // namespace surveymc::config
