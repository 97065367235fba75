#pragma once
#include <cstdint>
#include <functional>
#include <string>

namespace surveymc::store {

/// Runs `work`, which reads a file of so many bytes, in a child process with limited memory and time. Why it could not
/// be done: the text of its exception, or what ended the child; "" if all went well. Throws std::system_error if the
/// system gives no child.
std::string fault_in_child(std::uintmax_t file_size, const std::function<void()>& work);

}  // namespace surveymc::store
