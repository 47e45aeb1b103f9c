// The one file that knows GDCM.
#include <gdcmDict.h>
#include <gdcmDicts.h>
#include <gdcmGlobal.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>
#include <gdcmTransferSyntax.h>

#include <exception>

#include "octavo/io/dicom/dicom_library.h"

namespace octavo {

namespace {

gdcm::Image image_of(const CodedPicture& picture) {
  gdcm::Image image;
  image.SetNumberOfDimensions(2);
  image.SetDimension(0, static_cast<unsigned>(picture.columns));
  image.SetDimension(1, static_cast<unsigned>(picture.rows));
  image.SetPixelFormat(gdcm::PixelFormat(1, static_cast<unsigned short>(picture.bits_allocated),
                                         static_cast<unsigned short>(picture.bits_stored),
                                         static_cast<unsigned short>(picture.high_bit),
                                         static_cast<unsigned short>(picture.is_signed ? 1 : 0)));
  image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  image.SetTransferSyntax(gdcm::TransferSyntax::GetTSType(picture.transfer_syntax.c_str()));

  gdcm::SmartPointer<gdcm::SequenceOfFragments> sequence = new gdcm::SequenceOfFragments;
  for (const std::vector<std::byte>& bytes : picture.fragments) {
    gdcm::Fragment fragment;
    fragment.SetByteValue(reinterpret_cast<const char*>(bytes.data()),
                          static_cast<std::uint32_t>(bytes.size()));
    sequence->AddFragment(fragment);
  }
  gdcm::DataElement pixels(gdcm::Tag(0x7fe0, 0x0010));
  pixels.SetVR(gdcm::VR::OB);
  pixels.SetValue(*sequence);
  image.SetDataElement(pixels);
  return image;
}

const gdcm::Dict& dictionary() {
  static const gdcm::Dict& all = gdcm::Global::GetInstance().GetDicts().GetPublicDict();
  return all;
}

class GdcmLibrary final : public DicomLibrary {
 public:
  GdcmLibrary() {
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
  }

  bool decode(const CodedPicture& picture, std::span<std::byte> plane,
              std::size_t& bytes) const override {
    const gdcm::Image image = image_of(picture);
    bytes = image.GetBufferLength();
    if (bytes != plane.size()) return false;
    try {
      return image.GetBuffer(reinterpret_cast<char*>(plane.data()));
    } catch (const std::exception&) {
      return false;
    }
  }

  std::string keyword(DicomTag tag) const override {
    const char* const keyword = dictionary().GetKeywordFromTag(gdcm::Tag(tag));
    return keyword == nullptr ? "" : keyword;
  }

  DicomContent content(DicomTag tag) const override {
    if (keyword(tag).empty()) return DicomContent::binary;
    const gdcm::VR::VRType type = dictionary().GetDictEntry(gdcm::Tag(tag)).GetVR();
    switch (type) {
      case gdcm::VR::PN:
      case gdcm::VR::LO:
      case gdcm::VR::SH:
      case gdcm::VR::LT:
      case gdcm::VR::ST:
      case gdcm::VR::UC:
      case gdcm::VR::UT:
      case gdcm::VR::UI:
      case gdcm::VR::UR: return DicomContent::words;
      case gdcm::VR::AE:
      case gdcm::VR::AS:
      case gdcm::VR::CS:
      case gdcm::VR::DA:
      case gdcm::VR::DS:
      case gdcm::VR::DT:
      case gdcm::VR::IS:
      case gdcm::VR::TM: return DicomContent::text;
      default: return DicomContent::binary;
    }
  }
};

}  // namespace

}  // namespace octavo

extern "C" __attribute__((visibility("default"))) const octavo::DicomLibrary* octavo_gdcm() {
  static const octavo::GdcmLibrary library;
  return &library;
}
