#pragma once
#include <string>

#include "base/error.h"

namespace surveymc {

/// What the Error of `call` says; empty if there is none.
template <class Error = InputError, class Call>
std::string message_of(const Call& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

}  // namespace surveymc
