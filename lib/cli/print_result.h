#pragma once
/// What a reader sees of a result on the terminal.
#include <string>

#include "store/result_file.h"

namespace surveymc::cli {

/// Tables short and narrow enough to read are printed; the others are a command away.
void print_tables(const store::Result& result, const std::string& path);

/// The table `warnings`, if a study has one, as the last thing a user reads.
void print_warnings(const store::Result& result);

/// Prints how many verdicts there are of each kind; exit code of the run.
int report_verdicts(const store::Result& result, bool check);

}  // namespace surveymc::cli
