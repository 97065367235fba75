/// Part files, as they are and behind a right checksum.
#include "checkpoint/part_file.h"
#include "fuzz_input.h"

using namespace surveymc;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const MemoryFolder folder;
  static const std::filesystem::path path = folder / "a.part";
  const std::string_view bytes = text_of(data, size);
  for (const std::string& file : {std::string(bytes), checkpoint::sealed_record("SMCPART1", bytes)}) {
    write_bytes(path, file);
    is_accepted([&] { checkpoint::read_part(path); });
    checkpoint::part_state(path);
  }
  return 0;
}
