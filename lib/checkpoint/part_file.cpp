#include "checkpoint/part_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include <fmt/format.h>

#include "base/bytes.h"
#include "base/error.h"
#include "base/input_path.h"
#include "base/numerics.h"
#include "base/retry.h"
#include "store/atomic_file.h"

namespace surveymc::checkpoint {
namespace {

namespace fs = std::filesystem;

// The last character is the version of the format.
constexpr std::string_view kPartMark = "SMCPART3", kAnyPartMark = "SMCPART";
constexpr std::string_view kAboutMark = "SMCABOUT", kIndexMark = "SMCINDEX", kPieceMark = "SMCPIECE";
constexpr std::size_t kHeadSize = 128;
constexpr std::uint64_t kWholeFlag = 1, kFailedFlag = 2;

[[noreturn]] void damaged(const fs::path& path) {
  throw IoError(fmt::format("{}: is damaged: delete it and run that part again", path.string()));
}

std::string encode_about(const Part& p) {
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
  return out.take();
}

Part decode_about(std::string_view body) {
  ByteReader in(body);
  Part p;
  for (std::string* text : {&p.key.config_hash, &p.key.program, &p.title, &p.experiment, &p.config, &p.command,
                            &p.run.created, &p.run.host})
    *text = in.text();
  p.run.elapsed_s = in.get<double>();
  p.run.threads = in.get<std::int64_t>();
  p.run.ranks = in.get<std::int64_t>();
  p.inputs.resize(in.length(24));
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
  return p;
}

std::string encode_piece(const PartPiece& piece) {
  ByteWriter out;
  for (const std::uint64_t n : {piece.point, piece.blocks.first, piece.blocks.end, piece.blocks_in_all}) out.put(n);
  out.put(piece.whole);
  out.put(std::uint64_t{piece.subtrees.size()});
  for (const montecarlo::Subtree& s : piece.subtrees) out.put(montecarlo::subtree_to_bytes(s));
  out.put(piece.result);
  out.put(piece.failure);
  return out.take();
}

PartPiece decode_piece(std::string_view body) {
  ByteReader in(body);
  PartPiece piece;
  for (std::uint64_t* n : {&piece.point, &piece.blocks.first, &piece.blocks.end, &piece.blocks_in_all})
    *n = in.get<std::uint64_t>();
  piece.whole = in.get<bool>();
  piece.subtrees.resize(in.length(16));
  for (montecarlo::Subtree& s : piece.subtrees) s = montecarlo::subtree_from_bytes(in.text());
  piece.result = in.text();
  piece.failure = in.text();
  return piece;
}

constexpr std::size_t kEntrySize = 6 * 8 + 2;

std::string encode_index(const std::vector<PieceEntry>& pieces) {
  ByteWriter out;
  out.put(std::uint64_t{pieces.size()});
  for (const PieceEntry& e : pieces) {
    for (const std::uint64_t n : {e.point, e.blocks.first, e.blocks.end, e.blocks_in_all, e.offset, e.size}) out.put(n);
    out.put(e.whole);
    out.put(e.failed);
  }
  return out.take();
}

std::vector<PieceEntry> decode_index(std::string_view body) {
  ByteReader in(body);
  std::vector<PieceEntry> pieces(in.length(kEntrySize));
  for (PieceEntry& e : pieces) {
    for (std::uint64_t* n : {&e.point, &e.blocks.first, &e.blocks.end, &e.blocks_in_all, &e.offset, &e.size})
      *n = in.get<std::uint64_t>();
    e.whole = in.get<bool>();
    e.failed = in.get<bool>();
  }
  return pieces;
}

/// The head without its checksum; sealed_record() has one that stands at the end.
std::string encode_head(const Part& p, std::uint64_t file_size, std::uint64_t about_size, std::uint64_t index_size,
                        std::uint64_t flags) {
  ByteWriter out;
  const std::string run = run_bytes(p.key);
  out.put(kPartMark.data(), kPartMark.size());
  out.put(file_size);
  out.put(run.data(), run.size());
  for (const std::uint64_t n : {p.points, p.range.first, p.range.end, p.range.stride, p.shard, p.shards}) out.put(n);
  out.put(p.run.elapsed_s);
  for (const std::uint64_t n : {about_size, index_size, flags}) out.put(n);
  std::string bytes = out.take();
  return bytes + checksum_of(bytes);
}

/// `bytes`: the beginning of the file, kHeadSize of them if it has as many.
PartHead decode_head(const fs::path& path, std::string_view bytes, std::uint64_t file_size) {
  if (!bytes.starts_with(kAnyPartMark)) throw IoError(fmt::format("{}: is no surveymc part file", path.string()));
  if (!bytes.starts_with(kPartMark))
    throw IoError(
        fmt::format("{}: is a part file of another version of surveymc: merge it with that version, or "
                    "delete it and run that part again",
                    path.string()));
  const std::size_t sealed = kHeadSize - 16;
  if (bytes.size() < kHeadSize || bytes.substr(sealed, 16) != checksum_of(bytes.substr(0, sealed))) damaged(path);
  ByteReader in(bytes.substr(kPartMark.size()));
  if (in.get<std::uint64_t>() != file_size) damaged(path);
  PartHead h;
  h.run = std::string(in.raw(16));
  for (std::uint64_t* n : {&h.points, &h.range.first, &h.range.end, &h.range.stride, &h.shard, &h.shards})
    *n = in.get<std::uint64_t>();
  h.elapsed_s = in.get<double>();
  h.about_size = in.get<std::uint64_t>();
  h.index_size = in.get<std::uint64_t>();
  const auto flags = in.get<std::uint64_t>();
  h.whole = (flags & kWholeFlag) != 0;
  h.failed = (flags & kFailedFlag) != 0;
  if (h.range.stride == 0 || h.shards == 0 || h.about_size > file_size || h.index_size > file_size) damaged(path);
  return h;
}

std::string_view body_of(const fs::path& path, std::string_view bytes, std::string_view mark) {
  const std::optional<Record> record = record_at(bytes, 0, mark);
  if (!record || record->end != bytes.size()) damaged(path);
  return record->body;
}

/// decode(body), whose IoError names the file.
template <class Decode>
auto decoded(const fs::path& path, const Decode& decode) {
  try {
    return decode();
  } catch (const IoError& e) {
    throw IoError(fmt::format("{}: {}", path.string(), e.what()));
  }
}

}  // namespace

std::string run_bytes(const RunKey& key) {
  ByteWriter out;
  out.put(key.config_hash);
  out.put(std::string(numerics_of(key.program)));  // other builds with the same bits count
  return checksum_of(out.take());
}

void write_part_of(const fs::path& path, const Part& about, std::vector<PieceEntry> pieces,
                   const std::function<std::string(std::size_t)>& piece_bytes) {
  const std::string first = sealed_record(kAboutMark, encode_about(about));
  const std::uint64_t index_size = sealed_record(kIndexMark, encode_index(pieces)).size();
  std::uint64_t end = kHeadSize + first.size() + index_size, flags = kWholeFlag;
  for (PieceEntry& e : pieces) {
    e.offset = end;
    end += e.size;
    if (!e.whole) flags &= ~kWholeFlag;
    if (e.failed) flags |= kFailedFlag;
  }
  try {
    store::AtomicFile file(store::resolved(path));
    const auto put = [&](const std::string& bytes) { file.write({bytes.begin(), bytes.end()}); };
    std::string start = encode_head(about, end, first.size(), index_size, flags) + first;
    start += sealed_record(kIndexMark, encode_index(pieces));
    constexpr std::size_t kBuffer = std::size_t{1} << 20;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const std::string bytes = piece_bytes(i);
      if (bytes.size() != pieces[i].size) throw std::logic_error("a piece has another size than its entry");
      start += bytes;
      if (start.size() < kBuffer) continue;
      put(start);
      start.clear();
    }
    put(start);
    file.commit();
  } catch (const std::system_error& e) {
    throw IoError(fmt::format("{}: cannot be written: {}", path.string(), e.code().message()));
  }
}

void write_part(const fs::path& path, const Part& part) {
  std::vector<std::string> records;
  std::vector<PieceEntry> entries;
  for (const PartPiece& p : part.pieces) {
    records.push_back(sealed_record(kPieceMark, encode_piece(p)));
    entries.push_back({p.point, p.blocks, p.blocks_in_all, p.whole || !p.failure.empty(), !p.failure.empty(), 0,
                       records.back().size()});
  }
  write_part_of(path, part, std::move(entries), [&](std::size_t i) { return std::move(records[i]); });
}

namespace {

/// Bytes from `offset` on, `size` or as many as there are: a read may give fewer. Negative: errno says why.
ssize_t read_at(int file, char* out, std::size_t size, std::uint64_t offset) {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t n =
        uninterrupted([&] { return pread(file, out + done, size - done, static_cast<off_t>(offset + done)); });
    if (n < 0) return n;
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  return static_cast<ssize_t>(done);
}

}  // namespace

PartHead read_part_head(const fs::path& path) {
  const int file = uninterrupted([&] { return open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); });
  const auto fail = [&](int reason) {
    throw IoError(fmt::format("{}: cannot be read: {}", path.string(), std::generic_category().message(reason)));
  };
  if (file < 0) fail(errno);
  struct stat status {};
  char bytes[kHeadSize];
  const bool is_known = fstat(file, &status) == 0, is_file = is_known && S_ISREG(status.st_mode);
  const ssize_t n = is_file ? read_at(file, bytes, sizeof bytes, 0) : -1;
  const int reason = errno;
  ::close(file);
  if (!is_known) fail(reason);
  if (!is_file) throw IoError(fmt::format("{}: cannot be read: {}", path.string(), input_fault(path)));
  if (n < 0) fail(reason);
  return decode_head(path, {bytes, static_cast<std::size_t>(n)}, static_cast<std::uint64_t>(status.st_size));
}

PartReader::PartReader(fs::path path) : path_(std::move(path)), head_(read_part_head(path_)) {
  try {
    const std::string index = bytes(kHeadSize + head_.about_size, head_.index_size);
    pieces_ = decoded(path_, [&] { return decode_index(body_of(path_, index, kIndexMark)); });
  } catch (...) {
    close();
    throw;
  }
}

PartReader::~PartReader() { close(); }

PartReader::PartReader(PartReader&& other) noexcept
    : path_(std::move(other.path_)),
      head_(std::move(other.head_)),
      pieces_(std::move(other.pieces_)),
      file_(std::exchange(other.file_, -1)) {}

void PartReader::close() {
  if (file_ >= 0) ::close(std::exchange(file_, -1));
}

std::string PartReader::bytes(std::uint64_t offset, std::uint64_t size) {
  if (file_ < 0) file_ = uninterrupted([&] { return open(path_.c_str(), O_RDONLY | O_CLOEXEC); });
  struct stat status {};
  if (file_ < 0 || fstat(file_, &status) != 0)
    throw IoError(fmt::format("{}: cannot be read: {}", path_.string(), std::generic_category().message(errno)));
  const auto in_all = static_cast<std::uint64_t>(status.st_size);
  if (offset > in_all || size > in_all - offset) damaged(path_);
  std::string out(static_cast<std::size_t>(size), '\0');
  const ssize_t n = read_at(file_, out.data(), out.size(), offset);
  if (n < 0)
    throw IoError(fmt::format("{}: cannot be read: {}", path_.string(), std::generic_category().message(errno)));
  if (static_cast<std::size_t>(n) < out.size()) damaged(path_);
  return out;
}

Part PartReader::about() {
  const std::string record = bytes(kHeadSize, head_.about_size);
  Part p = decoded(path_, [&] { return decode_about(body_of(path_, record, kAboutMark)); });
  p.points = head_.points;
  p.range = head_.range;
  p.shard = head_.shard;
  p.shards = head_.shards;
  return p;
}

std::string PartReader::piece_bytes(std::size_t i) {
  std::string record = bytes(pieces_.at(i).offset, pieces_.at(i).size);
  body_of(path_, record, kPieceMark);  // a damaged piece goes into no other part
  return record;
}

PartPiece PartReader::piece(std::size_t i) {
  const std::string record = bytes(pieces_.at(i).offset, pieces_.at(i).size);
  PartPiece p = decoded(path_, [&] { return decode_piece(body_of(path_, record, kPieceMark)); });
  if (p.point != pieces_[i].point) damaged(path_);
  p.file = path_.string();
  return p;
}

Part read_part(const fs::path& path) {
  PartReader reader(path);
  Part part = reader.about();
  for (std::size_t i = 0; i < reader.pieces().size(); ++i) part.pieces.push_back(reader.piece(i));
  return part;
}

PartState part_state(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return PartState::missing;
  try {
    read_part(path);
    return PartState::whole;
  } catch (const IoError&) {
    std::string begin;
    if (const int file = uninterrupted([&] { return open(path.c_str(), O_RDONLY | O_CLOEXEC); }); file >= 0) {
      begin.assign(kAnyPartMark.size(), '\0');
      const ssize_t n = read_at(file, begin.data(), begin.size(), 0);
      begin.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
      ::close(file);
    }
    return begin == kAnyPartMark ? PartState::damaged : PartState::foreign;
  }
}

}  // namespace surveymc::checkpoint
