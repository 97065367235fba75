#pragma once
/// Files that appear whole or not at all: written under a temporary name, which they lose when they are complete. The
/// name may belong to another file by then, of another process too: no file is replaced that nobody has looked at.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

namespace surveymc::store {

/// The file to which a symbolic link points: renaming onto the link would replace the link and leave that file
/// unchanged.
std::filesystem::path resolved(const std::filesystem::path& path);

std::filesystem::path folder_of(const std::filesystem::path& path);

/// Removes temporary files that killed writers of `target` left.
void remove_stale_temporaries(const std::filesystem::path& target);

/// What becomes of another file that has the name when the new one is whole.
enum class OldFile {
  /// It gets the name NAME.1.EXT, or the next number that is free; a part gets NAME.part.1, which no merge takes for a
  /// part. It has that name before it loses its own: a kill at any moment leaves it one.
  kept,
  replaced,  ///< the user has asked for that
  refused    ///< it stays, and commit() throws EEXIST
};

/// Throws unless a new file may take the place of this one.
using MayReplace = std::function<void(const std::filesystem::path& old)>;

/// Calls look(path), and once more where it throws an IoError and another file has got the name, or lost it, meanwhile.
void look_at(const std::filesystem::path& path, const MayReplace& look);

/// A file under its temporary name until commit(); removed if commit() is never called.
/// The name is ".<name>.<16 random digits>.tmp", in the folder of `target`; the writer holds a lock on it, by which
/// others know that it lives. All members throw std::system_error.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& target);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();
  /// Removes the temporary files of this process, for an end that runs no destructors. Nothing may be written after it.
  static void remove_all();

  void write(std::span<const char> bytes);  ///< at the end of the file

  /// Other libraries may write to it.
  const std::filesystem::path& temporary_path() const { return path_; }

  /// Writes the file to the disk and gives it its name. `may_replace` looks at each file that the new one would take
  /// the name of. Returns the new names of files that had it: one at most, unless others write to the same name
  /// meanwhile. Where this throws, all is as it was; only behind the renaming can the disk itself fail.
  std::vector<std::filesystem::path> commit(OldFile old, const MayReplace& may_replace = {});

 private:
  void take_name(OldFile old, const MayReplace& may_replace, std::vector<std::filesystem::path>& kept);
  bool exchange_names();
  void set_committed(bool committed);

  std::filesystem::path target_, path_;
  int file_ = -1;
  bool committed_ = false;
  AtomicFile* older_ = nullptr;  ///< of this process
};

}  // namespace surveymc::store
