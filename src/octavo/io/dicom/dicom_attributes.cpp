#include "octavo/io/dicom/dicom_attributes.h"

#include <algorithm>
#include <iterator>
#include <set>

#include "octavo/io/source/value_unit.h"

namespace octavo {

namespace {

/// Of an attribute that is a list of numbers; standards give a dozen.
constexpr std::size_t kMaxNumbers = 512;

/// What the value must be to be kept.
enum class Form { number, code, position, unit, setting };

struct Attribute {
  DicomTag tag;
  const char* name;
  Form form;
};
constexpr Attribute kAttributes[] = {
    {0x00080008, "ImageType", Form::code},
    {0x00080060, "Modality", Form::code},
    {0x00080070, "Manufacturer", Form::setting},
    {0x00081090, "ManufacturerModelName", Form::setting},
    {0x00180015, "BodyPartExamined", Form::code},
    {0x00180020, "ScanningSequence", Form::code},
    {0x00180022, "ScanOptions", Form::code},
    {0x00180023, "MRAcquisitionType", Form::code},
    {0x00180050, "SliceThickness", Form::number},
    {0x00180060, "KVP", Form::number},
    {0x00180080, "RepetitionTime", Form::number},
    {0x00180081, "EchoTime", Form::number},
    {0x00180082, "InversionTime", Form::number},
    {0x00180087, "MagneticFieldStrength", Form::number},
    {0x00180088, "SpacingBetweenSlices", Form::number},
    {0x00181100, "ReconstructionDiameter", Form::number},
    {0x00181120, "GantryDetectorTilt", Form::number},
    {0x00181150, "ExposureTime", Form::number},
    {0x00181151, "XRayTubeCurrent", Form::number},
    {0x00181152, "Exposure", Form::number},
    {0x00181160, "FilterType", Form::setting},
    {0x00181210, "ConvolutionKernel", Form::setting},
    {0x00181314, "FlipAngle", Form::number},
    {0x00185100, "PatientPosition", Form::position},
    {0x00280004, "PhotometricInterpretation", Form::code},
    {0x00281050, "WindowCenter", Form::number},
    {0x00281051, "WindowWidth", Form::number},
    {0x00281054, "RescaleType", Form::unit},
    {0x00282110, "LossyImageCompression", Form::code},
    {0x00282112, "LossyImageCompressionRatio", Form::number},
    {0x00541001, "Units", Form::unit},
};

const Attribute* attribute_of(DicomTag tag) {
  const auto* found = std::find_if(std::begin(kAttributes), std::end(kAttributes),
                                   [&](const Attribute& each) { return each.tag == tag; });
  return found == std::end(kAttributes) ? nullptr : found;
}

/// Values behind one another are all of the form of a Code String.
bool is_code(const std::string& text) {
  constexpr std::size_t kMaxCode = 16;
  std::size_t length = 0;
  for (const char c : text) {
    length = c == '\\' ? 0 : length + 1;
    const bool is_letter = c >= 'A' && c <= 'Z';
    const bool is_digit = c >= '0' && c <= '9';
    if (length > kMaxCode || !(is_letter || is_digit || c == ' ' || c == '_' || c == '\\'))
      return false;
  }
  return true;
}

/// The defined terms of Patient Position (PS3.3, C.7.3.1.1.2), of animals as well.
bool is_position(const std::string& text) {
  static const std::set<std::string> kPositions = {
      "HFP",  "HFS",  "HFDR", "HFDL", "FFP",  "FFS",  "FFDR", "FFDL", "LFP", "LFS", "RFP",
      "RFS",  "AFP",  "AFS",  "AFDR", "AFDL", "PFP",  "PFS",  "PFDR", "PFDL"};
  return kPositions.contains(text);
}

/// Known units, and the defined terms of PET (PS3.3, C.8.9.1.1.3) and "unspecified".
bool is_unit(const std::string& text) {
  static const std::set<std::string> kTerms = {
      "US",   "CNTS", "NONE",    "CM2",       "CM2ML",  "PCNT", "CPS",
      "BQML", "GML",  "MGMINML", "UMOLMINML", "MLMING", "MLG",  "1CM",
      "MLML", "UMOLML",  "PROPCNTS",  "MLMINML", "STDDEV", "PROPCPS"};
  return kTerms.contains(text) || !known_value_unit(text).empty();
}

bool has_form(const DicomSet& data, const Attribute& attribute) {
  const std::string text = data.text(attribute.tag);
  switch (attribute.form) {
    case Form::number: return !data.decimals(attribute.tag).empty();
    case Form::code: return is_code(text);
    case Form::position: return is_position(text);
    case Form::unit: return is_unit(text);
    case Form::setting: return true;
  }
  return false;
}

}  // namespace

JsonObject dicom_note(const DicomSet& data) {
  JsonObject kept;
  for (const Attribute& attribute : kAttributes) {
    const std::string text = data.text(attribute.tag);
    if (text.empty() || !has_form(data, attribute)) continue;
    if (attribute.form != Form::number) {
      kept.set(attribute.name, text);
      continue;
    }
    const std::vector<double> all = data.decimals(attribute.tag);
    if (all.size() == 1) kept.set(attribute.name, all.front());
    else if (all.size() <= kMaxNumbers) kept.set(attribute.name, all);
  }
  kept.sort_by_name();
  return kept;
}

bool is_dicom_metadata(const DicomSet& data, DicomTag tag) {
  const Attribute* attribute = attribute_of(tag);
  return attribute != nullptr && (data.text(tag).empty() || has_form(data, *attribute));
}

bool is_dicom_attribute(DicomTag tag) { return attribute_of(tag) != nullptr; }

}  // namespace octavo
