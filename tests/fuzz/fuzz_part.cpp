/// Part files, as they are and behind a right checksum.
#include "checkpoint/part_file.h"
#include "fuzz_input.h"

using namespace surveymc;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const MemoryFolder folder;
  static const std::filesystem::path path = folder / "a.part";
  const std::string_view bytes = text_of(data, size);
  // As they are; and behind a right head, with the bytes as the config and its files, and as a piece.
  static const std::string good = [] {
    checkpoint::Part part;
    part.pieces.push_back({0, {0, 1}, 1, true});
    checkpoint::write_part(path, part);
    return checkpoint::read_bytes(path);
  }();
  write_bytes(path, std::string(bytes));
  is_accepted([&] { checkpoint::read_part(path); });
  checkpoint::part_state(path);
  checkpoint::Part part;
  part.config = bytes;
  part.pieces.push_back({0, {0, 1}, 1, true, {}, std::string(bytes)});
  std::filesystem::remove(path);  // what is no part file would not be replaced
  checkpoint::write_part(path, part);
  is_accepted([&] { checkpoint::read_part(path); });
  std::string cut = good.substr(0, good.size() - std::min(good.size(), size)) + std::string(bytes);
  write_bytes(path, cut);
  is_accepted([&] { checkpoint::read_part(path); });
  return 0;
}
