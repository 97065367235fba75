#pragma once
#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace surveymc {

/// The user's input (config, file, argument) is wrong. what() says place, value, rule. Exit code 65.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file cannot be written or read back. what() says which file and why. Exit code 74.
class IoError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The run was asked to stop (signal) before it was done. Exit code 75.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws InputError unless `ok`. Write the message as: place, value, rule.
template <class... Args>
void require(bool ok, fmt::format_string<Args...> format, Args&&... args) {
  if (!ok) throw InputError(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace surveymc
