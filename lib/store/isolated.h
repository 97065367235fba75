#pragma once
#include <cstdint>
#include <functional>
#include <string>

namespace surveymc::store {

/// Runs `work`, which reads a file of so many bytes, in a child process with limited memory and time, to see whether
/// this process may do the same. What ended the child, "is damaged, or made to do harm: ..."; "" if all went well or
/// `work` threw anything but std::bad_alloc: it will do that here, too. Throws std::system_error if the system gives no
/// child.
std::string harm_in_child(std::uintmax_t file_size, const std::function<void()>& work);

}  // namespace surveymc::store
