// Images in memory: float channels by name, and header attributes.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace lumisweep {

struct Channel {
    std::string name;          ///< OpenEXR's: "R", "Variance.R", "depth.Z"
    std::vector<float> pixels; ///< row 0 is the top, width · height values
};

struct Image {
    int width = 0, height = 0;
    std::vector<Channel> channels;
    std::map<std::string, std::string> text;             ///< string attributes
    std::map<std::string, double> numbers;               ///< float/double attributes
    std::map<std::string, std::vector<double>> matrices; ///< 16 numbers, row-major: m44f attributes ("worldToCamera")

    /// nullptr when there is none of that name.
    const Channel* find(const std::string& name) const;
};

} // namespace lumisweep
