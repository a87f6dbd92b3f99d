#include "lumisweep/volume/io/dicom_file.h"

#include <cstring>
#include <mutex>
#include <type_traits>

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcrledrg.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmjpeg/djdecode.h>
#include <dcmtk/dcmjpls/djdecode.h>

#include "lumisweep/base/error.h"

namespace lumisweep {

namespace {

/// Bits outside of the stored ones may hold overlays or anything else.
template <class T>
void clean_bits(std::vector<std::byte>& bytes, unsigned stored, unsigned high_bit)
{
    using Unsigned = std::make_unsigned_t<T>;
    const unsigned allocated = 8 * sizeof(T);
    if (stored == 0 || stored >= allocated || high_bit >= allocated || high_bit + 1 < stored)
        return;
    const unsigned left = allocated - 1 - high_bit, right = allocated - stored;
    for (std::size_t i = 0; i + sizeof(T) <= bytes.size(); i += sizeof(T)) {
        Unsigned u;
        std::memcpy(&u, bytes.data() + i, sizeof(T));
        // Right shift of a signed value extends its sign.
        const T v = static_cast<T>(static_cast<T>(static_cast<Unsigned>(u << left)) >> right);
        std::memcpy(bytes.data() + i, &v, sizeof(T));
    }
}

void clean_bits(std::vector<std::byte>& bytes, DcmItem& data)
{
    Uint16 allocated = 0, stored = 0, high_bit = 0, is_signed = 0;
    data.findAndGetUint16(DCM_BitsAllocated, allocated);
    data.findAndGetUint16(DCM_BitsStored, stored);
    data.findAndGetUint16(DCM_HighBit, high_bit);
    data.findAndGetUint16(DCM_PixelRepresentation, is_signed);
    switch (allocated) {
    case 8:
        is_signed ? clean_bits<std::int8_t>(bytes, stored, high_bit)
                  : clean_bits<std::uint8_t>(bytes, stored, high_bit);
        break;
    case 16:
        is_signed ? clean_bits<std::int16_t>(bytes, stored, high_bit)
                  : clean_bits<std::uint16_t>(bytes, stored, high_bit);
        break;
    case 32:
        is_signed ? clean_bits<std::int32_t>(bytes, stored, high_bit)
                  : clean_bits<std::uint32_t>(bytes, stored, high_bit);
        break;
    default: break;
    }
}

/// The pixel element's bytes in host order.
bool copy_pixels(DcmDataset& data, std::vector<std::byte>& bytes)
{
    DcmElement* element = nullptr;
    if (data.findAndGetElement(DCM_PixelData, element).bad() || !element)
        return false;
    const std::size_t length = element->getLength();
    Uint8* as_bytes = nullptr;
    Uint16* as_words = nullptr;
    // 16-bit words are swapped to the host's order by DCMTK; wider pixels are made of such words, low word first.
    if (element->ident() == EVR_OW || element->getVR() == EVR_OW) {
        if (element->getUint16Array(as_words).bad() || !as_words)
            return false;
        as_bytes = reinterpret_cast<Uint8*>(as_words);
    } else if (element->getUint8Array(as_bytes).bad() || !as_bytes) {
        return false;
    }
    const auto* first = reinterpret_cast<const std::byte*>(as_bytes);
    bytes.assign(first, first + length);
    return true;
}

} // namespace

void prepare_dcmtk()
{
    static std::once_flag once;
    std::call_once(once, [] {
        OFLog::configure(OFLogger::OFF_LOG_LEVEL);
        DcmRLEDecoderRegistration::registerCodecs();
        DJDecoderRegistration::registerCodecs();
        DJLSDecoderRegistration::registerCodecs();
    });
}

std::vector<std::byte> decode_dicom_pixels(const std::filesystem::path& file)
{
    prepare_dcmtk();
    const std::string where = file.string();
    DcmFileFormat format;
    std::vector<std::byte> bytes;
    bool ok = format.loadFile(where.c_str()).good();
    if (ok) {
        DcmDataset& data = *format.getDataset();
        const E_TransferSyntax syntax = data.getOriginalXfer();
        if (DcmXfer(syntax).isEncapsulated()) {
            require(data.chooseRepresentation(EXS_LittleEndianExplicit, nullptr).good(),
                    "{}: pixels compressed as \"{}\" cannot be decoded (decompress the series, or it is damaged)",
                    where, DcmXfer(syntax).getXferName());
        }
        ok = copy_pixels(data, bytes);
        if (ok)
            clean_bits(bytes, data);
    }
    require(ok, "{}: the pixels cannot be read (the file is damaged or truncated; copy or export it again)", where);
    return bytes;
}

} // namespace lumisweep
