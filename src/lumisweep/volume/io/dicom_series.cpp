// Which files make a series.
#include <algorithm>
#include <cmath>

#include "lumisweep/base/error.h"
#include "lumisweep/volume/io/dicom_file.h"
#include "lumisweep/volume/io/dicom_slices.h"

namespace lumisweep {

namespace fs = std::filesystem;

namespace {

bool parallel(const Vec3d& a, const Vec3d& b) { return length(a - b) < 1e-3; }

bool same_geometry(const DicomSeries& a, const DicomSeries& b)
{
    return a.uid == b.uid && a.columns == b.columns && a.rows == b.rows && parallel(a.row_direction, b.row_direction) &&
           parallel(a.column_direction, b.column_direction) &&
           std::abs(a.column_spacing - b.column_spacing) <= 1e-4 * std::abs(a.column_spacing) &&
           std::abs(a.row_spacing - b.row_spacing) <= 1e-4 * std::abs(a.row_spacing);
}

std::vector<fs::path> files_of(const fs::path& path)
{
    if (!fs::is_directory(path))
        return {path};
    std::vector<fs::path> files;
    std::error_code error;
    for (fs::directory_iterator it(path, error), end; !error && it != end; it.increment(error)) {
        std::error_code unreadable;
        if (it->is_regular_file(unreadable))
            files.push_back(it->path());
    }
    require(!error, "{}: cannot be read, {} (check the directory's permissions)", path.string(), error.message());
    std::sort(files.begin(), files.end());
    return files;
}

/// A series in a few words, for warnings.
std::string describe(const DicomSeries& s)
{
    return fmt::format("{} ({} slices of {} x {})", s.uid.empty() ? "without UID" : s.uid, s.slices.size(), s.columns,
                       s.rows);
}

} // namespace

DicomSeries find_dicom_series(const fs::path& path)
{
    prepare_dcmtk();
    const std::string where = path.string();
    std::vector<DicomSeries> groups;
    std::size_t ignored = 0;
    std::string first_refusal;
    std::size_t refusals = 0;
    for (const fs::path& file : files_of(path)) {
        std::vector<DicomSeries> frames;
        try {
            frames = read_dicom_header(file);
        } catch (const Error& error) {
            first_refusal = refusals++ == 0 ? error.what() : first_refusal;
            continue;
        }
        ignored += frames.empty() ? 1 : 0;
        for (DicomSeries& frame : frames) {
            const auto group =
                std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return same_geometry(g, frame); });
            if (group == groups.end())
                groups.push_back(std::move(frame));
            else
                group->slices.push_back(frame.slices.front());
        }
    }
    if (groups.empty() && refusals > 0)
        throw Error(first_refusal);
    require(!groups.empty(), "{}: {} (give {})", where,
            fs::is_directory(path) ? "no DICOM images in this directory" : "not a readable DICOM image",
            fs::is_directory(path) ? "the directory that holds the .dcm files themselves"
                                   : "a DICOM file or directory");

    const auto largest = std::max_element(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
        return a.slices.size() * a.rows * a.columns < b.slices.size() * b.rows * b.columns;
    });
    DicomSeries chosen = std::move(*largest);
    groups.erase(largest);
    if (ignored > 0 && fs::is_directory(path))
        chosen.warnings.push_back(
            fmt::format("{}: {} files are no readable DICOM images and are ignored", where, ignored));
    if (refusals > 0)
        chosen.warnings.push_back(
            fmt::format("{}: {} files are left out, the first: {}", where, refusals, first_refusal));
    std::string others;
    for (const DicomSeries& g : groups)
        others += (others.empty() ? "" : ", ") +
                  std::string(g.uid == chosen.uid ? "same series in another size or orientation: " : "") + describe(g);
    if (!others.empty())
        chosen.warnings.push_back(
            fmt::format("{}: several series; the largest, {}, is used, left out: {}", where, describe(chosen), others));
    return chosen;
}

} // namespace lumisweep
