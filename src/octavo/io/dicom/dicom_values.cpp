#include "octavo/io/dicom/dicom_values.h"

#include "octavo/core/error.h"
#include "octavo/io/dicom/dicom_tags.h"
#include "octavo/io/source/value_unit.h"

namespace octavo {

namespace {

constexpr DicomTag kModality = 0x00080060;
constexpr DicomTag kRescaleType = 0x00281054;
constexpr DicomTag kModalityTable = 0x00283000;
constexpr DicomTag kPetUnits = 0x00541001;
constexpr DicomTag kDoseUnits = 0x30040002;

/// The number of a header, or `absent` where it is not there or blank. Notes a fault where it is
/// no number.
double number_or(const DicomSet& set, DicomTag tag, const char* name, double absent,
                 std::string& fault) {
  const std::string text = set.text(tag);
  if (text.empty()) return absent;
  const std::vector<double> numbers = set.decimals(tag);
  if (numbers.size() == 1) return numbers.front();
  fault = std::string(name) + " " + dicom_tag_text(tag) + " is \"" + escaped(text) +
          "\", which is not one number: what the voxels mean is not known; correct it in the "
          "file, or export the series again";
  return absent;
}

/// set  what holds Rescale Slope, Intercept and Type of `data`
std::string unit_of(const DicomSet& data, const DicomSet& set) {
  if (const std::string type = set.text(kRescaleType); !type.empty()) {
    return known_value_unit(type);
  }
  if (data.text(kModality) == "PT") {
    const std::string units = data.text(kPetUnits);
    if (units == "GML") return known_value_unit("g/ml");
    return known_value_unit(units == "CNTS" ? "counts" : units);
  }
  // Without a rescale the numbers of a CT may be anything.
  const bool is_rescaled =
      !set.text(kRescaleSlope).empty() || !set.text(kRescaleIntercept).empty();
  return data.text(kModality) == "CT" && is_rescaled ? "HU" : "";
}

DicomValues dose_values(const DicomSet& data) {
  DicomValues values;
  values.rescale.slope = number_or(data, kDoseScaling, "Dose Grid Scaling", 0, values.fault);
  if (values.fault.empty() && values.rescale.slope == 0) {
    values.fault = "a dose (RTDOSE) whose Dose Grid Scaling " + dicom_tag_text(kDoseScaling) +
                   " is missing or 0: what the voxels mean is not known; export it again";
  }
  const double slope = number_or(data, kRescaleSlope, "Rescale Slope", 1, values.fault);
  const double intercept = number_or(data, kRescaleIntercept, "Rescale Intercept", 0, values.fault);
  if (values.fault.empty() && ((slope != 1 && slope != values.rescale.slope) || intercept != 0)) {
    values.fault = "Dose Grid Scaling " + dicom_tag_text(kDoseScaling) + " and Rescale Slope " +
                   dicom_tag_text(kRescaleSlope) + " with its intercept contradict each other: "
                   "what the voxels mean is not known; export the dose again";
  }
  if (data.text(kDoseUnits) == "GY") values.unit = known_value_unit("Gy");
  return values;
}

}  // namespace

DicomValues read_dicom_values(const DicomSet& data, const DicomSet* transformation) {
  if (data.text(kModality) == "RTDOSE") return dose_values(data);
  const DicomSet& set = transformation == nullptr ? data : *transformation;
  DicomValues values;
  values.rescale.slope = number_or(set, kRescaleSlope, "Rescale Slope", 1, values.fault);
  values.rescale.intercept =
      number_or(set, kRescaleIntercept, "Rescale Intercept", 0, values.fault);
  values.unit = unit_of(data, set);
  if (!data.items(kModalityTable).empty()) {
    values.fault = "its values go through a table (Modality LUT Sequence " +
                   dicom_tag_text(kModalityTable) +
                   "), which is not applied: without it they mean nothing; convert the file with "
                   "a program that applies the table, or export it with a Rescale Slope";
  }
  return values;
}

}  // namespace octavo
