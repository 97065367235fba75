#include "checkpoint/journal.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include <fmt/format.h>

#include "base/bytes.h"
#include "base/error.h"
#include "store/atomic_file.h"

namespace surveymc::checkpoint {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kJournalMark = "SMCJRNL1";

std::string prefix_of(const fs::path& output) { return store::resolved(output).filename().string() + ".journal."; }

RunKey read_key(ByteReader& in) {
  RunKey key;
  key.config_hash = in.text();
  key.program = in.text();
  return key;
}

/// A file with the name of a journal that begins otherwise belongs to a user.
bool is_journal(std::string_view bytes) { return bytes.starts_with(kJournalMark) || kJournalMark.starts_with(bytes); }

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
    std::string bytes;
    try {
      bytes = read_bytes(path);
    } catch (const IoError&) {
      std::error_code error;
      if (!fs::exists(path, error)) continue;  // another attempt has just finished
      throw;
    }
    if (!is_journal(bytes)) continue;
    std::size_t at = 0;
    while (const std::optional<Record> record = record_at(bytes, at, kJournalMark)) {
      at = record->end;
      ByteReader in(record->body);
      const RunKey of = read_key(in);  // before the tally, whose form another build may not know
      if (of.config_hash != key.config_hash)
        throw IoError(
            fmt::format("{}: is the journal of an unfinished run of another config (hash {}, this one has {}): finish "
                        "that run, or delete the journal, or choose another output with -o",
                        path.string(), of.config_hash, key.config_hash));
      if (of.program != key.program)
        throw IoError(
            fmt::format("{}: is the journal of another build ({}, this is {}), whose results may differ in "
                        "their last bits: finish with that build, or delete the journal",
                        path.string(), of.program, key.program));
      const auto point = in.get<std::uint64_t>();
      all.finished[point].push_back(montecarlo::subtree_from_bytes(in.raw(in.left())));
    }
    if (at != bytes.size() || bytes.empty()) all.damaged.push_back(path);
  }
  return all;
}

void remove_journals(const fs::path& output, const RunKey& key) {
  for (const fs::path& path : journals_of(output)) {
    try {
      const std::string bytes = read_bytes(path);
      if (!is_journal(bytes)) continue;
      const std::optional<Record> first = record_at(bytes, 0, kJournalMark);
      ByteReader in(first ? first->body : std::string_view{});
      if (!first || read_key(in) == key) unlink(path.c_str());
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

void Journal::add(std::uint64_t point, const montecarlo::Subtree& subtree) {
  ByteWriter body;
  body.put(key_.config_hash);
  body.put(key_.program);
  body.put(point);
  const std::string node = montecarlo::subtree_to_bytes(subtree);
  body.put(node.data(), node.size());
  const std::scoped_lock lock(writing_);
  pending_ += sealed_record(kJournalMark, body.take());
}

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
      file_ = open(path_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (file_ < 0 && errno != EEXIST) break;
    }
    if (file_ < 0) return fail();
  }
  ssize_t n;
  do n = ::write(file_, pending_.data(), pending_.size());
  while (n < 0 && errno == EINTR);
  if (n != static_cast<ssize_t>(pending_.size())) {
    if (n >= 0) errno = ENOSPC;  // a short write: the disk is full, or the file may not grow
    fail();
    // Half a record would hide all records written after it. A journal that never had a whole record is removed.
    if (size_ == 0 || ftruncate(file_, size_) != 0) {
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
  return file_ < 0 || fsync(file_) == 0 || fail();
}

}  // namespace surveymc::checkpoint
