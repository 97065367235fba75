#pragma once
/// What the process needs before anything else is done in it.
#include <string>

namespace surveymc::cli {

/// Opens /dev/null in the place of standard input, output and error where they are closed: no file that the program
/// writes gets their number, so that no message goes into it. Call this before anything opens a file;
/// set_up_process() does.
void fill_standard_descriptors();

/// Standard descriptors, floating point, stacks and ignored signals. Returns what is wrong and how to mend it;
/// "" if all is well. Call it before threads are started.
std::string set_up_process();

/// Sees to it that the main thread and all that are started later have stacks of 1 MiB at least: raises the limit of
/// the process (`ulimit -s`) and the size of new threads where they are smaller. Returns what is wrong and how to mend
/// it if the system does not allow that, or "". set_up_process() calls it.
std::string provide_stacks();

}  // namespace surveymc::cli
