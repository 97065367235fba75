#pragma once
/// Checkpoint journals: finished blocks of a run that is not done, in files beside its output. Each writer appends to a
/// file of its own, "<output>.journal.<host>.<pid>", so two attempts at once do not disturb each other. A journal has
/// one record per subtree of blocks, or per point of a study without trials, with a checksum. A killed writer leaves at
/// worst half a record at the end, which is not read.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "checkpoint/record.h"
#include "montecarlo/run_blocks.h"

namespace surveymc::checkpoint {

/// Between the name of an output and that of the run, in the name of a journal.
inline constexpr const char* kJournalInfix = ".journal.";

/// Finished subtrees of every sweep point; they may be nested (disjoint_subtrees()).
using FinishedBlocks = std::map<std::uint64_t, std::vector<montecarlo::Subtree>>;

/// Journals beside `output`, whoever wrote them; sorted.
std::vector<std::filesystem::path> journals_of(const std::filesystem::path& output);

/// Results of finished sweep points without trials, as bytes.
using FinishedPoints = std::map<std::uint64_t, std::string>;

/// The journal that has trials of a point from a proposal (stats::Tally::proposal), the first one if several have.
using JournalsOfProposals = std::map<std::pair<std::uint64_t, std::uint64_t>, std::filesystem::path>;

struct JournalContents {
  FinishedBlocks finished;
  std::vector<std::filesystem::path> damaged;  ///< journals that are not whole; records before the damage count
  FinishedPoints points = {};
  JournalsOfProposals drawn_in = {};
};

/// Throws IoError if a journal beside `output` belongs to another config or another build of the program.
JournalContents read_journals(const std::filesystem::path& output, const RunKey& key);

/// A journal as it stands, of whatever run, for a look from outside while others write to it.
struct JournalLook {
  RunKey key;  ///< of its first record; empty where it has none
  FinishedBlocks finished;
  FinishedPoints points;
};
/// Nothing if it is gone. Throws IoError where it cannot be read.
std::optional<JournalLook> look_at_journal(const std::filesystem::path& path);

/// Remarks for the user on the journals beside `output`: which of those that read_journals() takes are of another
/// build, and which files have the name of a journal and are none. Throws IoError.
struct JournalRemarks {
  std::vector<std::string> notes, warnings;
};
JournalRemarks journal_remarks(const std::filesystem::path& output, const RunKey& key);

/// Removes the journals of this run, once its output was written: those that read_journals() would read, and damaged
/// ones. What is no journal stays.
void remove_journals(const std::filesystem::path& output, const RunKey& key);

/// A writer. The file is made at the first write: a run that ends before has none. add(), due(), write() and sync() may
/// be called from several threads.
class Journal {
 public:
  /// Writes at most every `interval`.
  Journal(std::filesystem::path output, RunKey key, std::chrono::duration<double> interval);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  bool due() const { return std::chrono::steady_clock::now() - last_.load() >= interval_; }
  /// Keeps the record for the next write.
  void add(std::uint64_t point, const montecarlo::Subtree& subtree);
  /// The same for the result of a point without trials. point < 2^63.
  void add_point(std::uint64_t point, std::string_view result);
  /// Appends in one write() all that was added. False, with the reason in error(), if that failed: it is kept for the
  /// next time, and the file is as long as before.
  bool write();
  /// write(), and waits until the disk has it.
  bool sync();
  const std::string& error() const { return error_; }
  /// True if the file is still there: somebody may have removed it, or its folder.
  bool is_there() const;

 private:
  bool fail();
  bool write_pending();
  void add_record(std::uint64_t what, std::string_view bytes);

  std::mutex writing_;
  std::filesystem::path output_;
  RunKey key_;
  std::chrono::duration<double> interval_;
  std::atomic<std::chrono::steady_clock::time_point> last_;
  std::string pending_, error_;
  std::filesystem::path path_;
  int file_ = -1;
  std::int64_t size_ = 0;
};

}  // namespace surveymc::checkpoint
