#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string_view>
#include <utility>

#include "octavo/io/export/export_target.h"

namespace octavo {

namespace {

constexpr std::int64_t kLongestNifti1Axis = 32767;

std::int16_t nifti_type(VoxelType type) {
  switch (type) {
    case VoxelType::uint8: return 2;
    case VoxelType::int16: return 4;
    case VoxelType::int32: return 8;
    case VoxelType::float32: return 16;
    case VoxelType::int8: return 256;
    case VoxelType::uint16: return 512;
    case VoxelType::uint32: return 768;
  }
  throw Error(ErrorKind::invalid_argument, "unknown voxel type");
}

/// A header of zeros into which little-endian numbers are put at their documented offsets.
class HeaderBlock {
 public:
  explicit HeaderBlock(std::size_t byte_count) : bytes_(byte_count, 0) {}

  void put_i16(std::size_t at, std::int64_t v) { put(at, static_cast<std::uint64_t>(v), 2); }
  void put_i32(std::size_t at, std::int64_t v) { put(at, static_cast<std::uint64_t>(v), 4); }
  void put_i64(std::size_t at, std::int64_t v) { put(at, static_cast<std::uint64_t>(v), 8); }
  void put_f32(std::size_t at, double v) {
    put(at, std::bit_cast<std::uint32_t>(static_cast<float>(v)), 4);
  }
  void put_f64(std::size_t at, double v) { put(at, std::bit_cast<std::uint64_t>(v), 8); }
  void put_text(std::size_t at, std::string_view text) {
    std::copy(text.begin(), text.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(at));
  }
  ByteString take() { return std::move(bytes_); }

 private:
  void put(std::size_t at, std::uint64_t value, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      bytes_[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
  }
  ByteString bytes_;
};

using Matrix3 = std::array<double, 9>;

/// NIfTI's world is RAS, ours LPS: the first two rows change sign.
Matrix3 ras_direction(const Geometry& geometry) {
  Matrix3 m = geometry.direction;
  for (std::size_t i = 0; i < 6; ++i) m[i] = -m[i] + 0.0;
  return m;
}

Point3 ras_origin(const Geometry& geometry) {
  const Point3& o = geometry.origin_mm;
  return {-o[0] + 0.0, -o[1] + 0.0, o[2]};
}

double determinant(const Matrix3& m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
         m[2] * (m[3] * m[7] - m[4] * m[6]);
}

bool is_orthonormal(const Matrix3& m) {
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = a; b < 3; ++b) {
      const double dot = m[a] * m[b] + m[3 + a] * m[3 + b] + m[6 + a] * m[6 + b];
      if (std::abs(dot - (a == b ? 1 : 0)) > 1e-5) return false;
    }
  }
  return true;
}

struct Quaternion {
  double b = 0;
  double c = 0;
  double d = 0;
  double qfac = 1;
};

/// The unit quaternion (a >= 0) of an orthonormal matrix; qfac -1 flips the third axis first.
/// Takes the largest of the four squared components as pivot, so that no small number is divided
/// by.
Quaternion quaternion_of(Matrix3 m) {
  Quaternion q;
  if (determinant(m) < 0) {
    q.qfac = -1;
    for (std::size_t i = 2; i < 9; i += 3) m[i] = -m[i];
  }
  const double aa = 1 + m[0] + m[4] + m[8];
  const double bb = 1 + m[0] - m[4] - m[8];
  const double cc = 1 - m[0] + m[4] - m[8];
  const double dd = 1 - m[0] - m[4] + m[8];
  double a = 0;
  if (aa >= bb && aa >= cc && aa >= dd) {
    a = std::sqrt(aa) / 2;
    q.b = (m[7] - m[5]) / (4 * a);
    q.c = (m[2] - m[6]) / (4 * a);
    q.d = (m[3] - m[1]) / (4 * a);
  } else if (bb >= cc && bb >= dd) {
    q.b = std::sqrt(bb) / 2;
    q.c = (m[1] + m[3]) / (4 * q.b);
    q.d = (m[2] + m[6]) / (4 * q.b);
    a = (m[7] - m[5]) / (4 * q.b);
  } else if (cc >= dd) {
    q.c = std::sqrt(cc) / 2;
    q.b = (m[1] + m[3]) / (4 * q.c);
    q.d = (m[5] + m[7]) / (4 * q.c);
    a = (m[2] - m[6]) / (4 * q.c);
  } else {
    q.d = std::sqrt(dd) / 2;
    q.b = (m[2] + m[6]) / (4 * q.d);
    q.c = (m[5] + m[7]) / (4 * q.d);
    a = (m[3] - m[1]) / (4 * q.d);
  }
  if (a < 0) {
    q.b = -q.b;
    q.c = -q.c;
    q.d = -q.d;
  }
  return q;
}

/// What both versions of the header say, in their common terms.
struct NiftiFacts {
  Matrix3 direction;
  Point3 origin{};
  bool has_sform = false;  ///< false: nothing says where the volume is
  bool has_qform = false;
  Quaternion quaternion;
  Rescale scl{0, 0};  ///< slope 0: no scaling
  int intent_code = 0;
  int units = 0;
};

NiftiFacts facts_of(const ExportPlan& plan) {
  constexpr int kIntentLabel = 1002;
  constexpr int kUnitsMm = 2;
  NiftiFacts facts;
  facts.direction = ras_direction(plan.geometry);
  if (plan.place_known) facts.origin = ras_origin(plan.geometry);
  facts.has_sform = plan.place_known;
  facts.has_qform = facts.has_sform && is_orthonormal(facts.direction);
  if (facts.has_qform) facts.quaternion = quaternion_of(facts.direction);
  if (plan.real_units) facts.scl = plan.rescale;
  if (plan.kind == VolumeKind::labels) facts.intent_code = kIntentLabel;
  if (plan.spacing_known) facts.units = kUnitsMm;
  return facts;
}

double sform(const ExportPlan& plan, const NiftiFacts& facts, std::size_t row, std::size_t column) {
  if (!facts.has_sform) return 0;
  if (column == 3) return facts.origin[row];
  return facts.direction[row * 3 + column] * plan.geometry.spacing_mm[column];
}

constexpr int kXformScanner = 1;

ByteString nifti1_header(const ExportPlan& plan) {
  const NiftiFacts facts = facts_of(plan);
  HeaderBlock block(352);
  block.put_i32(0, 348);
  block.put_text(38, "r");
  block.put_i16(40, 3);
  for (int axis = 0; axis < 3; ++axis) {
    block.put_i16(42 + 2 * static_cast<std::size_t>(axis), plan.size[axis]);
  }
  for (std::size_t i = 4; i < 8; ++i) block.put_i16(40 + 2 * i, 1);
  block.put_i16(68, facts.intent_code);
  block.put_i16(70, nifti_type(plan.type));
  block.put_i16(72, 8 * bytes_per_voxel(plan.type));
  block.put_f32(76, facts.quaternion.qfac);
  for (std::size_t a = 0; a < 3; ++a) block.put_f32(80 + 4 * a, plan.geometry.spacing_mm[a]);
  block.put_f32(108, 352);
  block.put_f32(112, facts.scl.slope);
  block.put_f32(116, facts.scl.intercept);
  block.put_text(123, std::string(1, static_cast<char>(facts.units)));
  block.put_i16(252, facts.has_qform ? kXformScanner : 0);
  block.put_i16(254, facts.has_sform ? kXformScanner : 0);
  block.put_f32(256, facts.quaternion.b);
  block.put_f32(260, facts.quaternion.c);
  block.put_f32(264, facts.quaternion.d);
  for (std::size_t row = 0; row < 3; ++row) {
    block.put_f32(268 + 4 * row, facts.origin[row]);
    for (std::size_t column = 0; column < 4; ++column) {
      block.put_f32(280 + 16 * row + 4 * column, sform(plan, facts, row, column));
    }
  }
  block.put_text(344, std::string_view("n+1\0", 4));
  return block.take();
}

ByteString nifti2_header(const ExportPlan& plan) {
  const NiftiFacts facts = facts_of(plan);
  HeaderBlock block(544);
  block.put_i32(0, 540);
  block.put_text(4, std::string_view("n+2\0\r\n\032\n", 8));
  block.put_i16(12, nifti_type(plan.type));
  block.put_i16(14, 8 * bytes_per_voxel(plan.type));
  block.put_i64(16, 3);
  for (int axis = 0; axis < 3; ++axis) {
    block.put_i64(24 + 8 * static_cast<std::size_t>(axis), plan.size[axis]);
  }
  for (std::size_t i = 4; i < 8; ++i) block.put_i64(16 + 8 * i, 1);
  block.put_f64(104, facts.quaternion.qfac);
  for (std::size_t a = 0; a < 3; ++a) block.put_f64(112 + 8 * a, plan.geometry.spacing_mm[a]);
  block.put_i64(168, 544);
  block.put_f64(176, facts.scl.slope);
  block.put_f64(184, facts.scl.intercept);
  block.put_i32(344, facts.has_qform ? kXformScanner : 0);
  block.put_i32(348, facts.has_sform ? kXformScanner : 0);
  block.put_f64(352, facts.quaternion.b);
  block.put_f64(360, facts.quaternion.c);
  block.put_f64(368, facts.quaternion.d);
  for (std::size_t row = 0; row < 3; ++row) {
    block.put_f64(376 + 8 * row, facts.origin[row]);
    for (std::size_t column = 0; column < 4; ++column) {
      block.put_f64(400 + 32 * row + 8 * column, sform(plan, facts, row, column));
    }
  }
  block.put_i32(500, facts.units);
  block.put_i32(504, facts.intent_code);
  return block.take();
}

}  // namespace

ByteString nifti_header(const ExportPlan& plan) {
  const std::int64_t longest = std::max({plan.size.x, plan.size.y, plan.size.z});
  return longest > kLongestNifti1Axis ? nifti2_header(plan) : nifti1_header(plan);
}

}  // namespace octavo
