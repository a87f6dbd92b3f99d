#include "lumisweep/volume/io/dicom_slices.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include <gdcmAttribute.h>
#include <gdcmImageHelper.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmTrace.h>

#include "lumisweep/base/error.h"

namespace lumisweep {

namespace fs = std::filesystem;

namespace {

const gdcm::Tag tag_modality(0x0008, 0x0060), tag_series(0x0020, 0x000e), tag_instance(0x0020, 0x0013),
    tag_position(0x0020, 0x0032), tag_thickness(0x0018, 0x0050), tag_between(0x0018, 0x0088), tag_rows(0x0028, 0x0010),
    tag_samples(0x0028, 0x0002), tag_pixels(0x7fe0, 0x0010);

std::string text_of(const gdcm::DataSet& data, const gdcm::Tag& tag)
{
    if (!data.FindDataElement(tag))
        return {};
    const gdcm::ByteValue* value = data.GetDataElement(tag).GetByteValue();
    if (!value || value->GetLength() > 1024)
        return {};
    std::string text(value->GetPointer(), value->GetLength());
    text.erase(std::min(text.find('\0'), text.size()));
    while (!text.empty() && text.back() == ' ')
        text.pop_back();
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e)
            c = '?';
    return text;
}

/// Backslash-separated decimal strings; nothing unless there are exactly `count` finite ones.
std::optional<std::vector<double>> numbers_of(const gdcm::DataSet& data, const gdcm::Tag& tag, std::size_t count)
{
    const std::string text = text_of(data, tag);
    std::vector<double> out;
    for (const char* at = text.c_str();;) {
        char* end = nullptr;
        out.push_back(std::strtod(at, &end));
        if (end == at || !std::isfinite(out.back()))
            return std::nullopt;
        while (*end == ' ')
            ++end;
        if (*end != '\\')
            break;
        at = end + 1;
    }
    if (out.size() != count)
        return std::nullopt;
    return out;
}

StoredType stored_type(const gdcm::PixelFormat& format, const std::string& where)
{
    switch (format.GetScalarType()) {
    case gdcm::PixelFormat::UINT8: return StoredType::u8;
    case gdcm::PixelFormat::INT8: return StoredType::i8;
    case gdcm::PixelFormat::UINT16: return StoredType::u16;
    case gdcm::PixelFormat::INT16: return StoredType::i16;
    case gdcm::PixelFormat::UINT32: return StoredType::u32;
    case gdcm::PixelFormat::INT32: return StoredType::i32;
    case gdcm::PixelFormat::FLOAT32: return StoredType::f32;
    case gdcm::PixelFormat::FLOAT64: return StoredType::f64;
    default:
        fail("{}: pixels of {} bits; only 8, 16 and 32 can be read (export the series again)", where,
             format.GetBitsAllocated());
    }
}

/// The position of frame `i` of an enhanced multi-frame file, from the per-frame functional groups.
std::optional<std::vector<double>> frame_position(const gdcm::DataSet& data, std::size_t i)
{
    const auto item_of = [](const gdcm::DataSet& parent, const gdcm::Tag& tag, std::size_t n) -> const gdcm::DataSet* {
        if (!parent.FindDataElement(tag))
            return nullptr;
        const auto items = parent.GetDataElement(tag).GetValueAsSQ();
        return items && n < items->GetNumberOfItems() ? &items->GetItem(n + 1).GetNestedDataSet() : nullptr;
    };
    // The nested sets stay alive: their sequences are held by `data`.
    const gdcm::DataSet* group = item_of(data, gdcm::Tag(0x5200, 0x9230), i);
    const gdcm::DataSet* plane = group ? item_of(*group, gdcm::Tag(0x0020, 0x9113), 0) : nullptr;
    return plane ? numbers_of(*plane, tag_position, 3) : std::nullopt;
}

/// One file as a series of its own.
std::optional<DicomSeries> read_header(const fs::path& path)
{
    gdcm::Reader reader;
    reader.SetFileName(path.c_str());
    if (!reader.CanRead() || !reader.ReadUpToTag(tag_pixels))
        return std::nullopt;
    const gdcm::File& file = reader.GetFile();
    const gdcm::DataSet& data = file.GetDataSet();
    if (!data.FindDataElement(tag_rows))
        return std::nullopt; // a report, a directory file, …

    const std::string where = path.string();
    DicomSeries series;
    series.uid = text_of(data, tag_series);
    series.modality = text_of(data, tag_modality);
    const std::vector<unsigned> dims = gdcm::ImageHelper::GetDimensionsValue(file);
    require(dims.size() >= 2 && dims[0] > 0 && dims[1] > 0, "{}: no rows or columns (export the series again)", where);
    series.columns = dims[0];
    series.rows = dims[1];
    const gdcm::PixelFormat format = gdcm::ImageHelper::GetPixelFormatValue(file);
    require(format.GetSamplesPerPixel() == 1,
            "{}: {} samples per pixel; only scalar volumes can be shown (use a monochrome series)", where,
            format.GetSamplesPerPixel());

    DicomSlice slice;
    slice.file = path;
    slice.type = stored_type(format, where);
    if (const auto instance = numbers_of(data, tag_instance, 1))
        slice.instance = int(std::clamp((*instance)[0], -2e9, 2e9));
    const std::vector<double> scale = gdcm::ImageHelper::GetRescaleInterceptSlopeValue(file);
    slice.intercept = scale.at(0);
    slice.slope = scale.at(1);
    require(std::isfinite(slice.slope) && slice.slope != 0.0 && std::isfinite(slice.intercept),
            "{}: rescale slope {} and intercept {} must be finite and the slope not 0 (export the series again)", where,
            slice.slope, slice.intercept);

    const std::vector<double> spacing = gdcm::ImageHelper::GetSpacingValue(file);
    series.column_spacing = spacing.at(0);
    series.row_spacing = spacing.at(1);
    const std::vector<double> direction = gdcm::ImageHelper::GetDirectionCosinesValue(file);
    series.row_direction = {direction.at(0), direction.at(1), direction.at(2)};
    series.column_direction = {direction.at(3), direction.at(4), direction.at(5)};
    if (const auto between = numbers_of(data, tag_between, 1))
        series.thickness = std::abs((*between)[0]);
    else if (const auto thickness = numbers_of(data, tag_thickness, 1))
        series.thickness = std::abs((*thickness)[0]);
    if (series.thickness == 0.0 && spacing.size() > 2)
        series.thickness = std::abs(spacing[2]);

    const auto position = numbers_of(data, tag_position, 3);
    const std::size_t frames = dims.size() > 2 ? std::max(1U, dims[2]) : 1;
    require(frames <= 65536, "{}: {} frames in one file (export the series again)", where, frames);
    for (std::size_t i = 0; i < frames; ++i) {
        DicomSlice frame = slice;
        frame.frame = i;
        if (frames > 1)
            frame.instance = int(i);
        const auto own = frames > 1 ? frame_position(data, i) : std::nullopt;
        if (const auto& p = own ? own : frames == 1 ? position : std::nullopt) {
            frame.position = {(*p)[0], (*p)[1], (*p)[2]};
            frame.has_position = true;
        }
        series.slices.push_back(frame);
    }
    return series;
}

bool parallel(const Vec3d& a, const Vec3d& b) { return length(a - b) < 1e-3; }

bool same_geometry(const DicomSeries& a, const DicomSeries& b)
{
    return a.uid == b.uid && a.columns == b.columns && a.rows == b.rows && parallel(a.row_direction, b.row_direction) &&
           parallel(a.column_direction, b.column_direction) &&
           std::abs(a.column_spacing - b.column_spacing) <= 1e-4 * std::abs(a.column_spacing) &&
           std::abs(a.row_spacing - b.row_spacing) <= 1e-4 * std::abs(a.row_spacing);
}

void silence_gdcm()
{
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    // Apply rescale slope and intercept wherever they are, also in classes of images for which the standard has none.
    gdcm::ImageHelper::SetForceRescaleInterceptSlope(true);
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
    silence_gdcm();
    const std::string where = path.string();
    std::vector<DicomSeries> groups;
    std::size_t ignored = 0;
    std::string refused, first_refusal;
    std::size_t refusals = 0;
    for (const fs::path& file : files_of(path)) {
        std::optional<DicomSeries> one;
        try {
            one = read_header(file);
        } catch (const Error& error) {
            first_refusal = refusals++ == 0 ? error.what() : first_refusal;
            continue;
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception&) {
            one = std::nullopt; // GDCM's way to say: damaged
        }
        if (!one) {
            ++ignored;
            continue;
        }
        const auto group =
            std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return same_geometry(g, *one); });
        if (group == groups.end())
            groups.push_back(std::move(*one));
        else
            group->slices.insert(group->slices.end(), one->slices.begin(), one->slices.end());
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
