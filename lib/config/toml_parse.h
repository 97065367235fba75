#pragma once
/// TOML text -> TomlNode, strictly: NaN and infinity are errors wherever they stand. Internal to the module.
#include <string>

#include "config/toml_tree.h"

namespace surveymc::config {

/// Throws InputError "label:line: rule".
TomlNode parse_document(const std::string& text, const std::string& label);

/// The value of a --set argument: TOML, or else a bare word. Throws InputError "place: key: rule".
TomlNode parse_value(const std::string& value, const std::string& key, const std::string& place);

}  // namespace surveymc::config
