#include "octavo/mesh/orientation.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "octavo/core/vectors.h"

namespace octavo {

namespace {

constexpr double kRounding = 0x1p-53;  // of one operation, relative
constexpr double kPlaneBound = (7 + 56 * kRounding) * kRounding;
constexpr double kLineBound = (3 + 16 * kRounding) * kRounding;

/// A sum of doubles that do not overlap, the smallest first. Exact.
class Expansion {
 public:
  /// Adds sign * a * b * c. Requires floats, so that a * b is exact.
  void add_product(double sign, double a, double b, double c) {
    const double ab = sign * a * b;
    const double product = ab * c;
    add(std::fma(ab, c, -product));
    add(product);
  }

  int sign() const {
    for (std::size_t i = count_; i-- > 0;) {
      if (terms_[i] != 0) return terms_[i] > 0 ? 1 : -1;
    }
    return 0;
  }

 private:
  void add(double value) {
    double carry = value;
    for (std::size_t i = 0; i < count_; ++i) {
      const double sum = carry + terms_[i];
      const double other = sum - carry;
      terms_[i] = (carry - (sum - other)) + (terms_[i] - other);
      carry = sum;
    }
    terms_[count_++] = carry;
  }

  std::array<double, 48> terms_{};  // of 24 products, the most that are added
  std::size_t count_ = 0;
};

/// Adds sign * det(a, b, c).
void add_determinant(Expansion& to, double sign, const Point3& a, const Point3& b,
                     const Point3& c) {
  to.add_product(sign, a[0], b[1], c[2]);
  to.add_product(-sign, a[0], b[2], c[1]);
  to.add_product(sign, a[1], b[2], c[0]);
  to.add_product(-sign, a[1], b[0], c[2]);
  to.add_product(sign, a[2], b[0], c[1]);
  to.add_product(-sign, a[2], b[1], c[0]);
}

int exact_orientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  Expansion sum;
  add_determinant(sum, 1, a, b, c);
  add_determinant(sum, -1, b, c, d);
  add_determinant(sum, 1, c, d, a);
  add_determinant(sum, -1, d, a, b);
  return sum.sign();
}

}  // namespace

int orientation_of(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  const Point3 p = difference(a, d);
  const Point3 q = difference(b, d);
  const Point3 r = difference(c, d);
  const double qr0 = q[1] * r[2];
  const double rq0 = q[2] * r[1];
  const double qr1 = q[2] * r[0];
  const double rq1 = q[0] * r[2];
  const double qr2 = q[0] * r[1];
  const double rq2 = q[1] * r[0];
  const double determinant = p[0] * (qr0 - rq0) + p[1] * (qr1 - rq1) + p[2] * (qr2 - rq2);
  const double size = std::abs(p[0]) * (std::abs(qr0) + std::abs(rq0)) +
                      std::abs(p[1]) * (std::abs(qr1) + std::abs(rq1)) +
                      std::abs(p[2]) * (std::abs(qr2) + std::abs(rq2));
  if (determinant > kPlaneBound * size) return 1;
  if (-determinant > kPlaneBound * size) return -1;
  // Sides of voxels lie in planes across an axis.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (a[axis] == d[axis] && b[axis] == d[axis] && c[axis] == d[axis]) return 0;
  }
  return exact_orientation(a, b, c, d);
}

int turn_of(const Point3& a, const Point3& b, const Point3& c, int u, int v) {
  const auto i = static_cast<std::size_t>(u);
  const auto j = static_cast<std::size_t>(v);
  const double left = (a[i] - c[i]) * (b[j] - c[j]);
  const double right = (a[j] - c[j]) * (b[i] - c[i]);
  const double determinant = left - right;
  const double bound = kLineBound * (std::abs(left) + std::abs(right));
  if (determinant > bound) return 1;
  if (-determinant > bound) return -1;
  if (a[i] == c[i] && b[i] == c[i]) return 0;
  if (a[j] == c[j] && b[j] == c[j]) return 0;
  Expansion sum;
  sum.add_product(1, a[i], b[j], 1);
  sum.add_product(-1, a[j], b[i], 1);
  sum.add_product(1, b[i], c[j], 1);
  sum.add_product(-1, b[j], c[i], 1);
  sum.add_product(1, c[i], a[j], 1);
  sum.add_product(-1, c[j], a[i], 1);
  return sum.sign();
}

}  // namespace octavo
