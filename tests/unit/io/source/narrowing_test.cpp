#include "octavo/io/source/narrowing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

constexpr double kTooLarge = 1e39;  // beyond float32

/// 4 x 3 voxels a plane, counted from `start` on.
template <class T>
std::vector<T> counted_numbers(std::size_t count, T start) {
  std::vector<T> numbers(count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = start + static_cast<T>(i);
  return numbers;
}

/// A source of raw planes of 4 x 3 numbers.
template <class T>
class RawNumbers {
 public:
  RawNumbers(const std::string& type, const std::vector<T>& numbers) {
    write_file(path_, bytes_of(numbers));
    options_.raw =
        parse_raw_layout("4,3," + std::to_string(numbers.size() / 12) + "," + type);
  }

  std::unique_ptr<PlaneSource> open() const { return open_source({path_}, options_); }
  void expect_rejected(const std::vector<std::string>& words) const {
    octavo::testing::expect_rejected(path_, words, options_);
  }

 private:
  TempFolder folder_;
  std::string path_ = folder_.file("a.raw");
  SourceOptions options_;
};

template <class Stored, class Voxel>
void expect_voxels(const std::string& type, const std::vector<Stored>& numbers, VoxelType expected,
                   std::size_t warnings = 0) {
  const auto source = RawNumbers<Stored>(type, numbers).open();
  EXPECT_EQ(source->description().type, expected);
  std::vector<Voxel> voxels;
  for (const Stored number : numbers) voxels.push_back(static_cast<Voxel>(number));
  EXPECT_EQ(voxels_of(*source), bytes_of(voxels));
  // The first warning says that raw voxels have no spacing.
  EXPECT_EQ(source->warnings().size(), 1 + warnings);
}

TEST(Narrowing, WholeNumbersBecomeTheIntegersThatHoldThem) {
  constexpr std::int64_t kMin = std::numeric_limits<std::int32_t>::min();
  constexpr std::int64_t kMax = std::numeric_limits<std::int32_t>::max();
  std::vector<std::int64_t> numbers = counted_numbers<std::int64_t>(24, -5);
  numbers[0] = kMin;
  numbers[23] = kMax;
  expect_voxels<std::int64_t, std::int32_t>("int64", numbers, VoxelType::int32);
  numbers = counted_numbers<std::int64_t>(24, 0);
  numbers[20] = 4294967295;
  expect_voxels<std::int64_t, std::uint32_t>("int64", numbers, VoxelType::uint32);
  expect_voxels<std::uint64_t, std::uint32_t>("uint64", counted_numbers<std::uint64_t>(24, 0),
                                              VoxelType::uint32);
  expect_voxels<double, std::int32_t>("float64", counted_numbers(24, -1000.0), VoxelType::int32);
  std::vector<double> large = counted_numbers(24, 0.0);
  large[3] = 4294967295.0;
  expect_voxels<double, std::uint32_t>("f64", large, VoxelType::uint32);
}

TEST(Narrowing, FractionsBecomeFloat32AndAWarningTellsWhereTheyAreRounded) {
  std::vector<double> numbers = counted_numbers(24, 0.5);
  numbers[7] = std::nan("");
  numbers[8] = -std::numeric_limits<double>::infinity();
  expect_voxels<double, float>("float64", numbers, VoxelType::float32);
  numbers[23] = 0.1;
  expect_voxels<double, float>("float64", numbers, VoxelType::float32, 1);
  numbers[23] = 1e10 + 1;
  expect_voxels<double, float>("float64", numbers, VoxelType::float32, 1);
}

TEST(Narrowing, BothByteOrdersAreRead) {
  const TempFolder folder;
  SourceOptions options;
  options.raw = parse_raw_layout("4,3,2,float64:be");
  const std::vector<double> numbers = counted_numbers(24, 0.25);
  write_file(folder.file("all"), bytes_of(numbers, true));
  const std::string expected =
      bytes_of(std::vector<float>(numbers.begin(), numbers.end()));
  EXPECT_EQ(voxels_of(*open_source({folder.file("all")}, options)), expected);
  const std::string bytes = bytes_of(numbers, true);
  write_file(folder.file("planes/z9"), bytes.substr(0, 96));
  write_file(folder.file("planes/z10"), bytes.substr(96));
  EXPECT_EQ(voxels_of(*open_source({folder.file("planes")}, options)), expected);
}

TEST(Narrowing, TheFirstValueThatDoesNotFitIsNamedWithItsPlace) {
  std::vector<std::int64_t> labels = counted_numbers<std::int64_t>(24, -1);
  labels[17] = 2147483648;
  labels[20] = -2147483649;
  RawNumbers<std::int64_t>("int64", labels)
      .expect_rejected({"2147483648 at x,y,z = 1,1,1", "int32", "int64"});
  std::vector<std::uint64_t> ids = counted_numbers<std::uint64_t>(24, 1);
  ids[0] = std::numeric_limits<std::uint64_t>::max();
  RawNumbers<std::uint64_t>("uint64", ids)
      .expect_rejected({"18446744073709551615 at x,y,z = 0,0,0", "uint32"});
  std::vector<double> numbers = counted_numbers(24, 0.1);
  numbers[13] = -kTooLarge;
  RawNumbers<double>("float64", numbers).expect_rejected({"-1e+39 at x,y,z = 1,0,1", "float32"});
}

TEST(Narrowing, WhatRoundsToTheLargestFloatIsTaken) {
  std::vector<double> numbers = counted_numbers(24, 0.1);
  numbers[13] = 3.40282351e38;
  const std::string voxels = voxels_of(*RawNumbers<double>("float64", numbers).open());
  float voxel = 0;
  std::memcpy(&voxel, voxels.data() + 13 * sizeof voxel, sizeof voxel);
  EXPECT_EQ(voxel, std::numeric_limits<float>::max());
  numbers[13] = 0x1.ffffffp127;
  RawNumbers<double>("float64", numbers).expect_rejected({"at x,y,z = 1,0,1", "float32"});
}

/// 40 planes of 4 x 3 numbers, all of them telling.
std::vector<double> many_planes() { return counted_numbers(40 * 12, 0.0); }

TEST(Narrowing, TheFirstPlanesThatTellChooseTheType) {
  // A border of one value tells nothing; a volume made by interpolation between whole planes does
  // so in its second one.
  std::vector<double> numbers(40 * 12, 0.0);
  numbers[39 * 12] = 0.5;
  expect_voxels<double, float>("float64", numbers, VoxelType::float32);
  numbers = many_planes();
  numbers[13] = 0.5;
  expect_voxels<double, float>("float64", numbers, VoxelType::float32);
  // The type stands once it is chosen.
  numbers = many_planes();
  numbers[35 * 12 + 6] = 0.5;
  RawNumbers<double>("float64", numbers)
      .expect_rejected({"0.5 at x,y,z = 2,1,35", "int32", "convert it to float32 first"});
  numbers = many_planes();
  numbers[0] = 0.5;
  numbers[36 * 12] = 0.1;
  RawNumbers<double>("float64", numbers)
      .expect_rejected({"0.1 at x,y,z = 0,0,36", "float32", "convert it to float32 first"});
}

TEST(Narrowing, NanAndInfinityBehindWholeNumbersAreSaidToComeLate) {
  for (const double late : {std::nan(""), -std::numeric_limits<double>::infinity()}) {
    std::vector<double> numbers = many_planes();
    numbers[39 * 12 + 5] = late;
    RawNumbers<double>("float64", numbers)
        .expect_rejected({"at x,y,z = 1,1,39", "int32", "by what the first planes hold",
                          "convert it to float32 first"});
  }
}

TEST(Narrowing, ValuesThatFloat32HasNothingForAreRejected) {
  std::vector<double> numbers = counted_numbers(24, 1.0);
  for (double& number : numbers) number *= 1e-50;
  numbers[3] = std::nan("");
  RawNumbers<double>("float64", numbers).expect_rejected({"2.4e-49", "float32", "scale them"});
  // Beside larger ones they are within the loss that the warning tells.
  numbers[4] = 0.1;
  const auto source = RawNumbers<double>("float64", numbers).open();
  ASSERT_EQ(source->warnings().size(), 2U);
  EXPECT_NE(source->warnings()[1].text.find("nearer to 0 than 1.2e-38 by 7.1e-46 at most"),
            std::string::npos);
  EXPECT_EQ(voxels_of(*source).substr(0, 12), std::string(12, '\0'));
}

TEST(Narrowing, MinusZeroIsZero) {
  const auto source = RawNumbers<double>("float64", std::vector<double>(12, -0.0)).open();
  EXPECT_EQ(source->description().type, VoxelType::int32);
  EXPECT_EQ(voxels_of(*source), std::string(48, '\0'));
  std::vector<double> numbers(12, -0.0);
  numbers[5] = 0.1;
  numbers[6] = -1e-60;  // rounds to it
  const std::string voxels = voxels_of(*RawNumbers<double>("float64", numbers).open());
  EXPECT_EQ(voxels.substr(0, 20) + voxels.substr(24), std::string(44, '\0'));
}

/// The numbers of a file of every format that has them, in either byte order.
struct WideFile {
  const char* name;
  bool big_endian;
  std::string (*header)(const std::string& type);
  const char* int64;    ///< the format's names of the types; null where it has none
  const char* uint64;
  const char* float64;
};

std::string nrrd_of(const std::string& type) {
  return "NRRD0004\ntype: " + type +
         "\ndimension: 3\nsizes: 4 3 2\nendian: big\nencoding: raw\nspacings: 1 1 1\n\n";
}
std::string meta_of(const std::string& type) {
  return "NDims = 3\nDimSize = 4 3 2\nElementSpacing = 1 1 1\nElementType = " + type +
         "\nElementByteOrderMSB = False\nElementDataFile = LOCAL\n";
}
std::string vtk_of(const std::string& type) {
  return "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\n"
         "SPACING 1 1 1\nPOINT_DATA 24\nSCALARS s " + type + "\nLOOKUP_TABLE default\n";
}
std::string nifti_of(const std::string& type) {
  NiftiSample sample;
  sample.datatype = static_cast<std::int16_t>(std::stoi(type));
  sample.bits = 64;
  sample.big_endian = true;
  return nifti_header(sample);
}
std::string gipl_of(const std::string& type) {
  return bytes_of<std::uint16_t>({4, 3, 2, 1, static_cast<std::uint16_t>(std::stoi(type))}, true) +
         bytes_of<float>({1, 1, 1, 1}, true) + std::string(226, '\0') +
         bytes_of<std::uint32_t>({719555000}, true);
}

const WideFile kFiles[] = {
    {"a.nrrd", true, nrrd_of, "int64", "uint64", "double"},
    {"a.mha", false, meta_of, "MET_LONG_LONG", "MET_ULONG_LONG", "MET_DOUBLE"},
    {"a.vtk", true, vtk_of, "vtktypeint64", "unsigned_long", "double"},
    {"a.nii", true, nifti_of, "1024", "1280", "64"},
    {"a.nii.gz", true, nifti_of, "1024", "1280", "64"},
    {"a.gipl", true, gipl_of, nullptr, nullptr, "65"},
};

template <class Stored, class Voxel>
void expect_read(const WideFile& file, const char* type, const std::vector<Stored>& numbers) {
  if (type == nullptr) return;
  SCOPED_TRACE(std::string(file.name) + " " + type);
  const TempFolder folder;
  const std::string bytes = file.header(type) + bytes_of(numbers, file.big_endian);
  const bool is_deflated = std::string(file.name).ends_with(".gz");
  write_file(folder.file(file.name), is_deflated ? gzip(bytes) : bytes);
  const auto source = open_source({folder.file(file.name)}, {});
  EXPECT_EQ(source->description().type, voxel_type_of<Voxel>());
  EXPECT_EQ(voxels_of(*source), bytes_of(std::vector<Voxel>(numbers.begin(), numbers.end())));
  if (is_deflated) return;
  write_file(folder.file(file.name), bytes.substr(0, bytes.size() - 1));
  EXPECT_EQ(source_error({folder.file(file.name)}).kind(), ErrorKind::source_rejected);
}

TEST(Narrowing, EveryFormatOfWideNumbersIsRead) {
  for (const WideFile& file : kFiles) {
    expect_read<std::int64_t, std::int32_t>(file, file.int64,
                                            counted_numbers<std::int64_t>(24, -7));
    expect_read<std::uint64_t, std::uint32_t>(file, file.uint64,
                                              counted_numbers<std::uint64_t>(24, 3000000000));
    expect_read<double, float>(file, file.float64, counted_numbers(24, 0.75));
  }
}

TEST(Narrowing, TiffPagesAndVtkTextAreRead) {
  const TempFolder folder;
  const std::vector<std::int64_t> numbers = counted_numbers<std::int64_t>(24, -7);
  const std::string voxels = bytes_of(std::vector<std::int32_t>(numbers.begin(), numbers.end()));
  TiffSample sample;
  sample.bits = 64;
  sample.format = 2;
  sample.pages = {bytes_of(numbers).substr(0, 96), bytes_of(numbers).substr(96)};
  write_tiff(folder.file("a.tif"), sample);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), voxels);
  std::string text = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n"
                     "DIMENSIONS 4 3 2\nPOINT_DATA 24\nSCALARS s double\nLOOKUP_TABLE default\n";
  for (const std::int64_t number : numbers) text += std::to_string(number) + ".0\n";
  write_file(folder.file("a.vtk"), text);
  const auto source = open_source({folder.file("a.vtk")}, {});
  EXPECT_EQ(source->description().type, VoxelType::int32);
  EXPECT_EQ(voxels_of(*source), voxels);
}

TEST(Narrowing, ALabelIntentOfWholeNumbersMakesLabels) {
  const TempFolder folder;
  NiftiSample sample;
  sample.datatype = 64;
  sample.intent = 1002;
  for (const double start : {0.0, 0.5}) {
    write_file(folder.file("a.nii"), nifti_header(sample) + bytes_of(counted_numbers(24, start)));
    EXPECT_EQ(open_source({folder.file("a.nii")}, {})->description().kind,
              start == 0 ? VolumeKind::labels : VolumeKind::grey);
  }
}

}  // namespace
}  // namespace octavo::testing
