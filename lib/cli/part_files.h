#pragma once
/// Part files of a folder.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "checkpoint/part_file.h"
#include "study/parts.h"

namespace surveymc::cli {

inline constexpr const char* kPartExtension = ".part";

/// Files of a folder and of the folders in it (sweep.sh has at most 1,000 parts in each) whose names have `word`, which
/// for parts is their ending; sorted. Throws IoError.
std::vector<std::filesystem::path> files_with(const std::filesystem::path& folder, const std::string& word);

/// A part as its head has it; its pieces where the head does not say what they are.
struct ListedPart {
  std::filesystem::path path;
  checkpoint::PartHead head;
  std::vector<checkpoint::PieceEntry> pieces = {};
};

/// Nothing, and a warning in the log, if the file is damaged.
std::optional<ListedPart> listed(const std::filesystem::path& path);

void add_to(study::Coverage& coverage, const ListedPart& part);

}  // namespace surveymc::cli
