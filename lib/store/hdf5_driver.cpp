#include "store/hdf5_driver.h"

#include <hdf5.h>
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

#include <cstdint>
#include <cstring>
#include <functional>
#include <new>

namespace surveymc::store {
namespace {

struct DriverFile {
  H5FD_t common;  // HDF5 knows this part: the first member
  DriverTarget* target;
};

DriverTarget& driver_target(const H5FD_t* file) { return *reinterpret_cast<const DriverFile*>(file)->target; }

H5FD_t* open_target(const char*, unsigned, hid_t access, haddr_t) {
  const void* info = H5Pget_driver_info(access);
  if (!info) return nullptr;
  auto* file = new (std::nothrow) DriverFile{};
  if (!file) return nullptr;
  std::memcpy(&file->target, info, sizeof file->target);
  return &file->common;
}

herr_t close_target(H5FD_t* file) {
  delete reinterpret_cast<DriverFile*>(file);
  return 0;
}

int compare_targets(const H5FD_t* a, const H5FD_t* b) {
  const std::less<const DriverTarget*> less;
  const DriverTarget *x = &driver_target(a), *y = &driver_target(b);
  return less(x, y) ? -1 : less(y, x) ? 1 : 0;
}

/// As HDF5's own driver for files in memory, small pieces are put together; but HDF5 holds no copy of values, as the
/// references of texts are written behind its back (result_writer.cpp).
herr_t query_features(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t allocated_end(const H5FD_t* file, H5FD_mem_t) { return driver_target(file).allocated; }
herr_t set_allocated_end(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  driver_target(file).allocated = end;
  return 0;
}
haddr_t written_end(const H5FD_t* file, H5FD_mem_t) { return driver_target(file).pages.end(); }

/// The first error is HDF5's, too; the others are not.
template <class Action>
herr_t attempt(DriverTarget& target, const Action& action) {
  const bool had_error = target.error != nullptr;
  try {
    action();
  } catch (...) {
    if (!had_error) target.error = std::current_exception();
    return had_error ? 0 : -1;
  }
  return 0;
}

herr_t read_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, void* bytes) {
  DriverTarget& target = driver_target(file);
  return attempt(target, [&] { target.pages.read(at, bytes, size); });
}

herr_t write_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, const void* bytes) {
  DriverTarget& target = driver_target(file);
  if (target.error) return 0;
  return attempt(target, [&] { target.pages.write(at, bytes, size); });
}

H5FD_class_t driver_class() {
  H5FD_class_t c{};
#if H5_VERSION_GE(1, 13, 0)
  c.version = H5FD_CLASS_VERSION;
  c.value = static_cast<H5FD_class_value_t>(512);  // of the range that anyone may use
#endif
  c.name = "surveymc";
  c.maxaddr = INT64_MAX;
  c.fc_degree = H5F_CLOSE_STRONG;
  c.fapl_size = sizeof(DriverTarget*);
  c.open = open_target;
  c.close = close_target;
  c.cmp = compare_targets;
  c.query = query_features;
  c.get_eoa = allocated_end;
  c.set_eoa = set_allocated_end;
  c.get_eof = written_end;
  c.read = read_bytes;
  c.write = write_bytes;
  constexpr H5FD_mem_t kMap[] = H5FD_FLMAP_DICHOTOMY;
  static_assert(sizeof kMap == sizeof c.fl_map);
  std::memcpy(c.fl_map, kMap, sizeof kMap);
  return c;
}

}  // namespace

Handle access_to(DriverTarget& target) {
  static const H5FD_class_t kClass = driver_class();
  // For good: when HDF5 (1.10.8) closes a file, it gives its reference to the driver up before it calls the driver.
  static const hid_t driver = checked(H5FDregister(&kClass), "add a driver");
  Handle access = file_access();
  DriverTarget* const info = &target;
  checked(H5Pset_driver(access, driver, &info), "select the driver");
  return access;
}

}  // namespace surveymc::store
