// The shared volumes against the digests and geometry that other readers found, and the awkward
// ones against what a good reader does with each.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "octavo/io/source/prefetch_source.h"
#include "support/sha256.h"
#include "support/shared_data.h"
#include "support/source_files.h"
#include "support/volume_readers.h"

namespace octavo::testing {
namespace {

std::string digest_of(PlaneSource& source) {
  const VolumeDescription& d = source.description();
  std::vector<std::byte> plane(
      static_cast<std::size_t>(d.size.x * d.size.y * bytes_per_voxel(d.type)));
  Sha256 digest;
  for (std::int64_t z = 0; z < d.size.z; ++z) {
    source.read_plane(plane);
    digest.add(plane);
  }
  return digest.finish();
}

TEST(SourceShared, StoredVoxelsAreThoseOtherReadersFound) {
  const auto root = shared_data();
  if (!root) GTEST_SKIP() << missing_shared_file("REFERENCE.json");
  std::ifstream file(*root / "REFERENCE.json");
  const nlohmann::json reference = nlohmann::json::parse(file);
  EXPECT_GE(reference.size(), 10U);
  for (const auto& [name, expected] : reference.items()) {
    const auto source = make_prefetch_source(open_source({(*root / name).string()}, {}), {});
    const VolumeDescription& d = source->description();
    EXPECT_EQ(std::string(voxel_type_name(d.type)), expected["type"]) << name;
    EXPECT_EQ((std::vector<std::int64_t>{d.size.x, d.size.y, d.size.z}),
              expected["size"].get<std::vector<std::int64_t>>()) << name;
    EXPECT_EQ(digest_of(*source), expected["sha256"]) << name;
  }
}

void expect_near(const Geometry& g, const Geometry& expected, const std::string& path) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(g.spacing_mm[axis], expected.spacing_mm[axis], 1e-5 * g.spacing_mm[axis]) << path;
    EXPECT_NEAR(g.origin_mm[axis], expected.origin_mm[axis], 1e-4) << path;
  }
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(g.direction[i], expected.direction[i], 1e-5) << path;
  }
}

TEST(SourceShared, GeometryIsThatOfItk) {
  const auto root = shared_data();
  if (!root) GTEST_SKIP() << missing_shared_file("mr");
  const VolumeReader* const itk = itk_reader();
  if (itk == nullptr) GTEST_SKIP() << kNoItk;
  for (const char* name :
       {"mr/chris_t1.nii.gz", "mr/chris_MRA.nii.gz", "labels/aal.nii.gz",
        "labels/totalseg_ct.nii.gz", "labels/mouse_head_35um_labels.nii.gz",
        "microct_mouse_head/C57BL6_J_.nii.gz", "awkward/oblique_fmri_pitch.nii.gz",
        "awkward/bigendian_anatomical.nii", "awkward/orientations/avg152T1_LR_LIP.nii.gz",
        "awkward/orientations/avg152T1_LR_PSR.nii.gz",
        "awkward/orientations/avg152T1_LR_RAS.nii.gz", "microct_rock_berea/berea400.nrrd",
        "cranium/cranium.mhd"}) {
    const std::string path = (*root / name).string();
    expect_near(open_source({path}, {})->description().geometry, itk->read_geometry(path), path);
  }
}

/// A file or folder, and the words its error must hold.
struct Awkward {
  const char* path;
  std::vector<std::string> words;
};

TEST(SourceShared, AwkwardSourcesAreRejectedByName) {
  const auto root = shared_data();
  if (!root) GTEST_SKIP() << missing_shared_file("awkward");
  const std::vector<Awkward> rows = {
      {"tilt_uneven_ge",
       {"18.5 degrees", "tilt", "uneven", "14.dcm", "15.dcm", "[untilt]", "[on_gap=resample]"}},
      {"missing_slice", {"04.dcm", "06.dcm", "16 mm", "8 mm", "missing", "[on_gap=fill]"}},
      {"truncated_slice", {"03.dcm", "ends early"}},
      {"duplicate_slice", {"01.dcm", "02.dcm", "same position", "120 mm", "[drop_duplicates]"}},
      {"mixed_series", {"2 series", "[series]", "512 x 512", "128 x 128"}},
      {"codecs_ct2", {"series"}},
      {"MR_truncated.dcm", {"MR_truncated.dcm", "ends early"}},
      {"emri_small.dcm", {"no geometry", "[spacing_mm]"}},
      {"emri_small_j2k_too_short.dcm", {"ends early"}},
      {"seg_deflated_liver.dcm", {"1.2.840.10008.1.2.8.1"}},
      {"SC_rgb_16bit.dcm", {"3 channels", "[channel="}},
      {"rgba_CIT168.nii.gz", {"4 channels", "alpha"}},
      {"example4d.nii.gz", {"2 points in time"}},
      {"example_nifti2.nii.gz", {"2 points in time"}},
      {"truncated_aal.nii.gz", {"cut"}},
      {"not_really.nii.gz", {"not_really.nii.gz"}},
      {"empty.dcm", {"empty"}},
      {"analyze_header_only.hdr", {"Analyze"}},
      {"dangling.mhd", {"no_such_file.zraw", "missing"}},
      {"complex_brain_slice.mha", {"2 channels"}},
      {"tiff_two_channel_spots.tif", {"2 channels"}},
      {"tiff_mismatched_dims", {"271 x 193", "193 x 104"}},
  };
  for (const Awkward& row : rows) {
    const Error error = source_error({(*root / "awkward" / row.path).string()});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << error.what();
    for (const std::string& word : row.words) {
      EXPECT_TRUE(contains(error, word)) << word << " in: " << with_hints(error);
    }
  }
}

std::string voxels_at(const std::filesystem::path& path) {
  return voxels_of(*open_source({path.string()}, {}));
}

TEST(SourceShared, LosslessCodecsAndByteOrdersGiveEqualVoxels) {
  const auto root = shared_data();
  if (!root) GTEST_SKIP() << missing_shared_file("awkward");
  const auto awkward = *root / "awkward";
  EXPECT_EQ(voxels_at(awkward / "MR_small.dcm"), voxels_at(awkward / "MR_small_bigendian.dcm"));
  const std::string plain = voxels_at(awkward / "codecs_ct2/CT2_UNC");
  for (const char* name : {"CT2_J2KR", "CT2_JLSL", "CT2_JPLL", "CT2_RLE"}) {
    EXPECT_EQ(voxels_at(awkward / "codecs_ct2" / name), plain) << name;
  }
  for (const char* name : {"CT2_J2KI", "CT2_JLSN"}) {
    const auto source = open_source({(awkward / "codecs_ct2" / name).string()}, {});
    EXPECT_TRUE(source->description().metadata.was_source_lossy()) << name;
  }
}

TEST(SourceShared, AwkwardSeriesAreMadeEvenAndUprightWhenAsked) {
  const auto root = shared_data();
  if (!root) GTEST_SKIP() << missing_shared_file("awkward");
  SourceOptions options;
  options.untilt = true;
  options.on_gap = GapPolicy::resample;
  options.drop_duplicates = true;
  const auto open = [&](const char* name) {
    return open_source({(*root / "awkward" / name).string()}, options);
  };
  const auto tilted = open("tilt_uneven_ge");
  EXPECT_EQ(tilted->description().size, (Size3{512, 611, 37}));
  EXPECT_NEAR(tilted->description().geometry.spacing_mm[2], 4.22 * 0.9483237, 1e-4);
  EXPECT_EQ(open("duplicate_slice")->description().size, (Size3{512, 512, 2}));
  options.on_gap = GapPolicy::fill;
  const auto filled = open("missing_slice");
  EXPECT_EQ(filled->description().size, (Size3{512, 512, 7}));
  EXPECT_EQ(filled->description().geometry.spacing_mm[2], 8);
  // Each slice stands unchanged at its place, and the plane made lies between its neighbors.
  const std::string all = voxels_of(*filled);
  const std::size_t plane = all.size() / 7;
  for (const std::size_t z : {0U, 1U, 2U, 3U, 5U, 6U}) {
    const std::string name = "0" + std::to_string(z + 1) + ".dcm";
    EXPECT_EQ(all.substr(z * plane, plane),
              voxels_of(*open_source({(*root / "awkward/missing_slice" / name).string()}, {})));
  }
  std::vector<std::uint16_t> values(all.size() / 2);
  std::memcpy(values.data(), all.data(), all.size());
  for (std::size_t i = 4 * plane / 2; i < 5 * plane / 2; ++i) {
    const double mean = (values[i - plane / 2] + values[i + plane / 2]) / 2.0;
    ASSERT_NEAR(values[i], mean, 0.5);
  }
}

TEST(SourceShared, SegmentationsAreLabelsAndFramesWithoutGeometryTakeASpacing) {
  const auto root = shared_data();
  if (!root) GTEST_SKIP() << missing_shared_file("awkward");
  const auto liver = open_source({(*root / "awkward/seg_1bit_liver.dcm").string()}, {});
  EXPECT_EQ(liver->description().kind, VolumeKind::labels);
  EXPECT_EQ(liver->description().size, (Size3{512, 512, 3}));
  const std::string labels = voxels_of(*liver);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), '\1'), 107098);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), '\0'), 512 * 512 * 3 - 107098);
  SourceOptions options;
  options.spacing_mm = Point3{1, 1, 1.2};
  const auto mr = open_source({(*root / "awkward/emri_small.dcm").string()}, options);
  EXPECT_EQ(mr->description().size, (Size3{64, 64, 10}));
}

TEST(SourceShared, AwkwardButSoundSourcesAreReadWithTheirGeometry) {
  const auto root = shared_data();
  if (!root) GTEST_SKIP() << missing_shared_file("awkward");
  const auto open = [&](const char* name) {
    return open_source({(*root / "awkward" / name).string()}, {});
  };
  for (const char* name : {"dicomdir_noext", "dicomdir_noext/DICOMDIR", "dicomdir_noext/IMAGES"}) {
    EXPECT_EQ(open(name)->description().size.z, 4) << name;
    EXPECT_EQ(open(name)->description().geometry.spacing_mm[2], 8) << name;
  }
  EXPECT_EQ(open("pet_float_rescale")->description().rescale.slope, 2.0222414);
  EXPECT_EQ(open("tiff_anisotropic_mri_head.tif")->description().geometry.spacing_mm,
            (Point3{0.5, 0.5, 7}));
  EXPECT_EQ(open("tiff names with spaces")->description().size.z, 8);
  EXPECT_EQ(open("eCT_Supplemental.dcm")->description().geometry.spacing_mm[2], 10);
  const auto stripes = open("12bitSigned_0x0F0F.dcm");
  const std::string bytes = voxels_of(*stripes);
  std::vector<std::int16_t> values(bytes.size() / 2);
  std::memcpy(values.data(), bytes.data(), bytes.size());
  EXPECT_EQ(stripes->description().size, (Size3{64, 64, 35}));
  // As nibabel unfolds the mosaic.
  const Point3 origin = stripes->description().geometry.origin_mm;
  for (const auto& [found, expected] : {std::pair(origin[0], -108.84054425),
                                        std::pair(origin[1], -119.56490282),
                                        std::pair(origin[2], -25.62707867)}) {
    EXPECT_NEAR(found, expected, 1e-4);
  }
  for (const std::int16_t value : values) ASSERT_TRUE(value >= -2048 && value <= 2047);
  EXPECT_NE(std::find(values.begin(), values.end(), -241), values.end());
  EXPECT_NE(std::find(values.begin(), values.end(), -1), values.end());
}

}  // namespace
}  // namespace octavo::testing
