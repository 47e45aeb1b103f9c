// The search for the deviation at which a surface has no more triangles than a limit.
//
// A surface within a of one that is within b of the full one is within a + b of that: deviations
// add up. So the bound is loosened step by step, each time from the surface that the step before
// left, which takes ever less time; the sum doubles with each step. Where a step passes the limit,
// deviations between it and the one before are tried.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

namespace octavo {

/// Growth of the sum of deviations with each step.
inline constexpr double kLoosening = 2;
/// A step is stalled that leaves more than this share of the triangles; so many in a row are the
/// end: pieces and handles allow no fewer.
inline constexpr double kStalledShare = 0.99;
inline constexpr int kMostStalledSteps = 2;

/// What becomes of a surface that was tried.
enum class TrialFate {
  base,    ///< it has too many triangles: the next ones are made from it
  best,    ///< it has as few as asked, and is nearer than those before that have
  dropped  ///< others are nearer to the limit
};

/// Says what to try next. All deviations in the same unit.
class DeviationSearch {
 public:
  /// limit     triangles that the result may have at most
  /// first     the deviation to begin with, above 0
  /// farthest  sums at or above it say nothing any more
  DeviationSearch(std::uint64_t limit, double first, double farthest);

  /// The deviation to try from the base, which is the full surface at first; nothing at the end.
  std::optional<double> next() const;

  /// Takes the triangles of what was tried last.
  TrialFate found(std::uint64_t triangle_count);

  /// Of the best surface from the full one; nothing where none was found.
  std::optional<double> best_deviation() const;

  /// Triangles of the surface that has fewest.
  std::uint64_t fewest() const { return fewest_; }

 private:
  struct Trial {
    double sum = 0;  // of deviations, from the full surface
    std::uint64_t triangle_count = 0;
  };

  std::uint64_t limit_;
  double first_;
  double farthest_;
  double tried_ = 0;  // the sum of what is tried next; 0: nothing
  Trial base_{0, UINT64_MAX};
  std::optional<Trial> too_many_;  // the one nearest to the limit, from the base on
  std::optional<Trial> best_;
  std::uint64_t fewest_ = UINT64_MAX;
  int refinements_ = 0;
  int stalls_ = 0;  // steps in a row that took hardly any triangles away

  double between() const;
};

/// Tries until the search is at its end.
/// reduce  of a surface and a deviation: the reduced surface; count: its triangles
/// Returns the best surface and its deviation; nothing where none has as few as asked
template <class Surface, class Reduce, class Count>
std::optional<std::pair<Surface, double>> searched_surface(DeviationSearch& search,
                                                           const Surface& full,
                                                           const Reduce& reduce,
                                                           const Count& count) {
  std::optional<Surface> base;
  std::optional<Surface> best;
  while (const std::optional<double> deviation = search.next()) {
    Surface tried = reduce(base ? *base : full, *deviation);
    switch (search.found(count(tried))) {
      case TrialFate::base: base = std::move(tried); break;
      case TrialFate::best: best = std::move(tried); break;
      case TrialFate::dropped: break;
    }
  }
  if (!best) return std::nullopt;
  return std::pair{*std::move(best), *search.best_deviation()};
}

}  // namespace octavo
