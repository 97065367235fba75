#pragma once
/// Laws of the errors of a reference field, and who shares a V (mixing_law.h).
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "random/mixing_draws.h"

namespace surveymc::random {

/// What is drawn of the reference field.
enum class ReferenceElement : std::uint32_t { declination = 0, dip = 1, total = 2 };
/// In the order of ReferenceElement.
inline const std::vector<std::string>& reference_elements() {
  static const std::vector<std::string> names{"declination", "dip", "total"};
  return names;
}

struct ReferenceLaws {
  struct Element {
    std::shared_ptr<const MixingLaw> law;  ///< null: normal
    double sd = 1;                         ///< of an error whose tabulated size is 1
    std::string size = "sd";               ///< what the tabulated size is: of size_names()
  };
  std::array<Element, 3> elements;                 ///< in the order of ReferenceElement
  bool global = true, well = true, random = true;  ///< the modes of errors that have the laws: G, W, R
  bool shared_mixing = false;                      ///< all elements have one V, and one law
  bool each_term = false;                          ///< every draw has a V of its own; else those of an element share it

  const Element& of(ReferenceElement e) const { return elements[static_cast<std::size_t>(e)]; }
  /// Some element has a law.
  bool any() const {
    return std::any_of(elements.begin(), elements.end(), [](const Element& e) { return e.law != nullptr; });
  }
  /// Index of the V of an element among those of one time: 3 where all share it.
  std::uint32_t slot(ReferenceElement e) const { return shared_mixing ? 3 : static_cast<std::uint32_t>(e); }
};

}  // namespace surveymc::random
