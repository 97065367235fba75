#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "checkpoint/record.h"

namespace surveymc::checkpoint {

/// What a user should know of the journals beside `output` that read_journals() takes: which are of another build, and
/// which files have the name of a journal and are none. Throws IoError.
struct JournalRemarks {
  std::vector<std::string> notes, warnings;
};
JournalRemarks journal_remarks(const std::filesystem::path& output, const RunKey& key);

}  // namespace surveymc::checkpoint
