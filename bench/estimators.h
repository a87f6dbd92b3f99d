// Anything that adds unbiased samples of an image: what efficiency is measured on.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "lumisweep/render/session.h"

namespace lumisweep::bench {

class Estimator {
public:
    Estimator() = default;
    Estimator(const Estimator&) = delete;
    Estimator& operator=(const Estimator&) = delete;
    virtual ~Estimator() = default;

    /// Begins an image anew.
    virtual void start(std::uint64_t seed) = 0;
    /// Adds one sample of every pixel.
    virtual void pass() = 0;
    /// Sums over the passes since start(), [pixels][3].
    virtual std::span<const double> sums() const = 0;
};

/// The renderer with the input's settings. Making it prepares everything.
std::unique_ptr<Estimator> make_session_estimator(const SessionInput& input, const std::string& isa);

/// The plain scalar tracker.
std::unique_ptr<Estimator> make_scalar_estimator(const SessionInput& input);

} // namespace lumisweep::bench
