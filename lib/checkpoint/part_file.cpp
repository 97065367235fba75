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

// What the records hold, in the order of the bytes: for bytes_of() and value_from().

constexpr auto kAboutFields = [](auto& bytes, auto& part) {
  bytes.fields(part.key.config_hash, part.key.program, part.title, part.experiment, part.config, part.command,
               part.run.created, part.run.host, part.run.elapsed_s, part.run.threads, part.run.ranks);
  bytes.length_of(24, part.inputs);
  for (auto& t : part.inputs) {
    bytes.fields(t.path);
    bytes.length_of(16, t.names, t.columns);
    for (std::size_t c = 0; c < t.names.size(); ++c) bytes.fields(t.names[c], t.columns[c]);
    bytes.fields(t.lines);
  }
  bytes.length_of(16, part.texts);
  for (auto& t : part.texts) bytes.fields(t.path, t.text);
  bytes.length_of(32, part.references);
  for (auto& r : part.references) bytes.fields(r.path, r.size, r.hash, r.header);
  bytes.fields(part.folder);
};

constexpr auto kPieceFields = [](auto& bytes, auto& piece) {
  bytes.fields(piece.point, piece.blocks.first, piece.blocks.end, piece.blocks_in_all, piece.whole);
  montecarlo::subtree_fields(bytes, piece.subtrees);
  bytes.fields(piece.result, piece.failure);
};

constexpr auto kIndexFields = [](auto& bytes, auto& pieces) {
  bytes.length_of(6 * 8 + 2, pieces);
  for (auto& e : pieces)
    bytes.fields(e.point, e.blocks.first, e.blocks.end, e.blocks_in_all, e.offset, e.size, e.whole, e.failed);
};

/// The head without its checksum; sealed_record() has one that stands at the end.
std::string encode_head(const Part& p, std::uint64_t file_size, std::uint64_t about_size, std::uint64_t index_size,
                        std::uint64_t flags) {
  ByteWriter out;
  const std::string run = run_bytes(p.key);
  out.put(kPartMark.data(), kPartMark.size());
  out.put(file_size);
  out.put(run.data(), run.size());
  out.fields(p.points, p.range.first, p.range.end, p.range.stride, p.shard, p.shards, p.run.elapsed_s, about_size,
             index_size, flags);
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
  std::uint64_t flags = 0;
  in.fields(h.points, h.range.first, h.range.end, h.range.stride, h.shard, h.shards, h.elapsed_s, h.about_size,
            h.index_size, flags);
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

std::vector<fs::path> write_part_of(const fs::path& path, const Part& about, std::vector<PieceEntry> pieces,
                                    const std::function<std::string(std::size_t)>& piece_bytes, store::OldFile old) {
  const std::string first = sealed_record(kAboutMark, bytes_of(about, kAboutFields));
  const std::uint64_t index_size = sealed_record(kIndexMark, bytes_of(pieces, kIndexFields)).size();
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
    start += sealed_record(kIndexMark, bytes_of(pieces, kIndexFields));
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
    return file.commit(old, [&](const fs::path& there) { refuse_foreign_part(there); });
  } catch (const std::system_error& e) {
    throw IoError(fmt::format("{}: cannot be written: {}", path.string(), e.code().message()));
  }
}

std::vector<fs::path> write_part(const fs::path& path, const Part& part, store::OldFile old) {
  std::vector<std::string> records;
  std::vector<PieceEntry> entries;
  for (const PartPiece& p : part.pieces) {
    records.push_back(sealed_record(kPieceMark, bytes_of(p, kPieceFields)));
    entries.push_back({p.point, p.blocks, p.blocks_in_all, p.whole || !p.failure.empty(), !p.failure.empty(), 0,
                       records.back().size()});
  }
  return write_part_of(
      path, part, std::move(entries), [&](std::size_t i) { return std::move(records[i]); }, old);
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
  if (file < 0) cannot_be_read(path);
  struct stat status {};
  char bytes[kHeadSize];
  const bool is_known = fstat(file, &status) == 0, is_file = is_known && S_ISREG(status.st_mode);
  const ssize_t n = is_file ? read_at(file, bytes, sizeof bytes, 0) : -1;
  const std::string reason = std::generic_category().message(errno);
  ::close(file);
  if (!is_known) cannot_be_read(path, reason);
  if (!is_file) cannot_be_read(path, input_fault(path));
  if (n < 0) cannot_be_read(path, reason);
  return decode_head(path, {bytes, static_cast<std::size_t>(n)}, static_cast<std::uint64_t>(status.st_size));
}

PartReader::PartReader(fs::path path) : path_(std::move(path)), head_(read_part_head(path_)) {
  try {
    const std::string index = bytes(kHeadSize + head_.about_size, head_.index_size);
    pieces_ = decoded(
        path_, [&] { return value_from<std::vector<PieceEntry>>(body_of(path_, index, kIndexMark), kIndexFields); });
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
  if (file_ < 0 || fstat(file_, &status) != 0) cannot_be_read(path_);
  const auto in_all = static_cast<std::uint64_t>(status.st_size);
  if (offset > in_all || size > in_all - offset) damaged(path_);
  std::string out(static_cast<std::size_t>(size), '\0');
  const ssize_t n = read_at(file_, out.data(), out.size(), offset);
  if (n < 0) cannot_be_read(path_);
  if (static_cast<std::size_t>(n) < out.size()) damaged(path_);
  return out;
}

Part PartReader::about() {
  const std::string record = bytes(kHeadSize, head_.about_size);
  Part p = decoded(path_, [&] { return value_from<Part>(body_of(path_, record, kAboutMark), kAboutFields); });
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
  PartPiece p = decoded(path_, [&] { return value_from<PartPiece>(body_of(path_, record, kPieceMark), kPieceFields); });
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

bool has_part_mark(const fs::path& path) {
  const int file = uninterrupted([&] { return open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); });
  if (file < 0) return false;
  std::string begin(kAnyPartMark.size(), '\0');
  const ssize_t n = read_at(file, begin.data(), begin.size(), 0);
  ::close(file);
  return n == static_cast<ssize_t>(begin.size()) && begin == kAnyPartMark;
}

PartState part_state(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return PartState::missing;
  try {
    read_part(path);
    return PartState::whole;
  } catch (const IoError&) {
    return has_part_mark(path) ? PartState::damaged : PartState::foreign;
  }
}

namespace {

void refuse_what_is_no_part(const fs::path& path) {
  std::error_code error;
  const fs::file_type type = fs::status(path, error).type();
  if (type == fs::file_type::none)  // the system does not say: it may be a part
    throw IoError(fmt::format("{}: cannot be looked at: {}", path.string(), error.message()));
  if (type != fs::file_type::not_found && !has_part_mark(path))
    throw IoError(fmt::format("{}: exists and is no surveymc part file: refusing to overwrite it", path.string()));
}

}  // namespace

void refuse_foreign_part(const fs::path& path) { store::look_at(path, refuse_what_is_no_part); }

}  // namespace surveymc::checkpoint
