// How many samples a statistical test may take: sanitizers slow everything down several times.
#pragma once

#include <algorithm>

namespace lumisweep::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LUMISWEEP_TEST_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(undefined_behavior_sanitizer)
#define LUMISWEEP_TEST_SANITIZED 1
#endif
#endif

#if defined(LUMISWEEP_TEST_SANITIZED) || !defined(NDEBUG)
inline constexpr bool full_effort = false;
#else
inline constexpr bool full_effort = true;
#endif

/// `samples`, or an eighth of it under sanitizers and without optimisation. Tests judge by their own standard errors,
/// so they stay valid, with less power.
inline int effort(int samples) { return full_effort ? samples : std::max(samples / 8, 2); }

} // namespace lumisweep::test
