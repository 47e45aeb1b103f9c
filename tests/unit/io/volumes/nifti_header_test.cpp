// What NIfTI headers say of place and size: forms that disagree, units, axes that are none.
#include "octavo/io/volumes/nifti_header.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

void expect_near(const Matrix3& found, const Matrix3& expected) {
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(found[i], expected[i], 1e-6) << i;
}

/// A NIfTI-1 file of 4 x 3 x 2 bytes with an sform of 2 x 3 x 4 mm at (10, 20, 30) and a qform.
struct Forms {
  std::array<float, 4> pixdim = {1, 2, 3, 4};  ///< [0] is the sign of the third axis
  std::array<float, 3> quaternion = {0, 0, 0};
  std::array<float, 3> offset = {10, 20, 30};
  std::int16_t qform = 1;
  char unit = 2;
};

std::string with_forms(const Forms& forms) {
  NiftiSample sample;
  sample.datatype = 2;
  sample.bits = 8;
  std::string h = nifti_header(sample);
  const auto put = [&](std::size_t at, const std::string& bytes) {
    h.replace(at, bytes.size(), bytes);
  };
  put(76, bytes_of<float>({forms.pixdim[0], forms.pixdim[1], forms.pixdim[2], forms.pixdim[3]}));
  put(252, bytes_of<std::int16_t>({forms.qform}));
  put(256, bytes_of<float>({forms.quaternion[0], forms.quaternion[1], forms.quaternion[2]}));
  put(268, bytes_of<float>({forms.offset[0], forms.offset[1], forms.offset[2]}));
  h[123] = forms.unit;
  return h + std::string(24, '\1');
}

TEST(NiftiHeader, FormsThatAgreeBringNoWarning) {
  const TempFolder folder;
  for (const Forms& forms : {Forms{}, Forms{.pixdim = {1, 2.001F, 3, 4}},
                             Forms{.offset = {10.005F, 20, 30}},
                             Forms{.quaternion = {0, 0, 0.0005F}}, Forms{.qform = 0}}) {
    write_file(folder.file("a.nii"), with_forms(forms));
    const auto source = open_source({folder.file("a.nii")}, {});
    EXPECT_TRUE(source->warnings().empty()) << with_hints(source->warnings());
  }
}

TEST(NiftiHeader, OfFormsThatDisagreeTheSformCountsAndBothAreReported) {
  const TempFolder folder;
  const std::vector<std::pair<Forms, std::vector<std::string>>> rows = {
      {Forms{.pixdim = {1, 2, 3, 4.01F}}, {"spacing 2, 3, 4 mm by the sform", "2, 3, 4.01 mm"}},
      {Forms{.offset = {10, 20.02F, 30}},
       {"origin -10, -20, 30 mm by the sform", "-10, -20.02, 30 mm by the qform"}},
      {Forms{.quaternion = {0, 0, 0.7071068F}}, {"axes 90", "degrees apart"}},
      {Forms{.pixdim = {-1, 2, 3, 4}}, {"axes 180"}},
      {Forms{.pixdim = {1, 5, 3, 4}, .offset = {0, 20, 30}}, {"spacing", "origin"}}};
  for (const auto& [forms, words] : rows) {
    write_file(folder.file("a.nii"), with_forms(forms));
    const auto source = open_source({folder.file("a.nii")}, {});
    EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{2, 3, 4}));
    EXPECT_EQ(source->description().geometry.origin_mm, (Point3{-10, -20, 30}));
    ASSERT_EQ(source->warnings().size(), 1U) << with_hints(source->warnings());
    for (const std::string& word : words) {
      EXPECT_TRUE(contains(source->warnings()[0], word)) << source->warnings()[0];
    }
    EXPECT_TRUE(contains(source->warnings()[0], "the sform is used"));
  }
}

TEST(NiftiHeader, LengthsAreInTheUnitOfTheHeader) {
  const TempFolder folder;
  const std::vector<std::pair<char, double>> rows = {{1, 1000}, {2, 1}, {3, 0.001}, {0, 1}, {5, 1}};
  for (const auto& [unit, mm] : rows) {
    // Bits 3 to 5 are the unit of time.
    write_file(folder.file("a.nii"), with_forms({.unit = static_cast<char>(unit | 8)}));
    const auto source = open_source({folder.file("a.nii")}, {});
    const Geometry& g = source->description().geometry;
    EXPECT_EQ(g.spacing_mm, (Point3{2 * mm, 3 * mm, 4 * mm}));
    EXPECT_EQ(g.origin_mm, (Point3{-10 * mm, -20 * mm, 30 * mm}));
    const bool is_told = contains(with_hints(source->warnings()), "millimeters are assumed");
    EXPECT_EQ(is_told, unit == 0 || unit == 5) << int{unit};
  }
}

/// A NIfTI-2 header with an sform.
std::string nifti_2(const std::string& voxels) {
  std::string h(544, '\0');
  const auto put = [&](std::size_t at, const std::string& bytes) {
    h.replace(at, bytes.size(), bytes);
  };
  put(0, bytes_of<std::int32_t>({540}));
  put(4, std::string("n+2\0\r\n\x1a\n", 8));
  put(12, bytes_of<std::int16_t>({2, 8}));
  put(16, bytes_of<std::int64_t>({3, 4, 3, 2, 1, 1, 1, 1}));
  put(104, bytes_of<double>({1, 2, 3, 4, 0, 0, 0, 0}));
  put(168, bytes_of<std::int64_t>({544}));
  put(176, bytes_of<double>({0.1, -3.7}));
  put(348, bytes_of<std::int32_t>({1}));
  put(400, bytes_of<double>({2, 0, 0, 10.1, 0, 3, 0, 20, 0, 0, 4, 30}));
  put(500, bytes_of<std::int32_t>({2}));
  return h + voxels;
}

TEST(NiftiHeader, OfVersion2IsReadInDoublePrecision) {
  const TempFolder folder;
  const std::string voxels = "abcdefghijklmnopqrstuvwx";
  write_file(folder.file("a.nii"), nifti_2(voxels));
  const auto source = open_source({folder.file("a.nii")}, {});
  EXPECT_EQ(source->description().geometry.origin_mm, (Point3{-10.1, -20, 30}));
  EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{2, 3, 4}));
  EXPECT_EQ(source->description().rescale, (Rescale{0.1, -3.7}));
  EXPECT_EQ(voxels_of(*source), voxels);
  EXPECT_TRUE(source->warnings().empty()) << with_hints(source->warnings());
}

TEST(NiftiHeader, OfSiblingsTheFileNamedIsRead) {
  const TempFolder folder;
  const std::string plain = with_forms({});
  const std::string other = with_forms({}).substr(0, 352) + std::string(24, '\7');
  write_file(folder.file("a.nii"), plain);
  write_file(folder.file("a.nii.gz"), gzip(other));
  write_file(folder.file("a.hdr"), "no header");
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.nii")}, {})), std::string(24, '\1'));
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.nii.gz")}, {})), std::string(24, '\7'));
}

struct Qform {
  std::array<float, 3> quaternion = {0, 0, 0};
  std::vector<float> pixdim = {1, 1, 1, 2};
  bool has_sform = false;
};

/// A NIfTI-1 header of mm and a qform.
std::string with_qform(const Qform& qform) {
  NiftiSample sample;
  std::string h = nifti_header(sample);
  h.replace(76, 16, bytes_of(qform.pixdim));
  h.replace(252, 2, bytes_of<std::int16_t>({1}));
  if (!qform.has_sform) h.replace(254, 2, std::string(2, '\0'));
  h.replace(256, 12, bytes_of<float>({qform.quaternion[0], qform.quaternion[1],
                                      qform.quaternion[2]}));
  return h + std::string(48, '\1');
}

TEST(NiftiHeader, AQuaternionThatIsNoRotationIsRejected) {
  const TempFolder folder;
  const std::string path = folder.file("a.nii");
  for (const Qform& qform : {Qform{{0, 0, 1.1F}}, Qform{{0.8F, 0.8F, 0}}, Qform{{0, 0, -1.0001F}},
                             Qform{{0, 0, std::numeric_limits<float>::quiet_NaN()}}}) {
    write_file(path, with_qform(qform));
    expect_rejected(path, {"qform", "b^2 + c^2 + d^2", "at most 1 expected"});
  }
  write_file(path, with_qform({{0, 0, 1.1F}}));
  expect_rejected(path, {"is 1.21,"});
}

TEST(NiftiHeader, AQuaternionThatRoundingMadeTooLongIsTakenForAUnitOne) {
  const TempFolder folder;
  const std::string path = folder.file("a.nii");
  write_file(path, with_qform({{0, 0, 1.000004F}}));
  const Geometry g = geometry_of(path);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(g.spacing_mm[axis], axis == 2 ? 2 : 1, 1e-12);
  }
  expect_near(g.direction, {1, 0, 0, 0, 1, 0, 0, 0, 1});
}

TEST(NiftiHeader, TheSformCountsAlsoWhereTheQformIsNoRotation) {
  const TempFolder folder;
  const std::string path = folder.file("a.nii");
  write_file(path, with_qform({{0, 0, 1.1F}, {1, 2, 3, 4}, true}));
  const auto source = open_source({path}, {});
  EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{2, 3, 4}));
  EXPECT_TRUE(contains(with_hints(source->warnings()), "is no rotation): the sform is used"));
}

TEST(NiftiHeader, TheAxesOfAQformStayWhereItsSpacingIsMissing) {
  const TempFolder folder;
  const std::string path = folder.file("a.nii");
  std::string bytes = with_qform({{0, 0, 1}, {1, 0.5F, 0.5F, 0}});
  write_file(path, bytes);
  expect_rejected(path, {"[spacing_mm]"});
  const Geometry given = geometry_of(path, with_spacing(1, 1, 3));
  EXPECT_EQ(given.spacing_mm, (Point3{1, 1, 3}));
  expect_near(given.direction, {1, 0, 0, 0, 1, 0, 0, 0, 1});
  // Of two dimensions: the third has no spacing to miss.
  bytes.replace(40, 8, bytes_of<std::int16_t>({2, 4, 6, 1}));
  write_file(path, bytes);
  EXPECT_EQ(geometry_of(path).spacing_mm, (Point3{0.5, 0.5, 1}));
  EXPECT_EQ(geometry_of(path, with_spacing(1, 1, 3)).spacing_mm, (Point3{1, 1, 3}));
}

/// An sform that says nothing, in a file of 2 x 3 x 4 mm.
std::string with_sform(const std::array<float, 12>& sform, bool has_qform) {
  Forms forms;
  forms.qform = has_qform ? 1 : 0;
  std::string bytes = with_forms(forms);
  for (std::size_t i = 0; i < sform.size(); ++i) {
    bytes.replace(280 + 4 * i, 4, bytes_of<float>({sform[i]}));
  }
  return bytes;
}

TEST(NiftiHeader, ASformThatSaysNothingGivesWayToTheQformOrTheSpacing) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const TempFolder folder;
  const std::string path = folder.file("a.nii");
  struct Case {
    std::array<float, 12> sform;
    std::string fault;
  };
  for (const Case& one :
       {Case{{}, "is all zeros"}, Case{{0, 0, 0, 10, 0, 0, 0, 20, 0, 0, 0, 30}, "is all zeros"},
        Case{{2, 0, 0, 10, 0, kNan, 0, 20, 0, 0, 4, 30}, "has numbers that are not finite"},
        Case{{2, 0, 0, kInfinity, 0, 3, 0, 20, 0, 0, 4, 30}, "has numbers that are not finite"}}) {
    write_file(path, with_sform(one.sform, true));
    auto source = open_source({path}, {});
    EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{2, 3, 4}));
    EXPECT_EQ(source->description().geometry.origin_mm, (Point3{-10, -20, 30}));
    std::string warnings = with_hints(source->warnings());
    EXPECT_TRUE(contains(warnings, "the sform of the header " + one.fault + ": it is not used"));
    EXPECT_FALSE(contains(warnings, "sheared")) << warnings;

    write_file(path, with_sform(one.sform, false));
    source = open_source({path}, {});
    EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{2, 3, 4}));
    EXPECT_EQ(source->description().geometry.origin_mm, (Point3{0, 0, 0}));
    warnings = with_hints(source->warnings());
    EXPECT_TRUE(contains(warnings, one.fault + ": it is not used")) << warnings;
    EXPECT_TRUE(contains(warnings, "does not say where left and right are")) << warnings;
    EXPECT_TRUE(contains(source->description().metadata.text(), "\"place_known\":false"))
        << source->description().metadata.text();
  }
  // An axis without a length beside others that have one is a fault.
  write_file(path, with_sform({2, 0, 0, 10, 0, 0, 0, 20, 0, 0, 4, 30}, false));
  expect_rejected(path, {"axis y no length", "repair the header"});
}

TEST(NiftiHeader, ASformOfTwoDimensionsGetsTheNormalOfItsPlane) {
  const TempFolder folder;
  const std::string path = folder.file("a.nii");
  NiftiSample sample;
  std::string bytes = nifti_header(sample) + std::string(48, '\1');
  bytes.replace(252, 2, std::string(2, '\0'));
  bytes.replace(280, 48, bytes_of<float>({0, 2, 0, 5, 3, 0, 0, 6, 0, 0, 0, 7}));
  write_file(path, bytes);
  expect_rejected(path, {"axis z no length", "repair the header"});
  bytes.replace(40, 8, bytes_of<std::int16_t>({2, 4, 6, 1}));
  write_file(path, bytes);
  const Geometry g = geometry_of(path);
  EXPECT_EQ(g.spacing_mm, (Point3{3, 2, 1}));
  expect_near(g.direction, {0, -1, 0, -1, 0, 0, 0, 0, -1});
}

}  // namespace
}  // namespace octavo::testing
