#include "cli/write_output.h"

#include <fmt/format.h>

#include "cli/print_result.h"

namespace surveymc::cli {

std::vector<std::filesystem::path> write_result_file(const RunArguments& a, const std::filesystem::path& path,
                                                     const store::Result& result) {
  Progress progress(0, "MB");
  store::WriteOptions options{a.compression, {}, old_file(a)};
  if (!a.quiet)
    options.progress = [&](std::uint64_t written, std::uint64_t expected) {
      constexpr std::uint64_t kMegabyte = 1'000'000;
      progress.update(written / kMegabyte, expected / kMegabyte);
    };
  return store::write_result(path, result, options);
}

void print_backup(const std::vector<std::filesystem::path>& kept) {
  for (const std::filesystem::path& name : kept) say(fmt::format("the file that was there is now {}", name.string()));
}

}  // namespace surveymc::cli
