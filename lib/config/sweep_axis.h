#pragma once
/// The values of one key of [sweep], as a function of their number. Internal to the module.
#include <cstdint>
#include <string>
#include <vector>

#include "config/config_value.h"
#include "config/toml_tree.h"

namespace surveymc::config {

/// More points than this, or values of a key, are a typing error.
inline constexpr double kMostPoints = 0x1p40;

class SweepAxis {
 public:
  SweepAxis() = default;
  /// `list`: a list, { from, to, step }, { from, to, count, scale } or { from, to, scale }. `shown`: the key in
  /// messages. `may_repeat`: a list may have a value twice. Throws InputError.
  SweepAxis(const TomlNode& list, const std::string& shown, bool may_repeat);

  /// { from, to } without step or count: every number between them, of which a random design draws.
  bool is_interval() const { return form_ == Form::interval; }
  /// Number of values; 2 of an interval: its ends.
  std::uint64_t size() const;
  TomlNode value(std::uint64_t i) const;
  /// The value at `u` in (0, 1): of an interval the quantile of the uniform (on the scale), else the value whose equal
  /// share of (0, 1) holds `u`.
  TomlNode at(double u) const;

 private:
  enum class Form { list, steps, count, interval };
  void read_range(const TomlNode& range, const std::string& shown);
  double fraction(double share) const;
  TomlNode node(double x) const;

  Form form_ = Form::list;
  std::vector<TomlNode> items_;
  Steps steps_;
  bool is_log_ = false, are_integers_ = false;
  std::string place_;
  int line_ = 0;
};

}  // namespace surveymc::config
