#pragma once
/// HDF5 calls as C++: identifiers that close themselves and errors that say what could not be done, and why.
#include <hdf5.h>

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace surveymc::store {

/// A file cannot be made or understood. The functions of result_file.h turn it into IoError with the path.
struct Hdf5Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The innermost message of HDF5's error stack: the cause ("truncated file: ..."), not the call that met it.
inline std::string hdf5_reason() {
  std::string reason = "unknown error";
  const auto keep_first = [](unsigned n, const H5E_error2_t* e, void* out) -> herr_t {
    if (n == 0 && e->desc) *static_cast<std::string*>(out) = e->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, &reason);
  // A failed system call: "file write failed: time = ..., error message = 'No space left on device', buf = ..."
  constexpr std::string_view kCall = "error message = '";
  if (const std::size_t at = reason.find(kCall); at != std::string::npos) {
    const std::size_t from = at + kCall.size();
    reason = reason.substr(from, reason.find('\'', from) - from);
  }
  return reason;
}

/// Passes on the result of an HDF5 call; throws Hdf5Failure if it is negative. `action` completes "cannot ...".
template <class T>
T checked(T result, const char* action, const std::string& object = {}) {
  if (result < 0)
    throw Hdf5Failure(fmt::format("cannot {}{}{}: {}", action, object.empty() ? "" : " ", object, hdf5_reason()));
  return result;
}

/// Why an identifier could not be closed, the first time since it was empty. HDF5 writes what it still holds of an
/// object when the object is closed, and a destructor cannot throw: who writes to a disk looks here.
inline std::string& close_fault() {
  static std::string fault;  // one thread of a program uses HDF5
  return fault;
}

/// Owns one HDF5 identifier of any kind.
class Handle {
 public:
  Handle(hid_t id, const char* action, const std::string& object = {}) : id_(checked(id, action, object)) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0 && H5Idec_ref(id_) < 0 && close_fault().empty()) close_fault() = hdf5_reason();
  }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
};

/// Throws std::bad_alloc where little memory is left: HDF5 crashes where it gets none when it starts or
/// opens a file (1.10.8).
inline void require_memory_for_hdf5() {
  constexpr std::size_t kEnough = std::size_t{8} << 20;
  const std::unique_ptr<char[]> room(new char[kEnough]);
  static_cast<volatile char*>(room.get())[0] = 0;  // or compilers leave it out
}

/// Stops HDF5 from printing its error stack to stderr, because we report errors ourselves, and from closing files when
/// the program ends. By then all files are closed but one that could not be written, at which HDF5 would crash
/// (1.10.8). Call this before any other HDF5 function.
inline void silence_hdf5() {
  static const bool once = [] {
    require_memory_for_hdf5();
    return H5dont_atexit() >= 0;
  }();
  (void)once;
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// The properties with which files are opened and made.
inline Handle file_access() {
  require_memory_for_hdf5();
  Handle access(H5Pcreate(H5P_FILE_ACCESS), "make a property list");
  checked(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG), "set the close degree");
  // Readers see finished files only, so a lock protects nothing; on many cluster file systems it just fails.
  checked(H5Pset_file_locking(access, false, true), "turn locking off");
  return access;
}

}  // namespace surveymc::store
