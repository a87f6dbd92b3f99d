#include "lumisweep/volume/io/nrrd_file.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "lumisweep/base/error.h"
#include "lumisweep/volume/io/geometry.h"

namespace lumisweep {

namespace {

enum class AxisRole { space, frames, single, component };

/// Axes that count components of one voxel rather than voxels or frames.
bool counts_components(int kind)
{
    switch (kind) {
    case nrrdKindUnknown:
    case nrrdKindDomain:
    case nrrdKindSpace:
    case nrrdKindTime:
    case nrrdKindList:
    case nrrdKindStub:
    case nrrdKindScalar: return false;
    default: return true;
    }
}

bool has_direction(const Nrrd& nrrd, unsigned axis)
{
    // In a space with time ("right-anterior-superior-time") the time axis moves along the fourth coordinate only.
    const double* d = nrrd.axis[axis].spaceDirection;
    bool spatial = false;
    for (unsigned i = 0; i < nrrd.spaceDim && i < 3; ++i) {
        if (!AIR_EXISTS(d[i]))
            return false;
        spatial = spatial || d[i] != 0.0;
    }
    return spatial || nrrd.spaceDim <= 3;
}

/// A space may be named without any direction in it; spacings are all there is then.
bool is_oriented(const Nrrd& nrrd)
{
    for (unsigned a = 0; a < nrrd.dim; ++a)
        if (nrrd.spaceDim > 0 && has_direction(nrrd, a))
            return true;
    return false;
}

AxisRole role_of(const Nrrd& nrrd, unsigned axis, unsigned spatial_so_far)
{
    const NrrdAxisInfo& info = nrrd.axis[axis];
    if (counts_components(info.kind))
        return info.size == 1 ? AxisRole::single : AxisRole::component;
    if (info.kind == nrrdKindStub || info.kind == nrrdKindScalar)
        return info.size == 1 ? AxisRole::single : AxisRole::component;
    if (info.kind == nrrdKindList || info.kind == nrrdKindTime)
        return AxisRole::frames;
    if (is_oriented(nrrd))
        return has_direction(nrrd, axis) ? AxisRole::space : AxisRole::frames;
    return spatial_so_far < 3 ? AxisRole::space : AxisRole::frames;
}

/// Which coordinates of the file's space point the other way than LPS.
std::array<double, 3> lps_signs(const Nrrd& nrrd, VolumeHeader& header, const std::string& where)
{
    switch (nrrd.space) {
    case nrrdSpaceRightAnteriorSuperior:
    case nrrdSpaceRightAnteriorSuperiorTime: return {-1, -1, 1};
    case nrrdSpaceLeftAnteriorSuperior:
    case nrrdSpaceLeftAnteriorSuperiorTime: return {1, -1, 1};
    case nrrdSpace3DLeftHanded:
    case nrrdSpace3DLeftHandedTime:
        header.warnings.push_back(fmt::format("{}: left-handed space is shown as if it were LPS, mirrored", where));
        return {1, 1, 1};
    default: return {1, 1, 1};
    }
}

double spacing_of(const NrrdAxisInfo& axis, const std::string& where, char name, VolumeHeader& header)
{
    if (AIR_EXISTS(axis.spacing))
        return axis.spacing; // a negative one makes the axis run backwards
    if (std::isinf(axis.spacing))
        fail("{}: spacing along axis {} is infinite (mend the header)", where, name);
    if (AIR_EXISTS(axis.min) && AIR_EXISTS(axis.max) && axis.size > 1) {
        const double cells = axis.center == nrrdCenterNode ? double(axis.size - 1) : double(axis.size);
        return (axis.max - axis.min) / cells;
    }
    header.warnings.push_back(fmt::format("{}: no spacing along axis {}, 1 mm is assumed", where, name));
    return 1.0;
}

void place_without_space(const Nrrd& nrrd, const std::vector<unsigned>& axes, std::array<Vec3d, 3>& step, Vec3d& origin,
                         VolumeHeader& header, const std::string& where)
{
    for (unsigned i = 0; i < axes.size(); ++i) {
        const NrrdAxisInfo& axis = nrrd.axis[axes[i]];
        const double spacing = spacing_of(axis, where, "xyz"[i], header);
        step[i] = {0, 0, 0};
        component(step[i], int(i)) = spacing;
        if (AIR_EXISTS(axis.min)) // the border of the first cell, or the first node
            component(origin, int(i)) = axis.min + (axis.center == nrrdCenterNode ? 0.0 : 0.5 * spacing);
    }
}

void place_in_space(const Nrrd& nrrd, const std::vector<unsigned>& axes, std::array<Vec3d, 3>& step, Vec3d& origin,
                    VolumeHeader& header, const std::string& where)
{
    require(nrrd.spaceDim == 3 || nrrd.spaceDim == 4 || axes.size() == nrrd.spaceDim,
            "{}: a space of dimension {} (store the volume in 3-D space)", where, nrrd.spaceDim);
    const auto sign = lps_signs(nrrd, header, where);
    const std::string unit = nrrd.spaceUnits[0] ? nrrd.spaceUnits[0] : "";
    if (!unit.empty() && unit != "mm" && unit.compare(0, 10, "millimeter") != 0)
        header.warnings.push_back(fmt::format("{}: space units other than mm; lengths are taken as they are", where));
    const unsigned dimension = std::min(nrrd.spaceDim, 3U);
    for (unsigned c = 0; c < dimension; ++c) {
        for (unsigned i = 0; i < axes.size(); ++i)
            component(step[i], int(c)) = sign[c] * nrrd.axis[axes[i]].spaceDirection[c];
        if (AIR_EXISTS(nrrd.spaceOrigin[c]))
            component(origin, int(c)) = sign[c] * nrrd.spaceOrigin[c];
        else
            require(!std::isinf(nrrd.spaceOrigin[c]), "{}: the origin is not finite (mend the header)", where);
    }
    // A single slice in 3-D space: its thickness is unknown, its normal is not.
    if (axes.size() == 2 && dimension == 3) {
        const Vec3d normal = cross(step[0], step[1]);
        if (length(normal) > 0.0)
            step[2] = normalized(normal);
    }
}

} // namespace

FrameLayout interpret_nrrd_axes(const Nrrd& nrrd, VolumeHeader& header, const std::string& where)
{
    std::vector<unsigned> axes;
    std::uint64_t frames = 1;
    unsigned frame_axis = nrrd.dim;
    for (unsigned a = 0; a < nrrd.dim; ++a) {
        switch (role_of(nrrd, a, unsigned(axes.size()))) {
        case AxisRole::space: axes.push_back(a); break;
        case AxisRole::single: break;
        case AxisRole::component:
            fail("{}: {} components per voxel (axis {}, kind {}); only scalar volumes can be shown (store one "
                 "component)",
                 where, nrrd.axis[a].size, a + 1, airEnumStr(nrrdKind, nrrd.axis[a].kind));
        case AxisRole::frames:
            if (nrrd.axis[a].size == 1)
                break;
            require(frames == 1, "{}: more than one axis of frames (store one time axis and at most three in space)",
                    where);
            frames = nrrd.axis[a].size;
            frame_axis = a;
            break;
        }
    }
    require(axes.size() == 2 || axes.size() == 3,
            "{}: {} axes in space, need 2 or 3 (mend the header's kinds and sizes)", where, axes.size());

    std::array<std::uint64_t, 3> size{1, 1, 1};
    for (unsigned i = 0; i < axes.size(); ++i)
        size[i] = nrrd.axis[axes[i]].size;
    header.size = checked_size(size, where);
    header.frames = checked_frames(frames, where);

    std::array<Vec3d, 3> step{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Vec3d origin{0, 0, 0};
    if (is_oriented(nrrd)) {
        place_in_space(nrrd, axes, step, origin, header, where);
    } else {
        if (nrrd.spaceDim > 0)
            header.warnings.push_back(
                fmt::format("{}: a space without directions in it, LPS axes from origin 0 are assumed", where));
        place_without_space(nrrd, axes, step, origin, header, where);
    }
    header.world_from_voxel = place_grid(step, origin, where);

    // Runs of one frame are as long as all axes before the frame axis together.
    FrameLayout layout;
    layout.frames = frames;
    layout.inner_bytes = nrrdTypeSize[nrrd.type];
    for (unsigned a = 0; a < nrrd.dim; ++a)
        if (a != frame_axis)
            (a < frame_axis ? layout.inner_bytes : layout.outer) *= nrrd.axis[a].size;
    return layout;
}

} // namespace lumisweep
