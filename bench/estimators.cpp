#include "estimators.h"

#include <algorithm>
#include <vector>

#include "lumisweep/backends/cpu/cpu_backend.h"
#include "scalar_tracker.h"

namespace lumisweep::bench {
namespace {

class SessionEstimator final : public Estimator {
public:
    SessionEstimator(const SessionInput& input, const std::string& isa) : session_(input, make_cpu_backend(isa))
    {
        session_.prepare();
    }
    void start(std::uint64_t seed) override
    {
        RenderSettings render = session_.input().render;
        render.seed = seed;
        session_.set_render(render);
    }
    void pass() override { session_.render_pass(); }
    std::span<const double> sums() const override { return session_.film().color_sum().span(); }

private:
    Session session_;
};

class ScalarEstimator final : public Estimator {
public:
    explicit ScalarEstimator(const SessionInput& input)
        : tracker_(input),
          sample_(3 * static_cast<std::size_t>(input.image.width) * static_cast<std::size_t>(input.image.height)),
          sums_(sample_.size())
    {
    }
    void start(std::uint64_t seed) override
    {
        seed_ = seed << 32;
        std::fill(sums_.begin(), sums_.end(), 0.0);
    }
    void pass() override
    {
        tracker_.render_pass(seed_++, sample_);
        for (std::size_t i = 0; i < sums_.size(); ++i)
            sums_[i] += static_cast<double>(sample_[i]);
    }
    std::span<const double> sums() const override { return sums_; }

private:
    ScalarTracker tracker_;
    std::vector<float> sample_;
    std::vector<double> sums_;
    std::uint64_t seed_ = 0;
};

} // namespace

std::unique_ptr<Estimator> make_session_estimator(const SessionInput& input, const std::string& isa)
{
    return std::make_unique<SessionEstimator>(input, isa);
}

std::unique_ptr<Estimator> make_scalar_estimator(const SessionInput& input)
{
    return std::make_unique<ScalarEstimator>(input);
}

} // namespace lumisweep::bench
