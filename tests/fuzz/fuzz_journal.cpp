/// Checkpoint journals. The checksum would stop nearly all inputs, so they are also read as what it protects.
#include "base/bytes.h"
#include "checkpoint/journal.h"
#include "fuzz_input.h"
#include "montecarlo/ordered_merge.h"

using namespace surveymc;

namespace {

const checkpoint::RunKey kKey{"0123456789abcdef", "this build"};
constexpr std::string_view kMark = "SMCJRNL1";

std::string record_with(std::string_view node) {
  ByteWriter body;
  body.put(kKey.config_hash);
  body.put(kKey.program);
  body.put(std::uint64_t{3});
  body.put(node.data(), node.size());
  return checkpoint::sealed_record(kMark, body.take());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const MemoryFolder folder;
  static const std::filesystem::path output = folder / "out.h5", journal = folder / "out.h5.journal.host.1";
  const std::string_view bytes = text_of(data, size);
  const bool is_node = is_accepted([&] {
    promise(montecarlo::subtree_to_bytes(montecarlo::subtree_from_bytes(bytes)) == bytes,
            "a node that is read is written alike");
  });
  const auto is_readable = [&](const std::string& file) {
    write_bytes(journal, file);
    return is_accepted([&] { checkpoint::read_journals(output, kKey); });
  };
  const bool is_ours = is_readable(std::string(bytes));  // or a record, with its checksum, of another config
  is_readable(checkpoint::sealed_record(kMark, bytes));
  is_readable(record_with(bytes) + std::string(bytes));
  if (is_node && is_ours)
    promise(is_accepted([&] {
              const checkpoint::JournalContents all = checkpoint::read_journals(output, kKey);
              promise(all.finished.at(3).size() >= 1 && all.damaged.size() <= 1, "whole records before damage count");
              montecarlo::disjoint_subtrees(all.finished.at(3));
            }),
            "a journal is readable up to its damage");
  checkpoint::remove_journals(output, kKey);
  return 0;
}
