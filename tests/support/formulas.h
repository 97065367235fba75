#pragma once
/// Weighting functions from their formulas.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "error_model/model.h"

namespace surveymc::test {

/// A function called F with these formulas, by the members of Function that they are.
inline std::shared_ptr<error_model::Function> function_of(
    const std::vector<std::pair<error_model::Expression error_model::Function::*, std::string>>& formulas,
    error_model::Kind kind = error_model::Kind::station) {
  auto f = std::make_shared<error_model::Function>();
  f->name = "F";
  f->kind = kind;
  for (const auto& [member, text] : formulas) (*f).*member = error_model::parse_expression(text);
  return f;
}

}  // namespace surveymc::test
