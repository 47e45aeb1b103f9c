// When a length, an area or a volume counts as equal to the one that was asked for.
#pragma once

namespace octavo {

/// Relative. Spacings come from decimal fractions, from float32 (6e-8 of them) and from the lengths
/// of vectors; what is computed of them differs from what they mean by up to three times that.
inline constexpr double kSizeTolerance = 2.5e-7;

/// The largest size that counts as no more than `limit`; both in mm, mm2 or mm3.
constexpr double upper_limit(double limit) { return limit * (1 + kSizeTolerance); }

/// The smallest size that counts as no less than `limit`; both in mm, mm2 or mm3.
constexpr double lower_limit(double limit) { return limit * (1 - kSizeTolerance); }

}  // namespace octavo
