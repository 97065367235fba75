#pragma once
/// Exit codes of the program, and the exceptions that stand for them.
#include <utility>

#include <fmt/format.h>

#include "base/error.h"

namespace surveymc::cli {

// sysexits.h, as documented in docs/results-format.md
enum Exit {
  kDone = 0,
  kUnexpected = 1,
  kUsage = 64,
  kBadInput = 65,
  kInternal = 70,
  kNoMachine = 71,
  kCannotWrite = 74,
  kInterrupted = 75
};

/// What the program says, without asking for memory, before it ends with kInternal.
inline constexpr const char* kOutOfMemory = "error: out of memory\n";

/// The command line is wrong, though each of its words may be right. what() says option, value, rule. Exit code 64.
class UsageError : public InputError {
 public:
  using InputError::InputError;
};

/// Throws UsageError unless `ok`.
template <class... Args>
void require_usage(bool ok, fmt::format_string<Args...> format, Args&&... args) {
  if (!ok) throw UsageError(fmt::format(format, std::forward<Args>(args)...));
}

/// The run was interrupted and its finished work was kept: what() says how to go on.
class Resumable : public Interrupted {
 public:
  using Interrupted::Interrupted;
};

}  // namespace surveymc::cli
