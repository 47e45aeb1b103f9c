#include "octavo/io/dicom/dicom_times.h"

#include <gtest/gtest.h>

#include <string>
#include <tuple>
#include <vector>

#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// A slice of 5 x 3 voxels of one value, of a number in `tag`.
struct Moment {
  std::string number;
  double z_mm = 0;
  char value = 0;
  double x_mm = 0;
};

void write_moments(const TempFolder& folder, std::uint32_t tag, const char* vr,
                   const std::vector<Moment>& moments) {
  for (std::size_t i = 0; i < moments.size(); ++i) {
    DicomElements elements = ct_elements(5, 3, 8, moments[i].z_mm);
    elements.set(0x00200032, "DS",
                 std::to_string(moments[i].x_mm) + "\\0\\" + std::to_string(moments[i].z_mm));
    if (!moments[i].number.empty()) elements.set(tag, vr, moments[i].number);
    elements.set(kPixelData, "OB", std::string(15, moments[i].value));
    elements.write(folder.file("s" + std::to_string(i)), kExplicitLittle);
  }
}

std::string planes_of(std::initializer_list<char> values) {
  std::string voxels;
  for (const char value : values) voxels += std::string(15, value);
  return voxels;
}

TEST(DicomTimes, AreChosenWhereEveryPlaceHasAll) {
  for (const auto& [tag, vr] : std::vector<std::pair<std::uint32_t, const char*>>{
           {0x00200100, "IS"}, {0x00181060, "DS"}, {0x00541300, "DS"}, {0x00200012, "IS"}}) {
    const TempFolder folder;
    write_moments(folder, tag, vr,
                  {{"10", 0, 3}, {"9", 0, 1}, {"10", 2, 4}, {"9", 2, 2}, {"80", 2, 6},
                   {"80", 0, 5}});
    EXPECT_TRUE(contains(source_error({folder.path()}), "3 points in time"));
    for (std::int64_t time = 0; time < 3; ++time) {
      SourceOptions options;
      options.time = time;
      const auto source = open_source({folder.path()}, options);
      const auto low = static_cast<char>(2 * time + 1);
      EXPECT_EQ(voxels_of(*source), planes_of({low, static_cast<char>(low + 1)})) << tag;
      EXPECT_TRUE(contains(source->description().metadata.text(), "\"time\":{\"count\":3"))
          << source->description().metadata.text();
      EXPECT_TRUE(source->warnings().empty()) << with_hints(source->warnings());
      EXPECT_FALSE(source->files().outline);
    }
  }
}

TEST(DicomTimes, ThatWereMeasuredForEachSliceAreChosenByTheirOrder) {
  for (const auto& [tag, vr, day, told_by] :
       std::vector<std::tuple<std::uint32_t, const char*, std::string, const char*>>{
           {0x00181060, "DS", "", "Trigger Time (0018,1060): 9 to 9.3, 10, 80.5 to 81 ms"},
           {0x00080032, "TM", "1000",
            "Acquisition Time (0008,0032): 100009 to 100009.3, 100010, 100080.5 to 100081"},
           {0x0008002a, "DT", "202612311000",
            "Acquisition DateTime (0008,002a): 20261231100009 to 20261231100009.3, "
            "20261231100010, 20261231100080.5 to 20261231100081"}}) {
    const TempFolder folder;
    const std::string nine = day.empty() ? "9" : day + "09";
    write_moments(folder, tag, vr,
                  {{day + "10", 0, 3}, {nine, 0, 1}, {day + "10", 2, 4}, {nine + ".3", 2, 2},
                   {day + "81", 2, 6}, {day + "80.5", 0, 5}});
    EXPECT_TRUE(contains(source_error({folder.path()}),
                         std::string("3 points in time (") + told_by + ")"))
        << source_error({folder.path()}).what();
    for (std::int64_t time = 0; time < 3; ++time) {
      SourceOptions options;
      options.time = time;
      const auto low = static_cast<char>(2 * time + 1);
      EXPECT_EQ(voxels_of(*open_source({folder.path()}, options)),
                planes_of({low, static_cast<char>(low + 1)})) << tag;
    }
  }
}

TEST(DicomTimes, ThatOverlapAreToldOnceWhetherATimeIsAskedForOrNot) {
  SourceOptions second;
  second.time = 1;
  // The first time of one slice lies behind the second of the other.
  const TempFolder folder;
  write_moments(folder, 0x00181060, "DS", {{"0 ", 0, 1}, {"50", 0, 2}, {"55", 2, 3}, {"90", 2, 4}});
  for (const SourceOptions& options : {SourceOptions{}, second}) {
    expect_rejected(folder.path(), {"lie at the same position", "Trigger Time (0018,1060) is"},
                    options);
  }
  // One volume has one time.
  const TempFolder one;
  write_moments(one, 0x00181060, "DS", {{"0 ", 0, 1}, {"50", 2, 2}});
  EXPECT_TRUE(contains(source_error({one.path()}, second), "the source has 1 point in time"));
}

TEST(DicomTimes, AreNoneWhereAnotherSettingDiffers) {
  const TempFolder folder;
  for (int i = 0; i < 4; ++i) {
    DicomElements elements = ct_elements(5, 3, 8, i / 2 * 3);
    elements.set(0x00080032, "TM", i % 2 == 0 ? "100000" : "100005");
    elements.set(0x00180081, "DS", i % 2 == 0 ? "2 " : "10");
    elements.write(folder.file("s" + std::to_string(i)), kExplicitLittle);
  }
  EXPECT_TRUE(contains(source_error({folder.path()}), "Echo Time (0018,0081) is"));
}

TEST(DicomTimes, AreNoneWhereTheirNumbersContradictEachOther) {
  const TempFolder folder;
  for (int i = 0; i < 4; ++i) {
    DicomElements elements = ct_elements(5, 3, 8, i / 2 * 3);
    elements.set(0x00080032, "TM", i % 2 == 0 ? "100000" : "100005");
    elements.set(0x00181060, "DS", i % 2 == 0 ? "10.2" : i / 2 == 0 ? "20" : "30");
    elements.set(0x00200100, "IS", i == 1 ? "2 " : "1 ");
    elements.write(folder.file("s" + std::to_string(i)), kExplicitLittle);
  }
  EXPECT_TRUE(contains(source_error({folder.path()}), "Temporal Position Identifier (0020,0100)"));
}

/// Where a frame says when it was taken.
struct FrameTime {
  std::uint32_t sequence = 0;
  std::uint32_t tag = 0;
  const char* vr = "";
  std::vector<std::string> numbers;  ///< of two moments
  const char* told_by = "";
};

std::vector<FrameTime> frame_times() {
  const auto float64 = [](double value) { return bytes_of<double>({value}); };
  return {{0x00209111, 0x00209128, "UL",
           {bytes_of<std::uint32_t>({1}), bytes_of<std::uint32_t>({2})},
           "(Temporal Position Index (0020,9128): 1, 2)"},
          {0x00189118, 0x00209153, "FD", {float64(0), float64(412.5)},
           "(Nominal Cardiac Trigger Delay Time (0020,9153): 0, 412.5 ms)"},
          {0x00189118, 0x00209241, "FL", {bytes_of<float>({0}), bytes_of<float>({37.5F})},
           "(Nominal Percentage of Cardiac Phase (0020,9241): 0, 37.5 %)"},
          {0x00209111, 0x00189151, "DT", {"20200101100000.5", "20200101100002"},
           "(Frame Reference DateTime (0018,9151): 20200101100000.5, 20200101100002)"},
          {0x00209310, 0x0020930d, "FD", {float64(-0.25), float64(1.5)},
           "(Temporal Position Time Offset (0020,930d): -0.25, 1.5 s)"},
          {0x00209171, 0x00181060, "DS", {"9.5 ", "80"}, "(Trigger Time (0018,1060): 9.5, 80 ms)"},
          {0x00209171, 0x00541300, "DS", {"30000 ", "120000"},
           "(Frame Reference Time (0054,1300): 30000, 120000 ms)"}};
}

/// Frames of one value each, 1, 2, ..., that lie by twos 3 mm apart, each two of them of `moments`.
void write_frames(const std::string& path, const FrameTime& time,
                  const std::vector<std::size_t>& moments) {
  DicomElements elements = ct_elements(5, 3, 8);
  elements.set(0x00280008, "IS", std::to_string(moments.size()));
  std::string voxels;
  std::vector<DicomElements> frames;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    voxels += std::string(15, static_cast<char>(i + 1));
    DicomElements moment;
    moment.set(time.tag, time.vr, time.numbers[moments[i]]);
    DicomElements place;
    place.set(0x00200032, "DS", "0\\0\\" + std::to_string(i / 2 * 3));
    DicomElements orientation;
    orientation.set(0x00200037, "DS", "1\\0\\0\\0\\1\\0");
    DicomElements measures;
    measures.set(0x00280030, "DS", "1\\1");
    DicomElements& frame = frames.emplace_back();
    frame.set_items(time.sequence, {moment});
    frame.set_items(0x00209113, {place});
    frame.set_items(0x00209116, {orientation});
    frame.set_items(0x00289110, {measures});
  }
  elements.set(kPixelData, "OB", voxels);
  elements.set_items(0x52009230, frames);
  elements.write(path, kExplicitLittle);
}

TEST(DicomTimes, OfFramesAreThoseOfTheirGroups) {
  for (const FrameTime& time : frame_times()) {
    const TempFolder folder;
    const std::string path = folder.file("a.dcm");
    write_frames(path, time, {1, 0, 1, 0});
    const Error error = source_error({path});
    EXPECT_TRUE(contains(error, std::string("2 points in time ") + time.told_by)) << error.what();
    SourceOptions options;
    options.time = 0;
    EXPECT_EQ(voxels_of(*open_source({path}, options)), planes_of({2, 4})) << time.told_by;
    options.time = 1;
    EXPECT_EQ(voxels_of(*open_source({path}, options)), planes_of({1, 3})) << time.told_by;
  }
}

TEST(DicomTimes, OfFramesThatDoNotShareTheirPlacesAreNamed) {
  const TempFolder folder;
  const std::string path = folder.file("a.dcm");
  write_frames(path, frame_times()[1], {0, 1, 0});
  const Error error = source_error({path});
  EXPECT_TRUE(contains(error, "of several volumes: Nominal Cardiac Trigger Delay Time (0020,9153) "
                              "is 0 ms and 412.5 ms; not all of them have the same places"))
      << error.what();
}

TEST(DicomTimes, AreNotFoundInOneVolumeOrWhereSlicesAreMissing) {
  const TempFolder folder;
  // Two stations of one volume
  write_moments(folder, 0x00200012, "IS", {{"1", 0, 1}, {"1", 2, 2}, {"2", 4, 3}, {"2", 6, 4}});
  EXPECT_EQ(voxels_of(*open_source({folder.path()}, {})), planes_of({1, 2, 3, 4}));
  // A moment without its second slice
  const TempFolder cut;
  write_moments(cut, 0x00200100, "IS", {{"1", 0, 1}, {"1", 2, 2}, {"2", 0, 3}});
  EXPECT_TRUE(contains(source_error({cut.path()}), "Temporal Position Identifier (0020,0100) is"));
  // Two slices of one moment at one place
  const TempFolder twice;
  write_moments(twice, 0x00200100, "IS", {{"1", 0, 1}, {"1", 0, 2}, {"2", 0, 3}, {"2", 0, 4}});
  EXPECT_TRUE(contains(source_error({twice.path()}), "lie at the same position"));
}

TEST(DicomTimes, AreNoVolumesBesideOneAnother) {
  const TempFolder folder;
  write_moments(folder, 0x00200012, "IS",
                {{"1", 0, 1}, {"1", 2, 2}, {"2", 0, 3, 100}, {"2", 2, 4, 100}});
  const Error error = source_error({folder.path()});
  EXPECT_TRUE(contains(error, "100 mm apart sideways, and are of several volumes: Acquisition "
                              "Number (0020,0012) is 1 and 2; build each of them"))
      << error.what();
  // Apart by less than a pixel they are moments of one body.
  const TempFolder moved;
  write_moments(moved, 0x00200012, "IS",
                {{"1", 0, 1}, {"1", 2, 2}, {"2", 0, 3, 0.2}, {"2", 2, 4, 0.2}});
  EXPECT_TRUE(contains(source_error({moved.path()}), "2 points in time"));
}

}  // namespace
}  // namespace octavo::testing
