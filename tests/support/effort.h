// How many samples a statistical test may take.
#pragma once

#include <algorithm>

namespace lumisweep::test {

#if defined(__SANITIZE_THREAD__)
#define LUMISWEEP_TEST_SLOW 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define LUMISWEEP_TEST_SLOW 1
#endif
#endif

#if defined(LUMISWEEP_TEST_SLOW)
inline constexpr bool full_effort = false;
#else
inline constexpr bool full_effort = true;
#endif

/// `samples`, or an eighth of it under ThreadSanitizer, which looks at threads and not at statistics.
inline int effort(int samples) { return full_effort ? samples : std::max(samples / 8, 2); }

} // namespace lumisweep::test
