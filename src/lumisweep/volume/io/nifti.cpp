// NIfTI-1 (.nii, .nii.gz). niftiio reads the header; the voxels are read here, because niftiio turns NaN into zeros.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <span>

#include <nifti1_io.h>

#include "lumisweep/base/error.h"
#include "lumisweep/volume/io/formats.h"
#include "lumisweep/volume/io/geometry.h"

namespace lumisweep {

namespace fs = std::filesystem;

namespace {

struct NiftiDelete {
    void operator()(nifti_image* image) const { nifti_image_free(image); }
};

/// The header as it is in the file, after checks that niftiio leaves out or prints to stderr about.
nifti_1_header read_checked_header(const fs::path& path, Compression compression)
{
    const std::string where = path.string();
    nifti_1_header raw{};
    static_assert(sizeof(raw) == 348);
    try {
        ByteSource(path, 0, compression).read(std::as_writable_bytes(std::span(&raw, 1)));
    } catch (const Error&) {
        fail("{}: not a NIfTI file, it cannot be read or is shorter than a header (check path, permissions and file "
             "type)",
             where);
    }
    nifti_1_header h = raw;
    // The header's own length tells the byte order, and NIfTI-1 (348) from NIfTI-2 (540).
    if (h.sizeof_hdr != 348 && h.sizeof_hdr != 540)
        swap_nifti_header(&h, 1);
    require(h.sizeof_hdr != 540, "{}: NIfTI-2 cannot be read (convert it to NIfTI-1)", where);
    require(h.sizeof_hdr == 348, "{}: not a NIfTI file (check the file type)", where);
    require(std::memcmp(h.magic, "n+1", 4) == 0,
            "{}: not a single-file NIfTI, its magic is not n+1 (convert the pair of files to .nii)", where);
    require(h.dim[0] >= 1 && h.dim[0] <= 7, "{}: {} dimensions (mend the header)", where, h.dim[0]);
    for (int i = 1; i <= h.dim[0]; ++i)
        require(h.dim[i] >= 1, "{}: size {} along dimension {} (mend the header)", where, h.dim[i], i);
    require(nifti_is_valid_datatype(h.datatype) != 0, "{}: unknown voxel type {} (mend the header)", where, h.datatype);
    require(h.vox_offset >= 348.0F && h.vox_offset < 2147483648.0F, "{}: data offset {} (mend the header)", where,
            h.vox_offset);
    const auto all_finite = [](std::span<const float> values) {
        return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
    };
    require(all_finite(std::span(h.pixdim).subspan(1, 3)) &&
                (h.qform_code <= 0 || all_finite(std::array{h.quatern_b, h.quatern_c, h.quatern_d, h.qoffset_x,
                                                            h.qoffset_y, h.qoffset_z})) &&
                (h.sform_code <= 0 || (all_finite(h.srow_x) && all_finite(h.srow_y) && all_finite(h.srow_z))),
            "{}: spacing or orientation are not finite (mend the header)", where);
    return raw;
}

StoredType stored_type(const nifti_image& image, const std::string& where)
{
    switch (image.datatype) {
    case DT_INT8: return StoredType::i8;
    case DT_UINT8: return StoredType::u8;
    case DT_INT16: return StoredType::i16;
    case DT_UINT16: return StoredType::u16;
    case DT_INT32: return StoredType::i32;
    case DT_UINT32: return StoredType::u32;
    case DT_INT64: return StoredType::i64;
    case DT_UINT64: return StoredType::u64;
    case DT_FLOAT32: return StoredType::f32;
    case DT_FLOAT64: return StoredType::f64;
    default:
        fail("{}: voxels of type {}; only scalar volumes can be shown (store one integer or float per voxel)", where,
             nifti_datatype_string(image.datatype));
    }
}

bool nearly_equal(const mat44& a, const mat44& b)
{
    double largest = 0.0, difference = 0.0;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) {
            largest = std::max(largest, double(std::abs(a.m[r][c])));
            difference = std::max(difference, double(std::abs(a.m[r][c] - b.m[r][c])));
        }
    return difference <= 1e-4 * largest;
}

/// ITK's choice between the two transforms of a header: the sform where it is in scanner coordinates, agrees with the
/// qform (more digits), or stands alone.
const mat44& choose_transform(const nifti_image& image)
{
    const bool has_s = image.sform_code > 0, has_q = image.qform_code > 0;
    if (has_s && (!has_q || image.sform_code == NIFTI_XFORM_SCANNER_ANAT || nearly_equal(image.sto_xyz, image.qto_xyz)))
        return image.sto_xyz;
    return image.qto_xyz; // from the spacing alone where neither is given
}

void read_geometry(const nifti_image& image, VolumeHeader& header, const std::string& where)
{
    if (image.sform_code <= 0 && image.qform_code <= 0)
        header.warnings.push_back(fmt::format("{}: no orientation in the header, RAS axes are assumed", where));
    const mat44& m = choose_transform(image);
    const double unit = image.xyz_units == NIFTI_UNITS_METER ? 1e3 : image.xyz_units == NIFTI_UNITS_MICRON ? 1e-3 : 1.0;
    // NIfTI's world is RAS: x and y point the other way in LPS.
    const auto lps = [&](int c) { return Vec3d{-m.m[0][c] * unit, -m.m[1][c] * unit, m.m[2][c] * unit}; };
    header.world_from_voxel = place_grid({lps(0), lps(1), lps(2)}, lps(3), where);
}

void read_scale(const nifti_image& image, VolumeHeader& header, const std::string& where)
{
    const double slope = image.scl_slope, inter = image.scl_inter;
    if (slope == 0.0)
        return; // the standard's way to say: unscaled
    if (!std::isfinite(slope) || !std::isfinite(inter)) {
        header.warnings.push_back(fmt::format("{}: scl_slope {} and scl_inter {} are ignored", where, slope, inter));
        return;
    }
    header.slope = slope;
    header.intercept = inter;
}

} // namespace

OpenedVolume open_nifti(const fs::path& path)
{
    const std::string where = path.string();
    const Compression compression = gzip_or_none(path); // downloads often gain or lose ".gz" alone
    const nifti_1_header raw = read_checked_header(path, compression);
    nifti_set_debug_level(0); // no messages on stderr
    const std::unique_ptr<nifti_image, NiftiDelete> image(nifti_convert_nhdr2nim(raw, path.c_str()));
    require(image != nullptr, "{}: the NIfTI header is damaged (mend it, or copy or export the file again)", where);

    OpenedVolume opened;
    VolumeHeader& header = opened.header;
    header.format = "NIfTI";
    opened.type = stored_type(*image, where);
    const auto side = [](int n) { return std::uint64_t(std::max(n, 0)); };
    require(image->nu <= 1 && image->nv <= 1 && image->nw <= 1,
            "{}: {} x {} x {} components per voxel; only scalar volumes can be shown (store one component)", where,
            image->nu, image->nv, image->nw);
    header.size = checked_size({side(image->nx), side(image->ny), side(image->nz)}, where);
    header.frames = checked_frames(side(image->nt), where);
    read_geometry(*image, header, where);
    read_scale(*image, header, where);

    opened.order = image->byteorder == nifti_short_order() ? ByteOrder::native : ByteOrder::swapped;
    FrameLayout layout;
    layout.inner_bytes = size_of(opened.type) * std::uint64_t(header.size.x) * std::uint64_t(header.size.y) *
                         std::uint64_t(header.size.z);
    layout.frames = std::uint64_t(header.frames);
    require(image->iname_offset >= 0, "{}: negative data offset (mend the header)", where);
    const auto offset = std::uint64_t(image->iname_offset);
    require_plausible_size(path, compression == Compression::none ? offset : 0, compression, layout.total_bytes());
    opened.voxels = [path, offset, compression, layout](int frame) -> std::unique_ptr<VoxelSource> {
        return std::make_unique<FileVoxels>(std::make_unique<ByteSource>(path, 0, compression), offset, layout, frame);
    };
    return opened;
}

} // namespace lumisweep
