#pragma once
/// What a file on the command line is, for those who give a command a file of another kind.
#include <string>

namespace surveymc::cli {

enum class FileKind { unknown, config, error_models, result, part, journal, survey, readings, gauges };

/// By its first bytes and its name; unknown, too, where there is no such file or it is a folder, a pipe or a device.
FileKind kind_of_file(const std::string& path);

/// The experiment that a config names; "" if the file is none.
std::string experiment_of_config(const std::string& path);

/// "a result; commands for it:" and a line for each command that takes such a file; "" if nobody knows it.
std::string what_to_do(const std::string& path, FileKind kind);

/// Throws UsageError with what_to_do() if the file is known to be of another kind than the command wants; InputError or
/// IoError if it is empty.
/// `command`: with the command's name, for the message.
void refuse_other_kind(const std::string& command, const std::string& path, FileKind wanted);

}  // namespace surveymc::cli
