#include "checkpoint/journal.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <functional>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "base/bytes.h"
#include "base/error.h"
#include "base/numerics.h"
#include "base/retry.h"
#include "store/atomic_file.h"

namespace surveymc::checkpoint {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kIsResult = std::uint64_t{1} << 63;  // beside the number of a point: not a subtree follows
// The last character is the version of the format.
constexpr std::string_view kJournalMark = "SMCJRNL1", kAnyJournalMark = "SMCJRNL";

std::string prefix_of(const fs::path& output) { return store::resolved(output).filename().string() + kJournalInfix; }

/// "<output>.journal.<host>.<pid>", as a writer names its journal.
bool has_our_name(const fs::path& path) {
  const std::string number = path.extension().string();
  return number.size() > 1 && number.find_first_not_of("0123456789", 1) == std::string::npos;
}

/// False of a file that has the name of a journal, but belongs to a user: nothing in it looks like one. What a writer
/// has named is a journal even if damage has left nothing of it.
bool is_journal(const fs::path& path, std::string_view bytes) {
  return has_our_name(path) || bytes.find(kJournalMark) != std::string_view::npos || kJournalMark.starts_with(bytes);
}

/// Nothing if the journal is gone: another attempt, on this host or another one, has just finished.
std::optional<std::string> bytes_of_journal(const fs::path& path) {
  try {
    return read_bytes(path);
  } catch (const IoError&) {
    std::error_code error;
    if (!fs::exists(path, error) && (!error || error.value() == ESTALE)) return std::nullopt;
    throw;
  }
}

struct JournalRecord {
  RunKey key;
  std::uint64_t what = 0;     // the number of a point, perhaps with kIsResult
  std::string_view contents;  // a subtree of its trials, or its result
};

JournalRecord record_from_bytes(std::string_view body) {
  ByteReader in(body);
  JournalRecord record;
  in.fields(record.key.config_hash, record.key.program, record.what);
  record.contents = in.raw(in.left());
  return record;
}

/// What `read` makes of the bytes; nothing if they are damaged.
template <class Read>
auto if_readable(Read read, std::string_view bytes) -> std::optional<decltype(read(bytes))> {
  try {
    return read(bytes);
  } catch (const IoError&) {
    return std::nullopt;
  }
}

/// Reads the whole records of a journal. False if anything else is between them, or if `take` finds one unreadable.
bool for_each_record(std::string_view bytes, const std::function<bool(const JournalRecord&)>& take) {
  constexpr int kMostGaps = 1000;  // a file that is made of false beginnings is not searched for ever
  int gaps = bytes.empty() ? 1 : 0;
  for (std::size_t at = 0; at < bytes.size() && gaps < kMostGaps;) {
    if (const std::optional<Record> record = record_at(bytes, at, kJournalMark)) {
      const std::optional<JournalRecord> contents = if_readable(record_from_bytes, record->body);
      if (!contents || !take(*contents)) ++gaps;
      at = record->end;
    } else {
      at = bytes.find(kJournalMark, at + 1);
      ++gaps;
    }
  }
  return gaps == 0;
}

}  // namespace

std::vector<fs::path> journals_of(const fs::path& output) {
  const std::string prefix = prefix_of(output);
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator it(store::folder_of(store::resolved(output)), error), end; !error && it != end;
       it.increment(error)) {
    std::error_code gone;  // another attempt may remove its journal just now: that does not end the list
    if (it->path().filename().string().starts_with(prefix) && it->is_regular_file(gone)) found.push_back(it->path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

JournalContents read_journals(const fs::path& output, const RunKey& key) {
  JournalContents all;
  for (const fs::path& path : journals_of(output)) {
    const std::optional<std::string> bytes = bytes_of_journal(path);
    if (!bytes) continue;
    const std::string mark = bytes->substr(0, kJournalMark.size());
    if (mark != kJournalMark && mark.starts_with(kAnyJournalMark) && record_at(*bytes, 0, mark))
      throw IoError(fmt::format(
          "{}: is a journal of another version of surveymc: finish with that version, or delete the journal",
          path.string()));
    if (!is_journal(path, *bytes)) continue;
    const bool is_whole = for_each_record(*bytes, [&](const JournalRecord& record) {
      const RunKey& of = record.key;  // before the tally, whose form another build may not know
      if (of.config_hash != key.config_hash)
        throw IoError(
            fmt::format("{}: is the journal of an unfinished run of another config (hash {}, this one has {}): finish "
                        "that run, or delete the journal, or choose another output with -o",
                        path.string(), of.config_hash, key.config_hash));
      if (numerics_of(of.program) != numerics_of(key.program))
        throw IoError(
            fmt::format("{}: is the journal of another build ({}, this is {}), whose results may differ in "
                        "their last bits: finish with that build, or delete the journal",
                        path.string(), of.program, key.program));
      const std::uint64_t point = record.what;
      if ((point & kIsResult) != 0) {
        all.points.insert_or_assign(point & ~kIsResult, std::string(record.contents));
        return true;
      }
      std::optional<montecarlo::Subtree> node = if_readable(montecarlo::subtree_from_bytes, record.contents);
      if (!node) return false;
      if (node->tally.proposal != 0) all.drawn_in.try_emplace({point, node->tally.proposal}, path);
      all.finished[point].push_back(*std::move(node));
      return true;
    });
    if (!is_whole) all.damaged.push_back(path);
  }
  return all;
}

std::optional<JournalLook> look_at_journal(const fs::path& path) {
  const std::optional<std::string> bytes = bytes_of_journal(path);
  if (!bytes) return std::nullopt;
  JournalLook look;
  for_each_record(*bytes, [&](const JournalRecord& record) {
    if (look.key.config_hash.empty()) look.key = record.key;
    if (!same_numbers(record.key, look.key)) return false;
    if ((record.what & kIsResult) != 0) {
      look.points.insert_or_assign(record.what & ~kIsResult, std::string(record.contents));
      return true;
    }
    std::optional<montecarlo::Subtree> node = if_readable(montecarlo::subtree_from_bytes, record.contents);
    if (node) look.finished[record.what].push_back(*std::move(node));
    return node.has_value();
  });
  return look;
}

JournalRemarks journal_remarks(const fs::path& output, const RunKey& key) {
  JournalRemarks remarks;
  for (const fs::path& path : journals_of(output)) {
    const std::optional<std::string> bytes = bytes_of_journal(path);
    if (!bytes) continue;
    if (!is_journal(path, *bytes))
      remarks.warnings.push_back(
          fmt::format("{}: has the name of a journal, but is none: it is not read, and stays", path.string()));
    std::string other;
    for_each_record(*bytes, [&](const JournalRecord& record) {
      if (record.key.program != key.program) other = record.key.program;
      return true;
    });
    if (!other.empty())
      remarks.notes.push_back(
          fmt::format("{}: is of another build ({}), whose numbers have the same bits: used", path.string(), other));
  }
  return remarks;
}

void remove_journals(const fs::path& output, const RunKey& key) {
  for (const fs::path& path : journals_of(output)) {
    try {
      const std::string bytes = read_bytes(path);
      if (!is_journal(path, bytes)) continue;
      bool is_ours = true;
      for_each_record(bytes, [&](const JournalRecord& record) {
        is_ours = is_ours && same_numbers(record.key, key);
        return true;
      });
      if (is_ours) unlink(path.c_str());
    } catch (const IoError&) {  // removed already, or without permission to read
    }
  }
}

Journal::Journal(fs::path output, RunKey key, std::chrono::duration<double> interval)
    : output_(store::resolved(output)),
      key_(std::move(key)),
      interval_(interval),
      last_(std::chrono::steady_clock::now()) {}

Journal::~Journal() {
  if (file_ >= 0) close(file_);
}

void Journal::add_record(std::uint64_t what, std::string_view bytes) {
  ByteWriter body;
  body.fields(key_.config_hash, key_.program, what);
  body.put(bytes.data(), bytes.size());
  const std::scoped_lock lock(writing_);
  pending_ += sealed_record(kJournalMark, body.take());
}

void Journal::add(std::uint64_t point, const montecarlo::Subtree& subtree) {
  add_record(point, montecarlo::subtree_to_bytes(subtree));
}

void Journal::add_point(std::uint64_t point, std::string_view result) { add_record(point | kIsResult, result); }

bool Journal::fail() {
  error_ = std::generic_category().message(errno);
  return false;
}

bool Journal::write() {
  const std::scoped_lock lock(writing_);
  return write_pending();
}

bool Journal::write_pending() {
  last_ = std::chrono::steady_clock::now();
  if (pending_.empty()) return true;
  if (file_ < 0) {
    std::array<char, 256> host{};
    if (gethostname(host.data(), host.size() - 1) != 0) host = {"localhost"};
    const std::string name = fmt::format("{}{}.{}", prefix_of(output_), host.data(), getpid());
    // A dead writer may have had our pid, and its journal may be what we resumed from.
    for (int again = 0; file_ < 0 && again < 1000; ++again) {
      path_ = store::folder_of(output_) / (again == 0 ? name : fmt::format("{}.{}", name, again));
      file_ =
          uninterrupted([&] { return open(path_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_EXCL | O_CLOEXEC, 0666); });
      if (file_ < 0 && errno != EEXIST) break;
    }
    if (file_ < 0) return fail();
  }
  const ssize_t n = uninterrupted([&] { return ::write(file_, pending_.data(), pending_.size()); });
  if (n != static_cast<ssize_t>(pending_.size())) {
    if (n >= 0) errno = ENOSPC;  // a short write: the disk is full, or the file may not grow
    fail();
    // Half a record would hide all records written after it. A journal that never had a whole record is removed.
    if (size_ == 0 || uninterrupted([&] { return ftruncate(file_, size_); }) != 0) {
      if (size_ == 0) unlink(path_.c_str());
      close(file_);
      file_ = -1;
      size_ = 0;
    }
    return false;
  }
  size_ += n;
  pending_.clear();
  error_.clear();
  return true;
}

bool Journal::sync() {
  const std::scoped_lock lock(writing_);
  if (!write_pending()) return false;
  return file_ < 0 || uninterrupted([&] { return fsync(file_); }) == 0 || fail();
}

bool Journal::is_there() const {
  struct stat ours {};
  struct stat there {};
  return file_ >= 0 && fstat(file_, &ours) == 0 && stat(path_.c_str(), &there) == 0 && ours.st_ino == there.st_ino &&
         ours.st_dev == there.st_dev;
}

}  // namespace surveymc::checkpoint
