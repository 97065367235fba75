#pragma once
/// The table `warnings` of a result: what to know of the input, and of the numbers, before they are used.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "store/table.h"

namespace surveymc::compare {

inline constexpr const char* kWarningsTable = "warnings";

struct Warning {
  std::string severity;      ///< "severe": do not use the numbers as they are; "warning"; "info"
  std::string place;         ///< key of the config, line of a file, error model, or depth
  std::string value = {};    ///< what stands there
  std::string message;       ///< what is unusual
  std::string way_out = {};  ///< what to do if it is not meant
  std::uint64_t points = 1;  ///< of the sweep, that it is about
  std::string at = {};       ///< the first of them, by the keys of the sweep
};

/// "severity: place = value: message; way out (points)".
std::string in_words(const Warning& warning);

/// The table of one point, and that of a result.
store::Table warnings_table(const std::vector<Warning>& warnings);

/// The rows of a table that warnings_table() has made. What a result of another program lacks is empty.
std::vector<Warning> warnings_of(const store::Table& table);

/// Warnings of many points: those that say the same are one, with the number of its points and the first of them.
class WarningList {
 public:
  void add(Warning warning);
  /// The same of one point, which may say the same twice. Points come in order.
  void add(Warning warning, std::uint64_t point);
  /// In order of add(). Of more than kMost, the last row says how many are left out.
  store::Table table() const;

  static constexpr std::size_t kMost = 10'000;

 private:
  std::vector<Warning> list_;
  struct Known {
    std::size_t row = 0;
    std::uint64_t point = 0;  // the last that has said so
  };
  std::map<std::string, Known> known_;  // by what it says
  std::uint64_t left_out_ = 0;
};

}  // namespace surveymc::compare
