#include "lumisweep/volume/io/load_volume.h"

#include <algorithm>
#include <array>
#include <fstream>

#include "lumisweep/base/error.h"
#include "lumisweep/base/extension.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/volume/io/formats.h"
#include "lumisweep/volume/io/geometry.h"

namespace lumisweep {

namespace fs = std::filesystem;

namespace {

bool is_dicom_file(const fs::path& path)
{
    std::array<char, 132> start{};
    std::ifstream in(path, std::ios::binary);
    in.read(start.data(), start.size());
    return in.gcount() == std::streamsize(start.size()) && std::string(start.data() + 128, 4) == "DICM";
}

OpenedVolume open_by_type(const fs::path& path)
{
    const std::string where = path.string();
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    require(fs::exists(status), "{}: no such file or directory (check the path)", where);
    if (fs::is_directory(status))
        return open_dicom(path);
    require(fs::is_regular_file(status), "{}: not a file (give a volume file or a DICOM directory)", where);
    require(std::ifstream(path, std::ios::binary).good(), "{}: cannot be opened (check its permissions)", where);
    require(fs::file_size(path) > 0, "{}: the file is empty (copy or export it again)", where);
    const std::string e = lower_extension(path);
    if (e == ".nrrd" || e == ".nhdr")
        return open_nrrd(path);
    if (e == ".mha" || e == ".mhd")
        return open_meta_image(path);
    if (e == ".nii" || (e == ".gz" && lower_extension(path.stem()) == ".nii"))
        return open_nifti(path);
    if (e == ".dcm" || e == ".ima" || is_dicom_file(path))
        return open_dicom(path);
    fail("{}: unknown volume format (give .nrrd, .nhdr, .mha, .mhd, .nii, .nii.gz, a DICOM directory or file)", where);
}

/// Messages are one line whatever bytes a path or a header holds.
std::string one_line(std::string text)
{
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    return text;
}

OpenedVolume open_volume(const fs::path& path)
{
    try {
        OpenedVolume opened = open_by_type(path);
        VolumeHeader& h = opened.header;
        set_spacing(h);
        h.voxel_type = name_of(opened.type);
        h.bytes_needed =
            std::uint64_t(h.size.x) * std::uint64_t(h.size.y) * std::uint64_t(h.size.z) * loaded_size_of(opened.type) +
            opened.working_bytes;
        return opened;
    } catch (const Error& e) {
        throw Error(one_line(e.what()));
    } catch (const fs::filesystem_error& e) {
        throw Error(one_line(
            fmt::format("{}: cannot be read, {} (check path and permissions)", path.string(), e.code().message())));
    }
}

/// The file that holds `frame` of a series of files, and the frame's number within it.
struct Chosen {
    OpenedVolume volume;
    std::string where;
    int frame = 0;
    int frames = 0;
};

Chosen choose_frame(const VolumeRequest& request)
{
    Chosen chosen;
    bool found = false;
    Vec3i size{};
    for (const fs::path& file : request.files) {
        OpenedVolume opened = open_volume(file);
        if (chosen.frames == 0)
            size = opened.header.size;
        require(opened.header.size == size,
                "{}: {} x {} x {} voxels, but the first file of the series has {} x {} x {} (give frames of one size)",
                file.string(), opened.header.size.x, opened.header.size.y, opened.header.size.z, size.x, size.y,
                size.z);
        const int within = request.frame - chosen.frames;
        chosen.frames += opened.header.frames;
        require(chosen.frames < (1 << 24), "{}: too many frames in all files together (give fewer)", file.string());
        if (!found && within >= 0 && within < opened.header.frames) {
            found = true;
            chosen.frame = within;
            chosen.where = file.string();
            chosen.volume = std::move(opened);
        }
    }
    require(found, "{}: frame {} asked for, there {} {}, numbered from 0 (set volume.frame accordingly)",
            request.files.front().string(), request.frame, chosen.frames == 1 ? "is" : "are", chosen.frames);
    return chosen;
}

} // namespace

VolumeHeader inspect_volume(const fs::path& path) { return open_volume(path).header; }

LoadedVolume load_volume(const VolumeRequest& request)
{
    require(!request.files.empty(), "volume: no file given (set volume.file)");
    Chosen chosen = choose_frame(request);
    const OpenedVolume& opened = chosen.volume;

    LoadedVolume loaded;
    loaded.modality = opened.header.modality;
    loaded.format = opened.header.format;
    loaded.frames = chosen.frames;
    loaded.warnings = opened.header.warnings;
    require_memory(opened.header.bytes_needed, chosen.where, "crop or downsample the volume, or free memory");
    try {
        const auto source = opened.voxels(chosen.frame);
        loaded.grid = read_grid(*source, opened.type, opened.order, opened.header, chosen.where, loaded.warnings);
    } catch (const Error& e) {
        throw Error(one_line(e.what()));
    }
    loaded.non_finite = loaded.grid.mark_non_finite();
    if (loaded.non_finite > 0)
        loaded.warnings.push_back(fmt::format("{}: {} of {} voxels are NaN or infinite and count as empty",
                                              chosen.where, loaded.non_finite, loaded.grid.voxel_count()));
    for (std::string& w : loaded.warnings)
        w = one_line(w);
    return loaded;
}

} // namespace lumisweep
