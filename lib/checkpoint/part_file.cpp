#include "checkpoint/part_file.h"

#include <system_error>

#include <fmt/format.h>

#include "base/bytes.h"
#include "base/error.h"
#include "store/atomic_file.h"

namespace surveymc::checkpoint {
namespace {

namespace fs = std::filesystem;

// The last character is the version of the format.
constexpr std::string_view kPartMark = "SMCPART2", kAnyPartMark = "SMCPART";

std::string encode(const Part& p) {
  ByteWriter out;
  for (const std::string* text : {&p.key.config_hash, &p.key.program, &p.title, &p.experiment, &p.config, &p.command,
                                  &p.run.created, &p.run.host})
    out.put(*text);
  out.put(p.run.elapsed_s);
  out.put(p.run.threads);
  out.put(p.run.ranks);
  out.put(std::uint64_t{p.inputs.size()});
  for (const config::InputTable& t : p.inputs) {
    out.put(t.path);
    out.put(std::uint64_t{t.names.size()});
    for (std::size_t c = 0; c < t.names.size(); ++c) {
      out.put(t.names[c]);
      out.put(t.columns[c]);
    }
    out.put(t.lines);
  }
  out.put(std::uint64_t{p.texts.size()});
  for (const config::InputText& t : p.texts) {
    out.put(t.path);
    out.put(t.text);
  }
  out.put(std::uint64_t{p.references.size()});
  for (const config::InputReference& r : p.references) {
    out.put(r.path);
    out.put(r.size);
    out.put(r.hash);
    out.put(r.header);
  }
  out.put(p.folder);
  out.put(p.points);
  out.put(std::uint64_t{p.pieces.size()});
  for (const PartPiece& piece : p.pieces) {
    for (const std::uint64_t n : {piece.point, piece.blocks.first, piece.blocks.end, piece.blocks_in_all}) out.put(n);
    out.put(piece.whole);
    out.put(std::uint64_t{piece.subtrees.size()});
    for (const montecarlo::Subtree& s : piece.subtrees) out.put(montecarlo::subtree_to_bytes(s));
    out.put(piece.result);
  }
  return out.take();
}

Part decode(std::string_view body) {
  ByteReader in(body);
  Part p;
  for (std::string* text : {&p.key.config_hash, &p.key.program, &p.title, &p.experiment, &p.config, &p.command,
                            &p.run.created, &p.run.host})
    *text = in.text();
  p.run.elapsed_s = in.get<double>();
  p.run.threads = in.get<std::int64_t>();
  p.run.ranks = in.get<std::int64_t>();
  p.inputs.resize(in.length(8));
  for (config::InputTable& t : p.inputs) {
    t.path = in.text();
    const std::size_t columns = in.length(16);
    for (std::size_t c = 0; c < columns; ++c) {
      t.names.push_back(in.text());
      t.columns.push_back(in.list<double>());
    }
    t.lines = in.list<int>();
  }
  p.texts.resize(in.length(16));
  for (config::InputText& t : p.texts) {
    t.path = in.text();
    t.text = in.text();
  }
  p.references.resize(in.length(32));
  for (config::InputReference& r : p.references) {
    r.path = in.text();
    r.size = in.get<std::uint64_t>();
    r.hash = in.text();
    r.header = in.text();
  }
  p.folder = in.text();
  p.points = in.get<std::uint64_t>();
  p.pieces.resize(in.length(32));
  for (PartPiece& piece : p.pieces) {
    for (std::uint64_t* n : {&piece.point, &piece.blocks.first, &piece.blocks.end, &piece.blocks_in_all})
      *n = in.get<std::uint64_t>();
    piece.whole = in.get<bool>();
    piece.subtrees.resize(in.length(16));
    for (montecarlo::Subtree& s : piece.subtrees) s = montecarlo::subtree_from_bytes(in.text());
    piece.result = in.text();
  }
  return p;
}

}  // namespace

void write_part(const fs::path& path, const Part& part) {
  const std::string bytes = sealed_record(kPartMark, encode(part));
  try {
    store::AtomicFile file(store::resolved(path));
    file.write(bytes);
    file.commit();
  } catch (const std::system_error& e) {
    throw IoError(fmt::format("{}: cannot be written: {}", path.string(), e.code().message()));
  }
}

Part read_part(const fs::path& path) {
  const std::string bytes = read_bytes(path);
  if (!bytes.starts_with(kAnyPartMark)) throw IoError(fmt::format("{}: is no surveymc part file", path.string()));
  if (!bytes.starts_with(kPartMark))
    throw IoError(
        fmt::format("{}: is a part file of another version of surveymc: merge it with that version, or "
                    "delete it and run that part again",
                    path.string()));
  const std::optional<Record> record = record_at(bytes, 0, kPartMark);
  if (!record || record->end != bytes.size())
    throw IoError(fmt::format("{}: is damaged: delete it and run that part again", path.string()));
  try {
    return decode(record->body);
  } catch (const IoError& e) {
    throw IoError(fmt::format("{}: {}", path.string(), e.what()));
  }
}

PartState part_state(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return PartState::missing;
  const std::string bytes = read_bytes(path);
  if (!bytes.starts_with(kAnyPartMark)) return PartState::foreign;
  const std::optional<Record> record = record_at(bytes, 0, kPartMark);
  return record && record->end == bytes.size() ? PartState::whole : PartState::damaged;
}

}  // namespace surveymc::checkpoint
