// What headers say of place and size: forms that disagree, units of length, spacings that are
// missing.
#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

std::string all_of(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += text + "\n";
  return all;
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

TEST(SourceGeometry, OfFormsThatAgreeBringsNoWarning) {
  const TempFolder folder;
  for (const Forms& forms : {Forms{}, Forms{.pixdim = {1, 2.001F, 3, 4}},
                             Forms{.offset = {10.005F, 20, 30}},
                             Forms{.quaternion = {0, 0, 0.0005F}}, Forms{.qform = 0}}) {
    write_file(folder.file("a.nii"), with_forms(forms));
    const auto source = open_source({folder.file("a.nii")}, {});
    EXPECT_TRUE(source->warnings().empty()) << all_of(source->warnings());
  }
}

TEST(SourceGeometry, OfFormsThatDisagreeIsThatOfTheSformAndBothAreTold) {
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
    ASSERT_EQ(source->warnings().size(), 1U) << all_of(source->warnings());
    for (const std::string& word : words) {
      EXPECT_TRUE(contains(source->warnings()[0], word)) << source->warnings()[0];
    }
    EXPECT_TRUE(contains(source->warnings()[0], "the sform is used"));
  }
}

TEST(SourceGeometry, OfNiftiIsInTheUnitOfItsHeader) {
  const TempFolder folder;
  const std::vector<std::pair<char, double>> rows = {{1, 1000}, {2, 1}, {3, 0.001}, {0, 1}, {5, 1}};
  for (const auto& [unit, mm] : rows) {
    // Bits 3 to 5 are the unit of time.
    write_file(folder.file("a.nii"), with_forms({.unit = static_cast<char>(unit | 8)}));
    const auto source = open_source({folder.file("a.nii")}, {});
    const Geometry& g = source->description().geometry;
    EXPECT_EQ(g.spacing_mm, (Point3{2 * mm, 3 * mm, 4 * mm}));
    EXPECT_EQ(g.origin_mm, (Point3{-10 * mm, -20 * mm, 30 * mm}));
    const bool is_told = contains(all_of(source->warnings()), "millimeters are assumed");
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

TEST(SourceGeometry, OfNifti2IsReadInDoublePrecision) {
  const TempFolder folder;
  const std::string voxels = "abcdefghijklmnopqrstuvwx";
  write_file(folder.file("a.nii"), nifti_2(voxels));
  const auto source = open_source({folder.file("a.nii")}, {});
  EXPECT_EQ(source->description().geometry.origin_mm, (Point3{-10.1, -20, 30}));
  EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{2, 3, 4}));
  EXPECT_EQ(source->description().rescale, (Rescale{0.1, -3.7}));
  EXPECT_EQ(voxels_of(*source), voxels);
  EXPECT_TRUE(source->warnings().empty()) << all_of(source->warnings());
}

TEST(SourceGeometry, OfSiblingsIsThatOfTheFileNamed) {
  const TempFolder folder;
  const std::string plain = with_forms({});
  const std::string other = with_forms({}).substr(0, 352) + std::string(24, '\7');
  write_file(folder.file("a.nii"), plain);
  write_file(folder.file("a.nii.gz"), gzip(other));
  write_file(folder.file("a.hdr"), "no header");
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.nii")}, {})), std::string(24, '\1'));
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.nii.gz")}, {})), std::string(24, '\7'));
}

Point3 spacing_of(const std::string& path) {
  return open_source({path}, {})->description().geometry.spacing_mm;
}

TEST(SourceGeometry, OfNrrdIsInTheUnitsOfItsHeader) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  const auto write = [&](const std::string& lines) {
    write_file(path, "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n" + lines +
                         "\n" + std::string(24, '\1'));
  };
  const std::string axes =
      "space: left-posterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"
      "space origin: (10,20,30)\n";
  for (const auto& [unit, mm] : std::vector<std::pair<std::string, double>>{
           {"mm", 1}, {"um", 1e-3}, {"\xc2\xb5m", 1e-3}, {"microns", 1e-3}, {"cm", 10},
           {"m", 1000}, {"", 1}}) {
    const std::string quoted = "\"" + unit + "\" ";
    write(axes + "space units: " + quoted + quoted + quoted + "\n");
    EXPECT_EQ(spacing_of(path), (Point3{2 * mm, 3 * mm, 4 * mm})) << unit;
    EXPECT_DOUBLE_EQ(open_source({path}, {})->description().geometry.origin_mm[2], 30 * mm);
    write("spacings: 2 3 4\nunits: " + quoted + quoted + quoted + "\n");
    EXPECT_EQ(spacing_of(path), (Point3{2 * mm, 3 * mm, 4 * mm})) << unit;
  }
  for (const std::string& lines : {axes + "space units: \"furlong\" \"mm\" \"mm\"\n",
                                  std::string("spacings: 2 3 4\nunits: \"pixel\" \"mm\" \"mm\"\n"),
                                  axes + "space units: \"mm\" \"mm\"\n"}) {
    write(lines);
    const Error error = source_error({path});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_TRUE(contains(error.what(), "units")) << error.what();
  }
  write("spacings: 2 3 4\nunits: \"pixel\" \"pixel\" \"mm\"\n");
  SourceOptions options;
  options.spacing_mm = Point3{5, 6, 7};
  EXPECT_EQ(open_source({path}, options)->description().geometry.spacing_mm, (Point3{5, 6, 7}));
}

TEST(SourceGeometry, OfMetaImageIsInTheUnitOfItsHeader) {
  const TempFolder folder;
  const std::string path = folder.file("a.mha");
  const auto write = [&](const std::string& unit) {
    write_file(path, "NDims = 3\nDimSize = 4 3 2\nElementSpacing = 2 3 4\nOffset = 10 20 30\n" +
                         (unit.empty() ? "" : "DistanceUnits = " + unit + "\n") +
                         "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
                         std::string(24, '\1'));
  };
  for (const auto& [unit, mm] : std::vector<std::pair<std::string, double>>{
           {"", 1}, {"?", 1}, {"mm", 1}, {"um", 1e-3}, {"cm", 10}}) {
    write(unit);
    EXPECT_EQ(spacing_of(path), (Point3{2 * mm, 3 * mm, 4 * mm})) << unit;
    EXPECT_DOUBLE_EQ(open_source({path}, {})->description().geometry.origin_mm[2], 30 * mm);
  }
  write("parsec");
  EXPECT_TRUE(contains(source_error({path}).what(), "parsec"));
}

/// What stands in the metadata under "spacing_source".
std::string spacing_source(PlaneSource& source) {
  const std::string& metadata = source.description().metadata_json;
  for (const char* kind : {"file", "user", "assumed"}) {
    if (contains(metadata, std::string("\"spacing_source\":\"") + kind + "\"")) return kind;
  }
  return "nothing";
}

TEST(SourceGeometry, ThatIsMissingIsToldAskedForAndRecordedInEveryFormat) {
  const TempFolder folder;
  const std::string voxels(24, '\1');
  std::string nifti = with_forms({.pixdim = {0, 0, 0, 0}, .qform = 0});
  nifti.replace(254, 2, std::string(2, '\0'));
  write_file(folder.file("a.nii"), nifti);
  write_file(folder.file("a.nrrd"),
             "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n\n" + voxels);
  write_file(folder.file("nan.nrrd"),
             "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n"
             "spacings: nan nan nan\n\n" + voxels);
  write_file(folder.file("a.mha"), "NDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\n"
                                   "ElementDataFile = LOCAL\n" + voxels);
  TiffSample tiff;
  tiff.pages = {std::string(12, '\1'), std::string(12, '\1')};
  write_tiff(folder.file("a.tif"), tiff);
  write_png(folder.file("png/1.png"), 4, 3, 8, 0, std::string(12, '\1'));
  write_png(folder.file("png/2.png"), 4, 3, 8, 0, std::string(12, '\1'));
  write_file(folder.file("a.raw"), voxels);
  for (const char* name : {"a.nii", "a.nrrd", "nan.nrrd", "a.mha", "a.tif", "png", "a.raw"}) {
    SCOPED_TRACE(name);
    SourceOptions options;
    if (std::string(name) == "a.raw") options.raw = parse_raw_layout("4,3,2,uint8");
    const auto assumed = open_source({folder.file(name)}, options);
    EXPECT_EQ(spacing_source(*assumed), "assumed");
    EXPECT_TRUE(contains(all_of(assumed->warnings()),
                         "spacing is not in the files: 1 mm assumed; give --spacing"));
    EXPECT_EQ(assumed->description().geometry.spacing_mm, (Point3{1, 1, 1}));
    options.spacing_mm = Point3{0.5, 0.6, 0.7};
    const auto given = open_source({folder.file(name)}, options);
    EXPECT_EQ(spacing_source(*given), "user");
    EXPECT_FALSE(contains(all_of(given->warnings()), "assumed; give"));
    EXPECT_EQ(given->description().geometry.spacing_mm, (Point3{0.5, 0.6, 0.7}));
  }
  DicomSample slice;
  write_dicom(folder.file("a.dcm"), slice);
  EXPECT_TRUE(contains(source_error({folder.file("a.dcm")}).what(), "give --spacing"));
  slice.position = "0\\0\\0";
  write_dicom(folder.file("a.dcm"), slice);
  EXPECT_EQ(spacing_source(*open_source({folder.file("a.dcm")}, {})), "file");
}

}  // namespace
}  // namespace octavo::testing
