#pragma once
#include <sys/mman.h>

#include <cstddef>
#include <cstdint>

namespace surveymc {

inline constexpr std::size_t kHugePage = std::size_t{1} << 21;

/// Asks the system for large pages for memory that is not used yet: the page faults of many megabytes take longer than
/// writing them. A hint: nothing changes where there are no such pages.
inline void prefer_huge_pages(const void* begin, std::size_t size) {
#if defined(MADV_HUGEPAGE)
  constexpr std::uintptr_t kPage = 4096;
  if (size < kHugePage) return;
  const std::uintptr_t first = reinterpret_cast<std::uintptr_t>(begin) / kPage * kPage;
  const std::uintptr_t end = reinterpret_cast<std::uintptr_t>(begin) + size;
  const int asked = madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
  (void)asked;
#else
  (void)begin, (void)size;
#endif
}

}  // namespace surveymc
