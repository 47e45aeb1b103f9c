// What other programs read in the files that export writes.
#include "octavo/io/export/export.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <tiffio.h>
#include <unistd.h>

#include <cmath>
#include <functional>

#include "octavo/io/open_source.h"
#include "support/built_file.h"
#include "support/memory_reader.h"
#include "support/memory_storage.h"
#include "support/stopping_progress.h"
#include "support/volume_readers.h"
#include "support/voxel_numbers.h"

namespace octavo {
namespace {

namespace fs = std::filesystem;
using testing::ReadVolume;
using testing::ScratchFolder;
using testing::Volume;
using testing::VolumeReader;
using testing::volume_readers;

Geometry oblique_geometry() {
  Geometry geometry;
  geometry.origin_mm = {-12.5, 40.25, 7.125};
  geometry.spacing_mm = {0.7, 0.8, 1.1};
  const double c = std::cos(0.3);
  const double s = std::sin(0.3);
  const double d = std::cos(-0.2);
  const double t = std::sin(-0.2);
  geometry.direction = {c, -s * d, s * t, s, c * d, -c * t, 0, t, d};
  return geometry;
}

Volume make_volume(VoxelType type, const Size3& size, const Rescale& rescale = {},
                   std::int64_t offset = 0) {
  Volume volume;
  volume.description.type = type;
  volume.description.size = size;
  volume.description.geometry = oblique_geometry();
  volume.description.rescale = rescale;
  const auto count = static_cast<std::size_t>(size.voxel_count());
  volume.voxels.resize(count * static_cast<std::size_t>(bytes_per_voxel(type)));
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    std::uint32_t state = 7;
    for (std::size_t i = 0; i < count; ++i) {
      state = state * 1664525u + 1013904223u;
      const auto value = static_cast<T>(static_cast<std::int64_t>(state >> 25) + offset);
      std::memcpy(volume.voxels.data() + i * sizeof(T), &value, sizeof value);
    }
  });
  return volume;
}

VoxelType tiff_type(int format, int bits) {
  if (format == SAMPLEFORMAT_IEEEFP) return VoxelType::float32;
  const bool is_signed = format == SAMPLEFORMAT_INT;
  if (bits == 8) return is_signed ? VoxelType::int8 : VoxelType::uint8;
  if (bits == 16) return is_signed ? VoxelType::int16 : VoxelType::uint16;
  return is_signed ? VoxelType::int32 : VoxelType::uint32;
}

ReadVolume read_with_libtiff(const std::vector<std::string>& files) {
  ReadVolume result;
  for (const std::string& path : files) {
    TIFF* const tiff = TIFFOpen(path.c_str(), "r");
    if (tiff == nullptr) throw std::runtime_error("no TIFF: " + path);
    do {
      std::uint32_t width = 0;
      std::uint32_t height = 0;
      std::uint16_t bits = 0;
      std::uint16_t format = 0;
      TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
      TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
      TIFFGetField(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
      TIFFGetField(tiff, TIFFTAG_SAMPLEFORMAT, &format);
      std::vector<std::byte> row(static_cast<std::size_t>(TIFFScanlineSize(tiff)));
      const VoxelType type = tiff_type(format, bits);
      for (std::uint32_t y = 0; y < height; ++y) {
        if (TIFFReadScanline(tiff, row.data(), y) != 1) throw std::runtime_error("bad row");
        const auto values = testing::as_numbers(row, type);
        result.values.insert(result.values.end(), values.begin(), values.end());
      }
      result.size = {width, height, result.size.z + 1};
      float x = 0;
      TIFFGetField(tiff, TIFFTAG_XRESOLUTION, &x);
      result.geometry.spacing_mm[0] = 10 / static_cast<double>(x);
    } while (TIFFReadDirectory(tiff) == 1);
    TIFFClose(tiff);
  }
  return result;
}

void expect_geometry(const Geometry& found, const Geometry& expected, double tolerance) {
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(found.origin_mm[i], expected.origin_mm[i], tolerance);
    EXPECT_NEAR(found.spacing_mm[i], expected.spacing_mm[i], tolerance);
  }
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(found.direction[i], expected.direction[i], tolerance) << "direction " << i;
  }
}

double tolerance_of(const std::string& name) {
  return name.find(".nii") != std::string::npos ? 1e-5 : 1e-12;
}

/// A reader of a volume, and a folder to export into.
struct Built {
  ScratchFolder folder;
  Volume volume;
  std::shared_ptr<FileReader> reader;

  explicit Built(Volume v) : volume(std::move(v)) {
    testing::build_volume(volume, folder.file("in.8vo"), 2);
    reader = testing::open_file(folder.file("in.8vo"));
  }

  Built(Volume v, const ValueRange& range) : volume(std::move(v)) {
    reader = std::make_shared<testing::MemoryReader>(volume.description, volume.voxels, range);
  }

  ExportResult export_as(const std::string& name, const ExportOptions& options = {},
                         Storage& storage = local_storage()) {
    NoProgress progress;
    const std::string path = folder.file(name);
    return export_volume(*reader, storage, path, export_format_of(path), options, progress);
  }

  std::size_t entry_count() const {
    const fs::directory_iterator entries(fs::path(folder.file("")).parent_path());
    return static_cast<std::size_t>(std::distance(fs::begin(entries), fs::end(entries)));
  }
};

constexpr VoxelType kTypes[] = {VoxelType::int8,   VoxelType::uint8, VoxelType::int16,
                                VoxelType::uint16, VoxelType::int32, VoxelType::uint32,
                                VoxelType::float32};
const std::string kVolumeNames[] = {"a.nrrd", "a.nii", "a.nii.gz", "a.mha", "a.mhd"};

ErrorKind kind_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.kind();
  }
  return ErrorKind::internal;
}

TEST(Export, EveryReaderFindsTheSameValuesAndGeometryForEveryTypeAndFormat) {
  for (const VoxelType type : kTypes) {
    Built built(make_volume(type, {37, 21, 70}), {0, 127});
    for (const std::string& name : kVolumeNames) {
      SCOPED_TRACE(name + " " + std::string(voxel_type_name(type)));
      const ExportResult result = built.export_as(name);
      EXPECT_TRUE(result.real_units);
      EXPECT_EQ(result.type, type);
      for (const VolumeReader& reader : volume_readers()) {
        SCOPED_TRACE(reader.name);
        const ReadVolume found = reader.read(built.folder.file(name));
        EXPECT_EQ(found.type, type);
        EXPECT_EQ(found.size, built.volume.description.size);
        EXPECT_EQ(found.values, testing::as_numbers(built.volume.voxels, type));
        expect_geometry(found.geometry, built.volume.description.geometry, tolerance_of(name));
      }
    }
  }
}

TEST(Export, LibtiffReadsTheSameValuesFromPagesAndFolders) {
  for (const VoxelType type : kTypes) {
    Built built(make_volume(type, {37, 21, 70}), {0, 127});
    for (const std::string name : {"a.tif", "stack/"}) {
      SCOPED_TRACE(name + " " + std::string(voxel_type_name(type)));
      const ExportResult result = built.export_as(name);
      EXPECT_EQ(result.files.size(), name == "a.tif" ? 1u : 70u);
      const ReadVolume found = read_with_libtiff(result.files);
      EXPECT_EQ(found.size, built.volume.description.size);
      EXPECT_EQ(found.values, testing::as_numbers(built.volume.voxels, type));
      EXPECT_NEAR(found.geometry.spacing_mm[0], 0.7, 1e-6);
    }
  }
}

TEST(Export, RawHoldsTheStoredVoxels) {
  Built built(make_volume(VoxelType::int16, {37, 21, 70}, {1, -1024}));
  const ExportResult result = built.export_as("a.raw");
  EXPECT_FALSE(result.real_units);
  const std::string bytes = testing::bytes_of_file(built.folder.file("a.raw"));
  ASSERT_EQ(bytes.size(), built.volume.voxels.size());
  EXPECT_EQ(std::memcmp(bytes.data(), built.volume.voxels.data(), bytes.size()), 0);
}

TEST(Export, BoxesAtLevelsLieWhereTheirVoxelsLie) {
  Built built(make_volume(VoxelType::int16, {130, 70, 141}));
  for (const int level : {0, 1, 2, 6}) {
    ExportOptions options;
    options.level = level;
    const Size3 size = built.reader->levels().size(level);
    options.box = Box{{size.x / 3, size.y / 2, size.z / 4}, {size.x, size.y, (size.z * 3 + 3) / 4}};
    options.overwrite = true;
    for (const std::string& name : kVolumeNames) {
      SCOPED_TRACE(name + " level " + std::to_string(level));
      built.export_as(name, options);
      const Geometry expected =
          cropped(built.reader->levels().geometry(built.volume.description.geometry, level),
                  options.box->lo);
      const std::vector<double> values = testing::as_numbers(
          testing::read_box(*built.reader, *options.box, level), VoxelType::int16);
      for (const VolumeReader& reader : volume_readers()) {
        SCOPED_TRACE(reader.name);
        const ReadVolume found = reader.read(built.folder.file(name));
        EXPECT_EQ(found.size, options.box->size());
        EXPECT_EQ(found.values, values);
        expect_geometry(found.geometry, expected, tolerance_of(name) * 64);
      }
    }
  }
}

TEST(Export, WhereNoPlaceIsKnownNiftiAndNrrdClaimNone) {
  Volume volume = make_volume(VoxelType::int16, {9, 8, 7});
  volume.description.geometry = {};
  volume.description.geometry.spacing_mm = {0.5, 1, 2};
  Built built(std::move(volume));
  ExportOptions options;
  options.box = Box{{4, 2, 1}, {9, 8, 7}};
  built.export_as("a.nii", options);
  const std::string header = testing::bytes_of_file(built.folder.file("a.nii")).substr(252, 4);
  EXPECT_EQ(header, std::string(4, '\0')) << "the codes of qform and sform";
  built.export_as("a.nrrd", options);
  EXPECT_EQ(testing::bytes_of_file(built.folder.file("a.nrrd")).find("space"), std::string::npos);
  for (const VolumeReader& reader : volume_readers()) {
    SCOPED_TRACE(reader.name);
    EXPECT_EQ(reader.read_geometry(built.folder.file("a.nii")).spacing_mm, (Point3{0.5, 1, 2}));
    const ReadVolume found = reader.read(built.folder.file("a.nrrd"));
    EXPECT_EQ(found.geometry.spacing_mm, (Point3{0.5, 1, 2}));
    EXPECT_EQ(found.geometry.origin_mm, (Point3{2, 2, 2}));
    EXPECT_EQ(found.values, testing::as_numbers(testing::read_box(*built.reader, *options.box, 0),
                                                VoxelType::int16));
  }
}

TEST(Export, AVoxelOutsideTheDeclaredRangeIsDamage) {
  Built built(make_volume(VoxelType::int16, {9, 9, 9}, {1000, 0}), {0, 3});
  EXPECT_EQ(kind_of([&] { built.export_as("a.nrrd"); }), ErrorKind::corrupt);
  EXPECT_EQ(built.entry_count(), 0u);
}

/// By every reader; `rescaled` by those that know every rescale.
void expect_values(const std::string& path, const std::vector<double>& values,
                   const std::vector<double>& rescaled) {
  for (const VolumeReader& reader : volume_readers()) {
    EXPECT_EQ(reader.read(path).values, reader.knows_rescale ? rescaled : values)
        << reader.name << " " << path;
  }
}

struct RescaleCase {
  VoxelType stored;
  Rescale rescale;
  std::int64_t offset;
  VoxelType written;
  bool real_in_nrrd;
};

TEST(Export, IntegerRescaleBecomesTheSmallestTypeThatHoldsIt) {
  // Stored values run from offset to offset + 127.
  const RescaleCase cases[] = {
      {VoxelType::uint16, {1, -1024}, 0, VoxelType::int16, true},
      {VoxelType::int16, {1, -1024}, 0, VoxelType::int16, true},
      {VoxelType::uint8, {1, -1024}, 0, VoxelType::int16, true},
      {VoxelType::uint8, {2, 0}, 0, VoxelType::uint8, true},
      {VoxelType::uint8, {400, 0}, 0, VoxelType::uint16, true},
      {VoxelType::int16, {1000, -5}, 0, VoxelType::int32, true},
      {VoxelType::int16, {-1000, -5}, 0, VoxelType::int32, true},
      {VoxelType::int32, {1, -70000}, 70000, VoxelType::int32, true},
      {VoxelType::int16, {0.5, 0}, 0, VoxelType::int16, false},
      {VoxelType::int16, {1, 0.25}, 0, VoxelType::int16, false},
  };
  for (const RescaleCase& c : cases) {
    SCOPED_TRACE(std::to_string(c.rescale.slope) + " " + std::to_string(c.rescale.intercept));
    Built built(make_volume(c.stored, {20, 20, 20}, c.rescale, c.offset));
    std::vector<double> real = testing::as_numbers(built.volume.voxels, c.stored);
    for (double& value : real) value = c.rescale.to_real(value);

    const ExportResult nrrd = built.export_as("a.nrrd");
    EXPECT_EQ(nrrd.real_units, c.real_in_nrrd);
    EXPECT_EQ(nrrd.type, c.written);
    const auto stored = testing::as_numbers(built.volume.voxels, c.stored);
    expect_values(built.folder.file("a.nrrd"), c.real_in_nrrd ? real : stored, real);

    const ExportResult nifti = built.export_as("a.nii");
    EXPECT_TRUE(nifti.real_units);
    expect_values(built.folder.file("a.nii"), real, real);

    ExportOptions keep;
    keep.values = ExportValues::stored;
    for (const std::string name : {"s.nrrd", "s.nii", "s.mha"}) {
      const ExportResult result = built.export_as(name, keep);
      EXPECT_FALSE(result.real_units);
      EXPECT_EQ(result.type, c.stored);
      expect_values(built.folder.file(name), stored, name == "s.nii" ? stored : real);
    }
  }
}

TEST(Export, RealValuesAreFloatsInEveryFormat) {
  const VoxelType types[] = {VoxelType::uint8, VoxelType::int16, VoxelType::uint32};
  for (const VoxelType type : types) {
    Built built(make_volume(type, {33, 5, 4}, {2.2, -7.5}));
    std::vector<double> real = testing::as_numbers(built.volume.voxels, type);
    for (double& value : real) value = static_cast<float>(2.2 * value - 7.5);
    ExportOptions options;
    options.values = ExportValues::real;
    for (const std::string name : {"r.nrrd", "r.nii", "r.mha"}) {
      const ExportResult result = built.export_as(name, options);
      EXPECT_TRUE(result.real_units) << name;
      EXPECT_EQ(result.type, VoxelType::float32) << name;
      expect_values(built.folder.file(name), real, real);
    }
    EXPECT_EQ(read_with_libtiff(built.export_as("r.tif", options).files).values, real);
    built.export_as("r.raw", options);
    const std::string raw = testing::bytes_of_file(built.folder.file("r.raw"));
    std::vector<std::byte> bytes(raw.size());
    std::memcpy(bytes.data(), raw.data(), raw.size());
    EXPECT_EQ(testing::as_numbers(bytes, VoxelType::float32), real);
  }
}

TEST(Export, LabelsHaveNoRealValues) {
  Volume labels = make_volume(VoxelType::uint8, {9, 9, 9});
  labels.description.kind = VolumeKind::labels;
  Built built(std::move(labels));
  ExportOptions options;
  options.values = ExportValues::real;
  EXPECT_EQ(kind_of([&] { built.export_as("r.nrrd", options); }), ErrorKind::invalid_argument);
  EXPECT_EQ(built.entry_count(), 1u);
}

/// What opening an export as a source finds in it.
VolumeDescription opened(const std::string& path) {
  return open_source({path}, SourceOptions{})->description();
}

TEST(Export, TiffNotesAreReadBackExactly) {
  for (const VoxelType type : {VoxelType::uint8, VoxelType::uint16, VoxelType::int16}) {
    const Rescale rescale{2.208627462387085, -3.25};
    Built built(make_volume(type, {20, 6, 5}, rescale));
    for (const std::string name : {"a.tif", "stack/"}) {
      built.export_as(name);
      const VolumeDescription found = opened(built.folder.file(name));
      EXPECT_EQ(found.rescale, rescale) << name;
      EXPECT_EQ(found.geometry, oblique_geometry()) << name;
    }
  }
}

TEST(Export, TiffNotesDoNotMakeAPlaceKnown) {
  for (const bool is_known : {true, false}) {
    Volume volume = make_volume(VoxelType::uint8, {20, 6, 5});
    volume.description.metadata =
        Metadata::read(is_known ? R"({"place_known":true})" : R"({"place_known":false})");
    Built built(std::move(volume));
    built.export_as("a.tif");
    const VolumeDescription found = opened(built.folder.file("a.tif"));
    EXPECT_EQ(found.geometry, oblique_geometry());
    EXPECT_EQ(found.metadata.facts().place_known, is_known);
  }
}

TEST(Export, APlaneOfATiffStackAloneKnowsWhereItLies) {
  Built built(make_volume(VoxelType::int16, {20, 6, 5}));
  const std::string third = built.export_as("stack/").files.at(2);
  const Geometry expected = cropped(oblique_geometry(), {0, 0, 2});
  EXPECT_EQ(opened(third).geometry, expected);
}

TEST(Export, LongAxesGoToNifti2) {
  Built built(make_volume(VoxelType::uint8, {40000, 2, 1}));
  built.export_as("a.nii");
  const std::string bytes = testing::bytes_of_file(built.folder.file("a.nii"));
  EXPECT_EQ(static_cast<unsigned char>(bytes[0]) | static_cast<unsigned char>(bytes[1]) << 8, 540);
  EXPECT_EQ(bytes.size(), 544u + 80000u);
}

TEST(Export, EveryAxisFlipAndOrderSurvivesInNifti) {
  for (const int flips : {0, 1, 2, 3, 4, 5, 6, 7}) {
    for (const std::array<int, 3> order :
         {std::array{0, 1, 2}, std::array{1, 2, 0}, std::array{2, 1, 0}}) {
      Volume volume = make_volume(VoxelType::uint8, {5, 6, 7});
      auto& direction = volume.description.geometry.direction;
      direction.fill(0);
      for (std::size_t a = 0; a < 3; ++a) {
        direction[static_cast<std::size_t>(order[a]) * 3 + a] = flips >> a & 1 ? -1 : 1;
      }
      Built built(std::move(volume));
      built.export_as("a.nii");
      for (const VolumeReader& reader : volume_readers()) {
        SCOPED_TRACE(reader.name);
        expect_geometry(reader.read_geometry(built.folder.file("a.nii")),
                        built.volume.description.geometry, 1e-5);
      }
    }
  }
}

TEST(Export, NothingIsReplacedUnasked) {
  Built built(make_volume(VoxelType::uint8, {9, 9, 9}));
  for (const std::string name : {"a.nrrd", "a.nii.gz", "a.mhd", "a.tif", "stack/"}) {
    built.export_as(name);
    EXPECT_EQ(kind_of([&] { built.export_as(name); }), ErrorKind::io) << name;
    ExportOptions replace;
    replace.overwrite = true;
    built.export_as(name, replace);
  }
  EXPECT_EQ(built.entry_count(), 7u);  // in.8vo, five exports, one of them two files
}

TEST(Export, AFolderThatHoldsOtherFilesIsNeverReplaced) {
  Built built(make_volume(VoxelType::uint8, {9, 9, 9}));
  fs::create_directory(built.folder.file("photos"));
  std::ofstream(built.folder.file("photos/holiday.tif")) << "x";
  ExportOptions replace;
  replace.overwrite = true;
  EXPECT_EQ(kind_of([&] { built.export_as("photos", replace); }), ErrorKind::io);
  EXPECT_TRUE(fs::exists(built.folder.file("photos/holiday.tif")));
  EXPECT_EQ(built.entry_count(), 2u);
}

TEST(Export, AnUnfinishedStackStaysOnlyWhileItsWriterLives) {
  Built built(make_volume(VoxelType::uint8, {9, 9, 9}));
  const auto unfinished = [&](const std::string& ending) {
    const std::string name = built.folder.file(".stack.tmp-" + ending);
    fs::create_directory(name);
    std::ofstream(name + "/plane_0000.tif") << "x";
    return name;
  };
  // Whatever process has the number by now, the lock decides.
  const std::string left = unfinished(std::to_string(::getppid()));
  const std::string living = unfinished("2147483647");
  const int lock = ::open(living.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_EQ(::flock(lock, LOCK_EX | LOCK_NB), 0);
  built.export_as("stack/");
  EXPECT_FALSE(fs::exists(left));
  EXPECT_TRUE(fs::exists(living));
  ::close(lock);
}

/// A file system that lets no two names change places.
class StorageWithoutExchange final : public Storage {
 public:
  std::unique_ptr<StorageFile> open_read(const std::string& path) override {
    return local_storage().open_read(path);
  }
  std::unique_ptr<StorageFile> create_exclusive(const std::string& path) override {
    return local_storage().create_exclusive(path);
  }
  std::unique_ptr<StorageFile> open_update(const std::string& path) override {
    return local_storage().open_update(path);
  }
  std::unique_ptr<StorageFile> create_scratch(const std::string& folder) override {
    return local_storage().create_scratch(folder);
  }
  std::unique_ptr<StorageFile> create_folder(const std::string& path,
                                             const std::string& target) override {
    return local_storage().create_folder(path, target);
  }
  bool exists(const std::string& path) override { return local_storage().exists(path); }
  void rename(const std::string& from, const std::string& to) override {
    if (rejects_final && base_name_of(to) == "stack" && base_name_of(from).front() == '.') {
      rejects_final = false;
      throw Error(ErrorKind::io, "rejected", to);
    }
    local_storage().rename(from, to);
  }
  void remove(const std::string& path) override { local_storage().remove(path); }
  std::vector<std::string> list(const std::string& prefix) override {
    return local_storage().list(prefix);
  }
  void sync_folder(const std::string& folder) override { local_storage().sync_folder(folder); }

  bool rejects_final = false;
};

TEST(Export, AStackIsReplacedAsAWholeWhereNamesCannotBeExchanged) {
  Built built(make_volume(VoxelType::uint8, {9, 9, 9}));
  StorageWithoutExchange storage;
  built.export_as("stack/", {}, storage);
  std::ofstream(built.folder.file("stack/plane_0099.tif")) << "of the earlier stack";
  ExportOptions replace;
  replace.overwrite = true;
  storage.rejects_final = true;
  EXPECT_EQ(kind_of([&] { built.export_as("stack/", replace, storage); }), ErrorKind::io);
  EXPECT_TRUE(fs::exists(built.folder.file("stack/plane_0099.tif")));
  EXPECT_EQ(built.entry_count(), 2u);
  built.export_as("stack/", replace, storage);
  EXPECT_FALSE(fs::exists(built.folder.file("stack/plane_0099.tif")));
  EXPECT_TRUE(fs::exists(built.folder.file("stack/plane_0008.tif")));
  EXPECT_EQ(built.entry_count(), 2u);
}

TEST(Export, BadBoxesAndLevelsAreRejected) {
  Built built(make_volume(VoxelType::uint8, {9, 9, 9}));
  ExportOptions outside;
  outside.box = Box{{0, 0, 0}, {10, 9, 9}};
  ExportOptions empty;
  empty.box = Box{{3, 3, 3}, {3, 4, 4}};
  ExportOptions deep;
  deep.level = 99;
  for (const ExportOptions& options : {outside, empty, deep}) {
    EXPECT_EQ(kind_of([&] { built.export_as("a.nrrd", options); }), ErrorKind::invalid_argument);
  }
  EXPECT_EQ(kind_of([] { export_format_of("x.bmp"); }), ErrorKind::invalid_argument);
  EXPECT_EQ(built.entry_count(), 1u);
}

TEST(Export, EveryFailingCallLeavesNothing) {
  Built built(make_volume(VoxelType::uint8, {9, 9, 9}));
  NoProgress progress;
  for (const std::string path :
       {"/out/a.raw", "/out/a.nrrd", "/out/a.nii.gz", "/out/a.mhd", "/out/a.tif"}) {
    for (std::size_t fail_at = 1;; ++fail_at) {
      testing::MemoryStorage storage;
      storage.fail_at = fail_at;
      try {
        export_volume(*built.reader, storage, path, export_format_of(path), {}, progress);
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::io);
      }
      if (!storage.has_failed) break;
      EXPECT_TRUE(storage.files.empty()) << path << " call " << fail_at;
    }
  }
}

TEST(Export, ACancelledExportLeavesNothing) {
  Built built(make_volume(VoxelType::uint8, {9, 9, 9}));
  testing::StoppingProgress progress;
  for (const std::string name : {"a.raw", "a.mhd", "a.nii.gz", "a.tif", "stack/"}) {
    const std::string path = built.folder.file(name);
    EXPECT_EQ(kind_of([&] {
                export_volume(*built.reader, local_storage(), path, export_format_of(path), {},
                              progress);
              }),
              ErrorKind::cancelled);
  }
  EXPECT_EQ(built.entry_count(), 1u);
}

TEST(Export, GzipBytesDoNotDependOnThreads) {
  Built built(make_volume(VoxelType::int16, {160, 160, 130}));
  ExportOptions one;
  one.threads = 1;
  ExportOptions three;
  three.threads = 3;
  built.export_as("one.nii.gz", one);
  built.export_as("three.nii.gz", three);
  EXPECT_EQ(testing::bytes_of_file(built.folder.file("one.nii.gz")),
            testing::bytes_of_file(built.folder.file("three.nii.gz")));
  const auto values = testing::as_numbers(built.volume.voxels, VoxelType::int16);
  expect_values(built.folder.file("one.nii.gz"), values, values);
}

}  // namespace
}  // namespace octavo
