#include "octavo/io/dicom/dicom_values.h"

#include <gtest/gtest.h>

#include <tuple>

#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(DicomValues, OfADoseHaveNoOtherScaleBesideItsOwn) {
  const TempFolder folder;
  const std::string path = folder.file("a.dcm");
  const auto write = [&](const std::string& slope, const std::string& intercept) {
    DicomElements elements = ct_elements(5, 3, 8);
    elements.set(0x00080060, "CS", "RTDOSE");
    elements.set(0x3004000e, "DS", "0.001");
    elements.set(kSlope, "DS", slope);
    elements.set(kIntercept, "DS", intercept);
    elements.write(path, kExplicitLittle);
  };
  for (const auto& [slope, intercept] : std::vector<std::pair<const char*, const char*>>{
           {"2", "0"}, {"1", "5"}, {"0.001", "5"}}) {
    write(slope, intercept);
    expect_rejected(path, {"Dose Grid Scaling (3004,000e)", "Rescale Slope (0028,1053)",
                           "contradict each other"});
  }
  for (const char* slope : {"1", "0.001"}) {
    write(slope, "0");
    EXPECT_EQ(open_source({path}, {})->description().rescale, (Rescale{0.001, 0}));
  }
}

TEST(DicomValues, OfACtAreInHounsfieldUnitsWhereThereIsARescale) {
  const TempFolder folder;
  for (const auto& [slope, intercept, unit] :
       {std::tuple{"1", "", "[hnsf'U]"}, {"", "0", "[hnsf'U]"}, {"", "", ""}}) {
    DicomElements elements = ct_elements(5, 3, 8);
    elements.set(kSlope, "DS", slope);
    elements.set(kIntercept, "DS", intercept);
    const std::string path = folder.file("a.dcm");
    elements.write(path, kExplicitLittle);
    EXPECT_EQ(open_source({path}, {})->description().metadata.unit(), unit)
        << "slope '" << slope << "', intercept '" << intercept << "'";
  }
}

}  // namespace
}  // namespace octavo::testing
