/// Every byte of a result flipped, and the file cut there: read_damaged FILE WORK_FILE
/// Each damaged file is written to WORK_FILE and read. It must be refused by its name, or have the contents of FILE.
/// Prints a line for every finding, and at the end how many damages there were. A crash is one of the reader.
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

#include <fmt/format.h>

#include "base/error.h"
#include "store/result_file.h"

using namespace surveymc;

namespace {

/// What is wrong with how the damaged file is read; "" if nothing is.
std::string finding(const std::string& path, const std::string& contents) {
  try {
    return store::content_hash(store::read_result(path)) == contents ? "" : "other contents, and no word";
  } catch (const IoError& e) {
    return std::string(e.what()).find(path) != std::string::npos ? "" : fmt::format("without its name: {}", e.what());
  } catch (const std::exception& e) {
    return fmt::format("another error: {}", e.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 64;
  const std::string work = argv[2];
  std::ifstream in(argv[1], std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  const std::string contents = store::content_hash(store::read_result(argv[1]));
  int found = 0;
  const auto check = [&](const std::string& bytes, const char* what, std::size_t at) {
    std::ofstream(work, std::ios::binary | std::ios::trunc) << bytes;
    const std::string fault = finding(work, contents);
    if (fault.empty()) return;
    ++found;
    fmt::print("{} at {}: {}\n", what, at, fault);
  };
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ 1 << at % 8);
    check(flipped, "flipped", at);
    check(whole.substr(0, at), "cut", at);
  }
  fmt::print("{} damages, {} with a finding\n", 2 * whole.size(), found);
  return found == 0 && !whole.empty() ? 0 : 1;
}
