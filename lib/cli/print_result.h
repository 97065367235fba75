#pragma once
/// Output of a result to the terminal.
#include <string>
#include <vector>

#include "cli/run_arguments.h"
#include "store/result_file.h"
#include "store/table.h"

namespace surveymc::cli {

/// Prints a line, folded at the width of the terminal if there is one.
void say(const std::string& line);

/// Prints the table `answer`, how many verdicts there are of each kind, and warnings; with --verbose the tables, too;
/// with
/// --json all but the tables as one object, and nothing else. The exit code of the verdicts.
int print_findings(const RunArguments& a, const store::Result& result, const std::string& path);

/// The sentences of the table `answer`. `feet`: lengths in feet.
std::vector<std::string> answer_of(const store::Result& result, bool feet = false);

/// What a result is and what it has found, as members of a JSON object, without braces.
std::string summary_json(const store::Result& result, const std::string& path);

/// For readers of wells that are measured in feet; files always hold metres.
/// The table with lengths in feet and areas in square feet (exactly 0.3048 m): columns with unit m or m2, whose names
/// then end in _ft and _ft2; and in rows whose column `unit` says m or m2, the values "in the row's unit" with their
/// intervals.
store::Table in_feet(store::Table table);
/// A sentence of an answer with lengths in feet, by its column `sources`.
std::string in_feet(std::string sentence, const std::string& sources, const std::vector<store::Table>& tables);

}  // namespace surveymc::cli
