#include "octavo/io/source/axis_check.h"

#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(AxisCheck, ShearIsRejectedInEveryFormat) {
  const TempFolder folder;
  const std::vector<std::string> words = {"sheared", "axes x and y", "63.43495 degrees",
                                          "90 expected", "resample"};
  write_meta(folder.file("a.mha"), "TransformMatrix = 1 0.5 0 0 1 0 0 0 1");
  expect_rejected(folder.file("a.mha"), words);
  write_nrrd(folder.file("a.nrrd"), "space: LPS\nspace directions: (1,0.5,0) (0,1,0) (0,0,2)");
  expect_rejected(folder.file("a.nrrd"), words);
  NiftiSample sample;
  std::string nifti = nifti_header(sample) + std::string(48, '\1');
  nifti.replace(280, 32, bytes_of<float>({1, 0, 0, 0, 0.5F, 1, 0, 0}));
  nifti.replace(252, 2, std::string(2, '\0'));
  write_file(folder.file("a.nii"), nifti);
  expect_rejected(folder.file("a.nii"), words);
  for (const char* name : {"a.mha", "a.nrrd", "a.nii"}) {
    expect_rejected(folder.file(name), {"sheared"}, with_spacing(1, 1, 1));
  }
}

}  // namespace
}  // namespace octavo::testing
