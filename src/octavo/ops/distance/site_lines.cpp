#include "octavo/ops/distance/site_lines.h"

namespace octavo {

namespace {

/// What a voxel is to those of the other class beside it.
NearestSite as_site(const NearestSite& voxel) {
  NearestSite site;
  site.steps = {0, 0, 0};
  site.site_share = voxel.own_share();
  return site;
}

}  // namespace

SiteLine::SiteLine(std::int64_t longest, const Point3& weights, int axis)
    : weights_(weights),
      axis_(static_cast<std::size_t>(axis)),
      half_inverse_(static_cast<std::size_t>(longest) + 3),
      envelope_(static_cast<std::size_t>(longest) + 3) {
  for (std::size_t i = 1; i < half_inverse_.size(); ++i) {
    half_inverse_[i] = 1 / (2 * weights[axis_] * static_cast<double>(i));
  }
}

void SiteLine::begin(std::span<NearestSite> line) {
  const auto count = static_cast<std::int64_t>(line.size());
  const auto at = [&](std::int64_t i) -> NearestSite& { return line[static_cast<std::size_t>(i)]; };
  for (std::int64_t lo = 0; lo < count;) {
    std::int64_t hi = lo + 1;
    while (hi < count && at(hi).is_inside() == at(lo).is_inside()) ++hi;
    for (std::int64_t x = lo; x < hi; ++x) {
      const bool is_before = lo > 0 && (hi == count || x - lo + 1 <= hi - x);
      const std::int64_t site = is_before ? lo - 1 : hi;
      const bool is_there = lo > 0 || hi < count;
      at(x).steps = {is_there ? static_cast<std::int16_t>(site - x) : NearestSite::kNone, 0, 0};
      if (is_there) at(x).site_share = at(site).own_share();
    }
    lo = hi;
  }
}

void SiteLine::improve(std::span<NearestSite> line) {
  for (std::size_t lo = 0; lo < line.size();) {
    std::size_t hi = lo + 1;
    while (hi < line.size() && line[hi].is_inside() == line[lo].is_inside()) ++hi;
    improve_run(line, lo, hi);
    lo = hi;
  }
}

void SiteLine::add(double place, double height, const NearestSite& site) {
  double start = -1;
  while (count_ > 0) {
    const SiteParabola& last = envelope_[count_ - 1];
    const auto apart = static_cast<std::size_t>(place - last.place);
    start = 0.5 * (place + last.place) + (height - last.height) * half_inverse_[apart];
    if (start > last.start) break;
    --count_;
  }
  envelope_[count_] = {place, height, count_ == 0 ? -1 : start, site};
  ++count_;
}

void SiteLine::improve_run(std::span<NearestSite> line, std::size_t begin, std::size_t end) {
  count_ = 0;
  if (begin > 0) add(static_cast<double>(begin) - 1, 0, as_site(line[begin - 1]));
  for (std::size_t i = begin; i < end; ++i) {
    const NearestSite& voxel = line[i];
    if (!voxel.is_known()) continue;
    double height = 0;
    for (std::size_t a = 0; a < axis_; ++a) {
      const double steps = voxel.steps[a];
      height += weights_[a] * steps * steps;
    }
    add(static_cast<double>(i), height, voxel);
  }
  if (end < line.size()) add(static_cast<double>(end), 0, as_site(line[end]));
  if (count_ == 0) return;

  // The lowest one at each voxel.
  std::size_t lowest = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const auto place = static_cast<double>(i);
    while (lowest + 1 < count_ && envelope_[lowest + 1].start <= place) ++lowest;
    const SiteParabola& from = envelope_[lowest];
    NearestSite& voxel = line[i];
    voxel.steps = from.site.steps;
    voxel.steps[axis_] = static_cast<std::int16_t>(from.place - place);
    voxel.site_share = from.site.site_share;
  }
}

}  // namespace octavo
