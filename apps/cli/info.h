// What `lumisweep info` finds out; JSON is the record, text is printed from it.
#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

namespace lumisweep::cli {

nlohmann::ordered_json volume_info(const std::filesystem::path& path, int frame);
nlohmann::ordered_json environment_info(const std::filesystem::path& path);
nlohmann::ordered_json scene_info(const std::filesystem::path& path);

void print_volume(const nlohmann::ordered_json& info);
void print_environment(const nlohmann::ordered_json& info);
void print_scene(const nlohmann::ordered_json& info);

} // namespace lumisweep::cli
