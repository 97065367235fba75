#pragma once
/// What stands where a new file goes is kept under another name.
#include <filesystem>
#include <functional>

namespace surveymc::store {

/// Calls write(), which puts a new file in the place of the one at `path` (whole, by a rename). If there is a file and
/// not `overwrite`, it is kept: under NAME.1.EXT, or the next number that is free; of a part file NAME.part.1, which no
/// merge takes for a part. It gets that name before it loses its own, so a kill at any moment leaves it one. If write()
/// throws, all is as it was. Returns the new name of the old file, or nothing. Throws IoError.
std::filesystem::path write_beside_old(const std::filesystem::path& path, bool overwrite,
                                       const std::function<void()>& write);

}  // namespace surveymc::store
