#pragma once
/// Output of a result to the terminal.
#include <string>

#include "store/result_file.h"
#include "store/table.h"

namespace surveymc::cli {

/// Prints a line, folded at the width of the terminal if there is one.
void say(const std::string& line);

/// Prints tables that are short enough to read; for the others, names the command that prints them. `feet`: lengths in
/// feet.
void print_tables(const store::Result& result, const std::string& path, bool feet);

/// The table `warnings`, if a study has one, as the last thing a user reads. `quiet`: on stderr, and without those that
/// only inform.
void print_warnings(const store::Result& result, bool quiet);

/// Prints how many verdicts there are of each kind; exit code of the run.
int report_verdicts(const store::Result& result, bool check);

/// For readers of wells that are measured in feet; files always hold metres.
/// The table with lengths in feet and areas in square feet (exactly 0.3048 m): columns with unit m or m2, whose names
/// then end in _ft and _ft2; and in rows whose column `unit` says m or m2, the values "in the row's unit" with their
/// intervals.
store::Table in_feet(store::Table table);

}  // namespace surveymc::cli
