#include "octavo/io/volumes/nifti_header.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <span>
#include <string_view>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/io/source/axis_check.h"
#include "octavo/io/source/described_source.h"
#include "octavo/io/source/header_bytes.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/source/voxel_stream.h"

namespace octavo {

namespace {

constexpr std::size_t kHeader1Bytes = 348;
constexpr std::size_t kHeader2Bytes = 540;
constexpr std::size_t kMagic1Offset = 344;
constexpr std::size_t kMagic2Offset = 4;
constexpr std::size_t kMagicBytes = 3;
constexpr std::uint64_t kExtenderBytes = 4;  // behind the header: whether extensions follow
constexpr double kFormTolerance = 1e-3;
constexpr double kFormDegrees = 0.1;
constexpr double kQuaternionExcess = 1e-5;  // what rounding may add to the square of a unit one
constexpr int kMeter = 1;
constexpr int kMillimeter = 2;
constexpr int kMicrometer = 3;

std::string_view magic_at(std::span<const std::byte> header, std::size_t offset) {
  return {reinterpret_cast<const char*>(header.data()) + offset, kMagicBytes};
}

void take_text(const HeaderBytes& read, std::size_t offset, std::size_t length, const char* name,
               NiftiHeader& h) {
  const std::string text = read.text(offset, length);
  if (text.find_first_not_of(' ') != std::string::npos) h.texts[name] = text;
}

NiftiHeader parse_version_1(const HeaderBytes& read) {
  NiftiHeader h;
  read.fill<std::int16_t>(40, h.dim);
  h.intent = read.at<std::int16_t>(68);
  h.datatype = read.at<std::int16_t>(70);
  h.voxel_bits = read.at<std::int16_t>(72);
  read.fill<float>(76, h.pixdim);
  constexpr float kMostOffset = 1e15F;
  const auto offset = read.at<float>(108);
  if (std::abs(offset) <= kMostOffset) h.voxel_offset = static_cast<std::int64_t>(offset);
  h.slope = static_cast<double>(read.at<float>(112));
  h.intercept = static_cast<double>(read.at<float>(116));
  h.spatial_unit = read.at<std::uint8_t>(123) & 7;
  h.qform_code = read.at<std::int16_t>(252);
  h.sform_code = read.at<std::int16_t>(254);
  read.fill<float>(256, h.quaternion);
  read.fill<float>(268, h.qoffset);
  read.fill<float>(280, h.srow);
  take_text(read, 4, 10, "data_type", h);
  take_text(read, 14, 18, "db_name", h);
  take_text(read, 148, 80, "descrip", h);
  take_text(read, 228, 24, "aux_file", h);
  take_text(read, 328, 16, "intent_name", h);
  return h;
}

NiftiHeader parse_version_2(const HeaderBytes& read) {
  NiftiHeader h;
  h.version = 2;
  h.datatype = read.at<std::int16_t>(12);
  h.voxel_bits = read.at<std::int16_t>(14);
  read.fill<std::int64_t>(16, h.dim);
  read.fill<double>(104, h.pixdim);
  h.voxel_offset = read.at<std::int64_t>(168);
  h.slope = read.at<double>(176);
  h.intercept = read.at<double>(184);
  h.qform_code = read.at<std::int32_t>(344);
  h.sform_code = read.at<std::int32_t>(348);
  read.fill<double>(352, h.quaternion);
  read.fill<double>(376, h.qoffset);
  read.fill<double>(400, h.srow);
  h.spatial_unit = read.at<std::int32_t>(500) & 7;
  h.intent = read.at<std::int32_t>(504);
  take_text(read, 240, 80, "descrip", h);
  take_text(read, 320, 24, "aux_file", h);
  take_text(read, 508, 16, "intent_name", h);
  return h;
}

/// A 3x4 matrix from index to world in RAS and the header's unit.
using Affine = std::array<double, 12>;

/// Takes an sform that says nothing for none.
void pass_over_void_sform(NiftiHeader& h) {
  if (h.sform_code <= 0) return;
  const auto is_zero_axis = [&](std::size_t axis) {
    return h.srow[axis] == 0 && h.srow[4 + axis] == 0 && h.srow[8 + axis] == 0;
  };
  if (!std::ranges::all_of(h.srow, [](double value) { return std::isfinite(value); })) {
    h.sform_fault = "has numbers that are not finite";
  } else if (is_zero_axis(0) && is_zero_axis(1) && is_zero_axis(2)) {
    h.sform_fault = "is all zeros";
  }
  if (!h.sform_fault.empty()) h.sform_code = 0;
}

/// True when the header counts the axis: a 2-D image has no third one.
bool counts_axis(const NiftiHeader& h, std::size_t axis) {
  return static_cast<std::int64_t>(axis) < h.dim[0];
}

/// b^2 + c^2 + d^2, which a rotation leaves at or below 1.
double quaternion_square(const NiftiHeader& h) {
  const auto& [b, c, d] = h.quaternion;
  return b * b + c * c + d * d;
}

bool is_rotation(const NiftiHeader& h) { return quaternion_square(h) <= 1 + kQuaternionExcess; }

/// Requires is_rotation(h). An axis without a length in pixdim gets length 1.
Affine qform_affine(const NiftiHeader& h) {
  auto [b, c, d] = h.quaternion;
  const double square = quaternion_square(h);
  const double a = std::sqrt(std::max(0.0, 1.0 - square));
  for (double* part : {&b, &c, &d}) *part /= std::sqrt(std::max(1.0, square));
  const double qfac = h.pixdim[0] < 0 ? -1.0 : 1.0;
  const std::array<double, 9> r = {
      a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c),
      2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b),
      2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c};
  Affine m{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double sign = axis == 2 ? qfac : 1.0;
      const double length = std::abs(h.pixdim[axis + 1]);
      m[row * 4 + axis] = r[row * 3 + axis] * sign * (length > 0 ? length : 1.0);
    }
    m[row * 4 + 3] = h.qoffset[row];
  }
  return m;
}

double column_length(const Affine& m, std::size_t axis) {
  return std::sqrt(m[axis] * m[axis] + m[4 + axis] * m[4 + axis] + m[8 + axis] * m[8 + axis]);
}

void take_affine(const Affine& m, double unit_mm, Geometry& geometry) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length = column_length(m, axis);
    geometry.spacing_mm[axis] = length * unit_mm;
    for (std::size_t row = 0; row < 3; ++row) {
      const double to_lps = row < 2 ? -1.0 : 1.0;
      const double value = to_lps * m[row * 4 + axis] / length;
      geometry.direction[row * 3 + axis] = value == 0 ? 0.0 : value;
    }
  }
  for (std::size_t row = 0; row < 3; ++row) {
    const double value = (row < 2 ? -1.0 : 1.0) * m[row * 4 + 3] * unit_mm;
    geometry.origin_mm[row] = value == 0 ? 0.0 : value;
  }
}

/// Spacing, origin and directions by the qform. Where pixdim has no length, the spacing is 1 mm
/// along an axis that the header does not count and otherwise 0, which no volume can have.
/// Requires is_rotation(h).
Geometry qform_geometry(const NiftiHeader& h, double unit_mm) {
  Geometry geometry;
  take_affine(qform_affine(h), unit_mm, geometry);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::abs(h.pixdim[axis + 1]) > 0) continue;
    geometry.spacing_mm[axis] = counts_axis(h, axis) ? 0 : 1;
  }
  return geometry;
}

/// The sform; a third axis that the header does not count may lack there: it gets 1 mm along the
/// normal of the plane.
Affine sform_affine(const NiftiHeader& h, double unit_mm) {
  Affine m = h.srow;
  if (counts_axis(h, 2) || column_length(m, 2) > 0) return m;
  const Point3 normal = {m[4] * m[9] - m[8] * m[5], m[8] * m[1] - m[0] * m[9],
                         m[0] * m[5] - m[4] * m[1]};
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  for (std::size_t row = 0; row < 3; ++row) m[row * 4 + 2] = normal[row] / length / unit_mm;
  return m;
}

/// The factor to millimeters; an unknown unit counts as one.
double form_unit_in_mm(int spatial_unit) {
  return spatial_unit == kMeter ? 1000.0 : spatial_unit == kMicrometer ? 0.001 : 1.0;
}

/// The largest angle between axes of the same number, in degrees.
double largest_angle(const Geometry& a, const Geometry& b) {
  double largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double dot = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      dot += a.direction[row * 3 + axis] * b.direction[row * 3 + axis];
    }
    largest = std::max(largest, std::acos(std::clamp(dot, -1.0, 1.0)));
  }
  return largest * 180 / std::numbers::pi;
}

std::string point_text(const Point3& point) {
  return precise_text(point[0]) + ", " + precise_text(point[1]) + ", " + precise_text(point[2]);
}

/// What two geometries say differently, the values of both; empty where they agree.
std::string difference(const Geometry& sform, const Geometry& qform) {
  bool spacing_differs = false;
  bool origin_differs = false;
  const double minimum = *std::min_element(sform.spacing_mm.begin(), sform.spacing_mm.end());
  const double origin_mm = std::max(kFormTolerance * minimum, std::min(0.01, 0.1 * minimum));
  for (std::size_t i = 0; i < 3; ++i) {
    const double s = sform.spacing_mm[i];
    spacing_differs = spacing_differs || std::abs(s - qform.spacing_mm[i]) > kFormTolerance * s;
    origin_differs =
        origin_differs || std::abs(sform.origin_mm[i] - qform.origin_mm[i]) > origin_mm;
  }
  std::string text;
  if (spacing_differs) {
    text += "spacing " + point_text(sform.spacing_mm) + " mm by the sform, " +
            point_text(qform.spacing_mm) + " mm by the qform";
  }
  if (const double degrees = largest_angle(sform, qform); degrees > kFormDegrees) {
    text += (text.empty() ? "" : "; ") + std::string("axes ") + precise_text(degrees) +
            " degrees apart";
  }
  if (origin_differs) {
    text += (text.empty() ? "" : "; ") + std::string("origin ") + point_text(sform.origin_mm) +
            " mm by the sform, " + point_text(qform.origin_mm) + " mm by the qform (LPS)";
  }
  return text;
}

/// Tells where the qform says otherwise than the sform, which is used.
void note_disagreement(const NiftiHeader& h, const Geometry& sform, double unit_mm,
                       std::vector<Warning>& warnings) {
  const std::string what =
      is_rotation(h) ? difference(sform, qform_geometry(h, unit_mm))
                     : "the quaternion of the qform, b^2 + c^2 + d^2 = " +
                           precise_text(quaternion_square(h)) + ", is no rotation";
  if (what.empty()) return;
  warnings.push_back("sform and qform of the header disagree (" + what + "): the sform is used");
}

void require_rotation(const NiftiHeader& h, const std::string& path) {
  if (is_rotation(h)) return;
  reject(path, "the qform of the header is no rotation: b^2 + c^2 + d^2 of its quaternion is " +
                   precise_text(quaternion_square(h)) +
                   ", at most 1 expected; repair the header, or give it an sform");
}

/// Rejects an sform that no grid can have: a missing axis, shear.
void require_grid(const Geometry& geometry, const std::string& path) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (geometry.spacing_mm[axis] > 0) continue;
    reject(path, std::string("the sform of the header gives axis ") + axis_name(axis) +
                     " no length, and there is no qform; repair the header");
  }
  reject_shear(geometry, "the sform of the header, which has no qform", path);
}

}  // namespace

bool begins_as_nifti_header(const std::string& path) {
  VoxelStream stream(path, 0, is_gzip_file(path) ? StreamCoding::deflated : StreamCoding::plain);
  std::array<std::byte, kMagic2Offset + kMagicBytes> bytes{};
  stream.read(bytes);
  for (const bool big_endian : {false, true}) {
    const auto length = HeaderBytes(bytes, big_endian).at<std::int32_t>(0);
    if (length == static_cast<std::int32_t>(kHeader1Bytes)) return true;
    const std::string_view magic = magic_at(bytes, kMagic2Offset);
    if (length == static_cast<std::int32_t>(kHeader2Bytes) && (magic == "n+2" || magic == "ni2")) {
      return true;
    }
  }
  return false;
}

NiftiHeader read_nifti_header(const std::string& path) {
  const bool deflated = is_gzip_file(path);
  VoxelStream stream(path, 0, deflated ? StreamCoding::deflated : StreamCoding::plain);
  std::array<std::byte, kHeader2Bytes> bytes{};
  const std::span<std::byte> all(bytes);
  if (const std::uint64_t size = SourceFile(path).size(); !deflated && size < kHeader1Bytes) {
    reject(path, "not a NIfTI file: its header alone takes 348 bytes, the file has " +
                     std::to_string(size) + "; check what it is, or copy it again from its origin");
  }
  stream.read(all.first(kHeader1Bytes));
  for (const bool big_endian : {false, true}) {
    const HeaderBytes read(bytes, big_endian);
    const auto length = read.at<std::int32_t>(0);
    const std::string_view magic1 = magic_at(bytes, kMagic1Offset);
    const std::string_view magic2 = magic_at(bytes, kMagic2Offset);
    NiftiHeader header;
    if (length == static_cast<std::int32_t>(kHeader1Bytes)) {
      if (magic1 != "n+1" && magic1 != "ni1") {
        reject(path, "an Analyze 7.5 header, which does not say where left and right are; convert "
                     "it to NIfTI with a program that knows its origin");
      }
      header = parse_version_1(read);
      header.is_pair = magic1 == "ni1";
    } else if (length == static_cast<std::int32_t>(kHeader2Bytes) &&
               (magic2 == "n+2" || magic2 == "ni2")) {
      stream.read(all.subspan(kHeader1Bytes));
      header = parse_version_2(read);
      header.is_pair = magic2 == "ni2";
    } else {
      continue;
    }
    header.big_endian = big_endian;
    pass_over_void_sform(header);
    if (header.is_pair) {
      const auto taken = static_cast<std::uint64_t>(length);
      const std::uint64_t left = deflated ? stream.finish() : SourceFile(path).size() - taken;
      header.is_extended = left > kExtenderBytes;
    }
    return header;
  }
  reject(path, "not a NIfTI file: the header says it is neither 348 nor 540 bytes long; check "
               "what the file is");
}

std::string nifti_type_name(std::int64_t datatype) {
  static const std::map<std::int64_t, std::string> kNames = {
      {1, "1 bit"},           {32, "complex 64 bit"},    {64, "float 64 bit"},
      {128, "RGB color"},    {1024, "int 64 bit"},      {1280, "unsigned int 64 bit"},
      {1536, "float 128 bit"}, {1792, "complex 128 bit"}, {2048, "complex 256 bit"},
      {2304, "RGBA color"}};
  const auto found = kNames.find(datatype);
  return found == kNames.end() ? "type code " + std::to_string(datatype) : found->second;
}

bool nifti_geometry(const NiftiHeader& h, const std::string& path, Geometry& geometry,
                    std::vector<Warning>& warnings) {
  if (h.spatial_unit != kMeter && h.spatial_unit != kMillimeter && h.spatial_unit != kMicrometer) {
    warnings.emplace_back(
        "the header does not name the unit of its lengths, millimeters are assumed", "spacing_mm");
  }
  if (!h.sform_fault.empty()) {
    warnings.push_back("the sform of the header " + h.sform_fault + ": it is not used");
  }
  const double unit_mm = form_unit_in_mm(h.spatial_unit);
  Geometry sform;
  take_affine(sform_affine(h, unit_mm), unit_mm, sform);
  const bool is_sform_usable = h.sform_code > 0 && is_perpendicular(sform);
  if (h.qform_code > 0 && !is_sform_usable) {
    if (h.sform_code > 0) {
      warnings.push_back("the sform of the header is sheared: the qform is used");
    }
    require_rotation(h, path);
    geometry = qform_geometry(h, unit_mm);
    return true;
  }
  if (h.sform_code > 0) {
    geometry = sform;
    if (!is_sform_usable) require_grid(geometry, path);
    if (h.qform_code > 0) note_disagreement(h, geometry, unit_mm, warnings);
    return true;
  }
  warnings.push_back(
      "the header does not say where left and right are: the file's axes are taken as LPS");
  bool known = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double mm = std::abs(h.pixdim[axis + 1]) * unit_mm;
    known = known && (!counts_axis(h, axis) || mm > 0);
    geometry.spacing_mm[axis] = mm > 0 ? mm : 1;
  }
  return known;
}

}  // namespace octavo
