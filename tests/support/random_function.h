// Transfer functions at random.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "lumisweep/volume/transfer_function.h"

namespace lumisweep::test {

/// `points` from −40 to 1100, some on the same value, so that there are steps; every fourth 0.
inline TransferFunction random_function(int points, std::mt19937& random, double extinction_scale = 1.0)
{
    std::vector<TransferPoint> list;
    for (int i = 0; i < points; ++i)
        list.push_back({std::floor(std::uniform_real_distribution<double>(-40.0, 1100.0)(random)),
                        i % 4 == 0 ? 0.0 : std::uniform_real_distribution<double>(0.0, 3.0)(random)});
    std::sort(list.begin(), list.end(),
              [](const TransferPoint& a, const TransferPoint& b) { return a.value < b.value; });
    list.push_back({list.back().value, 1.0});
    return TransferFunction(list, extinction_scale);
}

} // namespace lumisweep::test
