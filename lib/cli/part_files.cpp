#include "cli/part_files.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "base/error.h"
#include "cli/log.h"

namespace surveymc::cli {
namespace {

namespace fs = std::filesystem;

bool is_part(const fs::path& path) {
  try {
    checkpoint::read_part_head(path);
    return true;
  } catch (const IoError&) {
    return false;
  }
}

}  // namespace

std::vector<fs::path> files_with(const fs::path& folder, const std::string& word) {
  std::vector<fs::path> found;
  const auto add = [&](const fs::directory_entry& e) {
    const std::string name = e.path().filename().string();
    const bool hit = word == kPartExtension ? e.path().extension() == word : name.find(word) != std::string::npos;
    if (name[0] == '.') return;
    if (hit)
      found.push_back(e.path());
    else if (word == kPartExtension && is_part(e.path()))
      log_warning(fmt::format("{}: is a part whose name does not end in {}: not read; give it such a name",
                              e.path().string(), kPartExtension));
  };
  const auto check = [&](const fs::path& place, const std::error_code& e) {
    if (e && e != std::errc::no_such_file_or_directory)
      throw IoError(fmt::format("{}: cannot be listed: {}", place.string(), e.message()));
  };
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code gone;
    if (!it->is_directory(gone)) {
      add(*it);
      continue;
    }
    std::error_code inner;
    for (fs::directory_iterator in(it->path(), inner), last; !inner && in != last; in.increment(inner)) add(*in);
    check(it->path(), inner);
  }
  check(folder, error);
  std::sort(found.begin(), found.end());
  return found;
}

std::optional<ListedPart> listed(const fs::path& path) {
  try {
    ListedPart part{path, checkpoint::read_part_head(path), {}};
    if (!part.head.whole) part.pieces = checkpoint::PartReader(path).pieces();
    return part;
  } catch (const IoError& e) {
    log_warning(e.what());
    return std::nullopt;
  }
}

void add_to(study::Coverage& coverage, const ListedPart& part) {
  if (part.head.whole) coverage.add(part.head.range);
  for (const checkpoint::PieceEntry& e : part.pieces) coverage.add(e);
}

}  // namespace surveymc::cli
