#include "lumisweep/volume/io/dicom_slices.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>

#include "lumisweep/base/error.h"
#include "lumisweep/volume/io/dicom_file.h"

namespace lumisweep {

namespace fs = std::filesystem;

namespace {

std::string text_of(DcmItem& data, const DcmTagKey& tag)
{
    OFString value;
    if (data.findAndGetOFString(tag, value).bad())
        return {};
    std::string text(value.c_str(), std::min<std::size_t>(value.length(), 128));
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e)
            c = '?';
    return text;
}

/// The element's decimal or integer strings as numbers; nothing unless there are exactly `count` finite ones.
std::optional<std::vector<double>> numbers_of(DcmItem& data, const DcmTagKey& tag, unsigned long count)
{
    DcmElement* element = nullptr;
    if (data.findAndGetElement(tag, element).bad() || !element || element->getVM() != count)
        return std::nullopt;
    std::vector<double> out(count);
    for (unsigned long i = 0; i < count; ++i) {
        OFString text;
        if (element->getOFString(text, i).bad())
            return std::nullopt;
        char* end = nullptr;
        out[i] = std::strtod(text.c_str(), &end);
        if (end == text.c_str() || !std::isfinite(out[i]))
            return std::nullopt;
    }
    return out;
}

std::uint64_t count_of(DcmItem& data, const DcmTagKey& tag, std::uint64_t otherwise)
{
    Uint16 value = 0;
    return data.findAndGetUint16(tag, value).good() ? value : otherwise;
}

StoredType stored_type(DcmItem& data, const std::string& where)
{
    const bool is_signed = count_of(data, DCM_PixelRepresentation, 0) != 0;
    const auto bits = count_of(data, DCM_BitsAllocated, 0), stored = count_of(data, DCM_BitsStored, bits);
    require(stored <= bits, "{}: {} bits stored in {} (export the series again)", where, stored, bits);
    switch (bits) {
    case 8: return is_signed ? StoredType::i8 : StoredType::u8;
    case 16: return is_signed ? StoredType::i16 : StoredType::u16;
    case 32: return is_signed ? StoredType::i32 : StoredType::u32;
    default: fail("{}: pixels of {} bits; only 8, 16 and 32 can be read (export the series again)", where, bits);
    }
}

/// Written as US or SS, and not always as the one that fits the pixels.
std::optional<std::uint16_t> padding_of(DcmItem& data)
{
    Uint16 bits = 0;
    Sint16 number = 0;
    if (data.findAndGetUint16(DCM_PixelPaddingValue, bits).good())
        return bits;
    if (data.findAndGetSint16(DCM_PixelPaddingValue, number).good())
        return static_cast<std::uint16_t>(number);
    return std::nullopt;
}

/// An attribute of one frame: in enhanced multi-frame files inside a functional group, the frame's own or the one
/// shared by all; in classic files in the data set itself.
class FrameAttributes {
public:
    FrameAttributes(DcmItem& data, unsigned long frame) : data_(data)
    {
        data.findAndGetSequenceItem(DCM_PerFrameFunctionalGroupsSequence, own_, long(frame));
        data.findAndGetSequenceItem(DCM_SharedFunctionalGroupsSequence, shared_, 0);
    }

    std::optional<std::vector<double>> numbers(const DcmTagKey& group, const DcmTagKey& tag, unsigned long count) const
    {
        for (DcmItem* groups : {own_, shared_}) {
            DcmItem* macro = nullptr;
            if (groups && groups->findAndGetSequenceItem(group, macro, 0).good() && macro)
                if (auto found = numbers_of(*macro, tag, count))
                    return found;
        }
        return numbers_of(data_, tag, count);
    }

private:
    DcmItem& data_;
    DcmItem* own_ = nullptr;
    DcmItem* shared_ = nullptr;
};

void read_scale(const FrameAttributes& attributes, DicomSlice& slice, const std::string& where)
{
    if (const auto slope = attributes.numbers(DCM_PixelValueTransformationSequence, DCM_RescaleSlope, 1))
        slice.slope = (*slope)[0];
    if (const auto intercept = attributes.numbers(DCM_PixelValueTransformationSequence, DCM_RescaleIntercept, 1))
        slice.intercept = (*intercept)[0];
    require(slice.slope != 0.0, "{}: rescale slope 0 (export the series again)", where);
}

void read_plane(const FrameAttributes& attributes, DcmItem& data, DicomSeries& series, const std::string& where)
{
    // Written as the distance of rows, then of columns.
    auto spacing = attributes.numbers(DCM_PixelMeasuresSequence, DCM_PixelSpacing, 2);
    if (!spacing)
        spacing = numbers_of(data, DCM_ImagerPixelSpacing, 2);
    if (spacing) {
        series.row_spacing = (*spacing)[0];
        series.column_spacing = (*spacing)[1];
    } else {
        series.warnings.push_back(fmt::format("{}: no usable pixel spacing, 1 mm is assumed", where));
    }
    require(series.row_spacing > 0.0 && series.column_spacing > 0.0,
            "{}: pixel spacing {} x {} mm (export the series again)", where, series.row_spacing, series.column_spacing);
    if (const auto d = attributes.numbers(DCM_PlaneOrientationSequence, DCM_ImageOrientationPatient, 6)) {
        series.row_direction = {(*d)[0], (*d)[1], (*d)[2]};
        series.column_direction = {(*d)[3], (*d)[4], (*d)[5]};
    }
    if (const auto between = attributes.numbers(DCM_PixelMeasuresSequence, DCM_SpacingBetweenSlices, 1))
        series.thickness = std::abs((*between)[0]);
    else if (const auto thickness = attributes.numbers(DCM_PixelMeasuresSequence, DCM_SliceThickness, 1))
        series.thickness = std::abs((*thickness)[0]);
}

} // namespace

std::vector<DicomSeries> read_dicom_header(const fs::path& path)
{
    const std::string where = path.string();
    DcmFileFormat format;
    if (format
            .loadFileUntilTag(where.c_str(), EXS_Unknown, EGL_noChange, DCM_MaxReadLength, ERM_autoDetect,
                              DCM_PixelData)
            .bad())
        return {};
    DcmItem& data = *format.getDataset();
    if (!data.tagExists(DCM_Rows) || !data.tagExists(DCM_Columns))
        return {}; // a report, a directory file, any other file

    DicomSeries common;
    common.uid = text_of(data, DCM_SeriesInstanceUID);
    common.modality = text_of(data, DCM_Modality);
    common.columns = count_of(data, DCM_Columns, 0);
    common.rows = count_of(data, DCM_Rows, 0);
    require(common.columns > 0 && common.rows > 0, "{}: no rows or columns (export the series again)", where);
    const std::uint64_t samples = count_of(data, DCM_SamplesPerPixel, 1);
    require(samples == 1, "{}: {} samples per pixel; only scalar volumes can be shown (use a monochrome series)", where,
            samples);
    DicomSlice slice;
    slice.file = path;
    slice.type = stored_type(data, where);
    slice.padding = padding_of(data);
    if (const auto instance = numbers_of(data, DCM_InstanceNumber, 1))
        slice.instance = int(std::clamp((*instance)[0], -2e9, 2e9));

    double frames = 1.0;
    if (const auto number = numbers_of(data, DCM_NumberOfFrames, 1))
        frames = (*number)[0];
    require(frames >= 1.0 && frames <= 65536.0,
            "{}: {} frames in one file; there must be 1 to 65536 (export the series again)", where, frames);
    std::vector<DicomSeries> out;
    for (unsigned long i = 0; i < static_cast<unsigned long>(frames); ++i) {
        const FrameAttributes attributes(data, i);
        DicomSeries one = common;
        read_plane(attributes, data, one, where);
        slice.frame = i;
        if (frames > 1.0)
            slice.instance = int(i);
        slice.slope = 1.0;
        slice.intercept = 0.0;
        read_scale(attributes, slice, where);
        const auto position = attributes.numbers(DCM_PlanePositionSequence, DCM_ImagePositionPatient, 3);
        slice.has_position = position.has_value();
        if (position)
            slice.position = {(*position)[0], (*position)[1], (*position)[2]};
        one.slices = {slice};
        out.push_back(std::move(one));
    }
    return out;
}

} // namespace lumisweep
