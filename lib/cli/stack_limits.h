#pragma once
#include <string>

namespace surveymc::cli {

/// Sees to it that the main thread and all that are started later have stacks of 1 MiB at least: raises the limit of
/// the process (`ulimit -s`) and the size of new threads where they are smaller. What is wrong and the way out, if the
/// system does not allow that; "" if all is well. Call it before threads are started.
std::string provide_stacks();

}  // namespace surveymc::cli
