// Source files written into a folder that vanishes, and what was read from them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/io/open_source.h"
#include "support/hints.h"

namespace octavo::testing {

/// A folder of its own, removed with all it holds.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  const std::string& path() const { return path_; }
  std::string file(const std::string& name) const;  ///< makes the folders of `name`

 private:
  std::string path_;
};

bool contains(const std::string& text, const std::string& part);
/// Of all that with_hints gives.
inline bool contains(const Error& error, const std::string& part) {
  return contains(with_hints(error), part);
}
inline bool contains(const Warning& warning, const std::string& part) {
  return contains(with_hints(warning), part);
}

void write_file(const std::string& path, const std::string& bytes);
std::string read_file(const std::string& path);
std::string gzip(const std::string& bytes);
std::string zlib_stream(const std::string& bytes);
/// Deflate without head and checksum.
std::string bare_deflate_stream(const std::string& bytes);

/// The bytes of values, in either order.
template <class T>
std::string bytes_of(const std::vector<T>& values, bool big_endian = false) {
  std::string bytes;
  for (const T& value : values) {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), &value, sizeof(T));
    for (std::size_t i = 0; i < sizeof(T); ++i) bytes += raw[big_endian ? sizeof(T) - 1 - i : i];
  }
  return bytes;
}

/// For volumes of 4 x 3 x 2 voxels; the smallest and the largest value among them.
inline const std::vector<std::int16_t> kStoredValues = {
    0,  1,  -2, 300, -32768, 32767, 6,  7,  8,  9,  10, 11,
    12, 13, 14, 15,  16,     17,    18, 19, 20, 21, 22, 23};

/// Files of `count` parts of the stored values, "p1.raw" and so on; `file_of` makes one of a part.
void write_parts(
    const TempFolder& folder, std::size_t count,
    const std::function<std::string(const std::string&)>& file_of = std::identity());

/// Values that hardly shrink.
std::string uneven_bytes(std::size_t count);

/// Bytes that grow by 7 from `start` on.
std::string counted(std::size_t bytes, int start);

/// All planes of a source as one byte string, native order.
std::string voxels_of(PlaneSource& source);

/// What is known of the place of the volume at `path`.
Geometry geometry_of(const std::string& path, const SourceOptions& options = {});
Point3 spacing_of(const std::string& path);
SourceOptions with_spacing(double x, double y, double z);

/// Empty where there is none.
std::string first_warning(const PlaneSource& source);

/// The error of `action`, which must throw octavo::Error.
Error error_of(const std::function<void()>& action);
/// The error of opening `paths` and reading every plane.
Error source_error(const std::vector<std::string>& paths, const SourceOptions& options = {});

/// Reading `path` ends in Error{source_rejected} that holds all of `words`.
void expect_rejected(const std::string& path, const std::vector<std::string>& words,
                     const SourceOptions& options = {});
/// So does reading the first bytes of `whole` under that name, however many they are.
void expect_every_truncation_rejected(const std::string& path, const std::string& whole);

using Matrix3 = std::array<double, 9>;

/// Files of 4 x 3 x 2 bytes: MetaImage of 1 x 1 x 2 mm and NRRD, each with `lines` in its header.
void write_meta(const std::string& path, const std::string& lines);
void write_nrrd(const std::string& path, const std::string& lines);

/// A NIfTI-1 header of 352 bytes with the voxel offset 352.
struct NiftiSample {
  std::vector<std::int16_t> size = {4, 3, 2};
  std::int16_t datatype = 4;
  std::int16_t bits = 0;  ///< 0: not said
  bool big_endian = false;
  float slope = 0;
  float intercept = 0;
  std::array<float, 12> srow = {2, 0, 0, 10, 0, 3, 0, 20, 0, 0, 4, 30};
  std::int16_t sform = 1;
  std::int16_t intent = 0;
};
std::string nifti_header(const NiftiSample& sample);

}  // namespace octavo::testing
