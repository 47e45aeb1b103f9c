#include "octavo/builder/tier_encoder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>

#include "octavo/core/error.h"
#include "octavo/file/layer_order.h"

namespace octavo {

namespace {

constexpr std::size_t kBricksPerThread = 4;

// The samples of an in-brick level that the reader's codec makes of what was encoded, dense
// [z][y][x].
std::vector<std::byte> decoded_voxels(const BrickCodec& decoder, const BrickShape& shape,
                                      const EncodedBrick& encoded, const BrickView& brick,
                                      int level = 0) {
  const Size3& size = shape.size[static_cast<std::size_t>(level)];
  const auto count = static_cast<std::size_t>(size.voxel_count());
  std::vector<std::byte> dense(count * static_cast<std::size_t>(bytes_per_voxel(brick.type)));
  if (encoded.range.min != encoded.range.max || !is_integer(brick.type)) {
    const std::vector<ByteSpan> segments(encoded.segments.begin(), encoded.segments.end());
    decoder.decode(shape, brick.type, encoded.range, segments, level, dense.data());
    return dense;
  }
  with_voxel_type(brick.type, [&](auto id) {
    using T = typename decltype(id)::type;
    std::fill_n(reinterpret_cast<T*>(dense.data()), count, static_cast<T>(encoded.range.min));
  });
  return dense;
}

// Calls `take(row of the brick, dense row)` for every row.
template <class T, class F>
void for_each_row_pair(const BrickView& brick, const void* dense, const F& take) {
  const auto* const voxels = static_cast<const T*>(brick.voxels);
  const auto* row = static_cast<const T*>(dense);
  for (std::int64_t z = 0; z < brick.size.z; ++z) {
    for (std::int64_t y = 0; y < brick.size.y; ++y, row += brick.size.x) {
      take(voxels + z * brick.plane_stride + y * brick.row_stride, row);
    }
  }
}

bool is_same(const BrickView& brick, const std::vector<std::byte>& dense) {
  return with_voxel_type(brick.type, [&](auto id) {
    using T = typename decltype(id)::type;
    const auto row_bytes = static_cast<std::size_t>(brick.size.x) * sizeof(T);
    bool same = true;
    for_each_row_pair<T>(brick, dense.data(), [&](const T* source, const T* found) {
      same = same && std::memcmp(source, found, row_bytes) == 0;
    });
    return same;
  });
}

// How far voxels lie from what they became.
struct VoxelErrors {
  std::int64_t largest = 0;
  double squared = 0;  // the sum of the squares
};

// Nothing when a voxel lies outside `range`: readers skip bricks by their range.
std::optional<VoxelErrors> integer_errors(const BrickView& brick,
                                          const std::vector<std::byte>& dense,
                                          const ValueRange& range) {
  return with_voxel_type(brick.type, [&](auto id) -> std::optional<VoxelErrors> {
    using T = typename decltype(id)::type;
    VoxelErrors errors;
    bool is_inside = true;
    for_each_row_pair<T>(brick, dense.data(), [&](const T* source, const T* found) {
      for (std::int64_t x = 0; x < brick.size.x; ++x) {
        const auto is = static_cast<std::int64_t>(found[x]);
        const std::int64_t difference = std::abs(static_cast<std::int64_t>(source[x]) - is);
        errors.largest = std::max(errors.largest, difference);
        errors.squared += static_cast<double>(difference) * static_cast<double>(difference);
        is_inside = is_inside && is >= range.min && is <= range.max;
      }
    });
    return is_inside ? std::optional(errors) : std::nullopt;
  });
}

// The largest difference between float voxels and those that the codes in `dense` stand for.
double float_error(const BrickView& floats, const std::vector<std::byte>& dense,
                   const SampleCoding& coding) {
  std::vector<float> voxels(static_cast<std::size_t>(floats.size.voxel_count()));
  decode_samples(coding, dense.data(), voxels);
  double largest = 0;
  for_each_row_pair<float>(floats, voxels.data(), [&](const float* source, const float* found) {
    for (std::int64_t x = 0; x < floats.size.x; ++x) {
      const double difference = static_cast<double>(source[x]) - static_cast<double>(found[x]);
      largest = std::max(largest, std::abs(difference));
    }
  });
  return largest;
}

std::string short_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

// The error of float voxels as the index holds it: in 1024ths of the bound, rounded up.
std::int64_t float_error_steps(double error, double bound) {
  constexpr double kSteps = 1024;
  return static_cast<std::int64_t>(std::min(std::ceil(error / (bound / kSteps)), kSteps));
}

std::string name_of(int tier, const Index3& brick) {
  return "brick (" + std::to_string(brick.x) + ", " + std::to_string(brick.y) + ", " +
         std::to_string(brick.z) + ") of tier " + std::to_string(tier);
}

}  // namespace

void fail_brick(int tier, const Index3& brick, const std::string& why) {
  throw Error(ErrorKind::internal, name_of(tier, brick) + " does not decode to its voxels" + why +
                                       "; please report it with the source");
}

Model make_model(std::unique_ptr<BrickCodec> codec, VoxelType type,
                 const std::optional<SampleCoding>& coding, int detail_level) {
  Model model;
  model.serialized = codec->serialized();
  try {
    model.decoder = parse_model(codec->kind(), type, coding, model.serialized, detail_level);
  } catch (const Error& error) {
    throw Error(ErrorKind::internal, "a model does not parse: " + error.detail());
  }
  model.encoder = std::move(codec);
  return model;
}

TierEncoder::TierEncoder(const Levels& levels, int tier, VoxelType type, Workers& workers,
                         BrickSink& sink, Progress& progress, const ErrorBound& bound)
    : levels_(levels),
      tier_(tier),
      type_(type),
      workers_(workers),
      sink_(sink),
      progress_(progress),
      bound_(bound),
      parents_(static_cast<std::size_t>(levels.brick_count(tier) * bytes_per_voxel(type))),
      slots_(kBricksPerThread * static_cast<std::size_t>(workers.count())) {}

TierEncoder::~TierEncoder() {
  std::unique_lock lock(mutex_);
  if (!works_.empty() && !failure_) {
    failure_ = std::make_exception_ptr(Error(ErrorKind::cancelled, "left before the end"));
  }
  workers_.wait(changed_, lock, [&] { return running_ == 0; });
}

void TierEncoder::restore_parents(std::span<const std::int64_t> parents) {
  if (layer_.empty()) layer_ = layer_order(levels_.brick_grid(tier_));
  for (const std::int64_t parent : parents) {
    Index3 brick = layer_[restored_ % layer_.size()];
    brick.z = static_cast<std::int64_t>(restored_ / layer_.size());
    store_parent(brick, parent);
    ++restored_;
  }
}

void TierEncoder::start(const Model& model, const VoxelBlock& block, bool brings_model,
                        std::function<void()> when_done) {
  Work work{model, block, brings_model, std::move(when_done), {}};
  work.bricks = block.band != nullptr ? block.band->bricks : bricks_of(levels_, tier_, block);
  work.first = block.band != nullptr ? block.band->first : 0;
  const Size3 grid = levels_.brick_grid(tier_);
  const std::int64_t planes = levels_.brick_side(tier_).z;
  work.all = static_cast<std::size_t>(grid.x * grid.y * ((block.size.z + planes - 1) / planes));
  const std::lock_guard lock(mutex_);
  works_.push_back(std::move(work));
  take_bricks();
  release_if_failed();
}

void TierEncoder::check() {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
}

void TierEncoder::finish() {
  std::unique_lock lock(mutex_);
  workers_.wait(changed_, lock,
                [&] { return running_ == 0 && (works_.empty() || failure_ != nullptr); });
  if (failure_) std::rethrow_exception(failure_);
}

void TierEncoder::encode(const Model& model, const VoxelBlock& block) {
  start(model, block, false, {});
  finish();
}

void TierEncoder::take_bricks() {
  for (Work& work : works_) {
    while (work.taken < work.bricks.size()) {
      const bool is_full = taken_ - kept_ == slots_.size() || running_ == workers_.count();
      if (is_full || failure_) return;
      const std::size_t place = work.taken++;
      const std::size_t number = taken_++;
      try {
        workers_.start([this, &work, place, number] { work_on(work, place, number); });
      } catch (...) {
        failure_ = std::current_exception();
        return;
      }
      ++running_;
    }
  }
}

void TierEncoder::work_on(const Work& work, std::size_t place, std::size_t number) {
  Slot slot{.is_ready = true, .encoded = {}, .failure = nullptr};
  try {
    if (progress_.is_cancelled()) {
      throw Error(ErrorKind::cancelled, "stopped while encoding bricks");
    }
    slot.encoded = encode_checked(work, place);
  } catch (...) {
    slot.failure = std::current_exception();
  }
  std::unique_lock lock(mutex_);
  slots_[number % slots_.size()] = std::move(slot);
  if (!is_keeping_) keep_ready(lock);
  --running_;
  take_bricks();
  release_if_failed();
  changed_.notify_all();
}

void TierEncoder::keep_ready(std::unique_lock<std::mutex>& lock) {
  is_keeping_ = true;
  while (!failure_ && slots_[kept_ % slots_.size()].is_ready) {
    Work& work = works_.front();
    Slot slot = std::exchange(slots_[kept_ % slots_.size()], {});
    lock.unlock();
    std::exception_ptr failure;
    try {
      keep(work, std::move(slot));
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    failure_ = failure_ ? failure_ : failure;
    if (failure) break;
    ++kept_;
    if (++work.kept == work.bricks.size()) {
      const std::function<void()> when_done = std::move(work.when_done);
      works_.pop_front();
      if (when_done) when_done();
    }
    take_bricks();
  }
  is_keeping_ = false;
}

void TierEncoder::release_if_failed() {
  if (!failure_ || running_ > 0) return;
  for (Work& work : works_) {
    if (const auto when_done = std::exchange(work.when_done, {})) when_done();
  }
}

EncodedBrick TierEncoder::encode_checked(const Work& work, std::size_t place) const {
  const Model& model = work.model;
  const VoxelBlock& block = work.block;
  const Index3& brick = work.bricks[place];
  const BrickShape shape = brick_shape(levels_, tier_, brick);
  const BrickView view = block.band != nullptr
                             ? block.band->views[place]
                             : view_of(block, levels_.brick_box(tier_, brick));
  EncodedBrick encoded = model.encoder->encode(shape, view);
  std::vector<std::byte> dense;
  try {
    dense = decoded_voxels(*model.decoder, shape, encoded, view);
  } catch (const Error& error) {
    fail_brick(tier_, brick, " (" + error.detail() + ")");
  }
  encoded.max_error = 0;
  if (!bound_.is_lossless()) {
    measure_errors(encoded, view, dense, brick);
    const int level = bound_.detail_level;
    if (!encoded.detailed.empty() &&
        decoded_voxels(*model.decoder, shape, encoded, view, level) != encoded.detailed) {
      fail_brick(tier_, brick, " of level " + std::to_string(level));
    }
    // The digests of planes are of voxels as readers will see them.
    if (block.band != nullptr) std::ranges::copy(dense, block.band->voxels[place].begin());
    else if (tier_ == 0) put_voxels(block, levels_.brick_box(tier_, brick), dense.data());
  } else if (!is_same(view, dense)) {
    fail_brick(tier_, brick, "");
  }
  encoded.detailed.clear();
  const bool has_band_floats = block.band != nullptr && !block.band->floats.empty();
  if (block.floats == nullptr && !has_band_floats) return encoded;

  const BrickView floats = has_band_floats ? block.band->float_views[place]
                                           : float_view_of(block, levels_.brick_box(tier_, brick));
  const double found = float_error(floats, dense, *bound_.coding);
  if (!(found <= bound_.voxels)) {
    throw Error(ErrorKind::source_rejected,
                name_of(tier_, brick) + " holds values so large that float32 cannot keep them " +
                    "within the max error")
        .with_field("max_error", short_text(bound_.proposal));
  }
  encoded.max_error = float_error_steps(found, bound_.voxels);
  return encoded;
}

// Of a brick that may differ from its voxels.
void TierEncoder::measure_errors(EncodedBrick& encoded, const BrickView& view,
                                 const std::vector<std::byte>& dense,
                                 const Index3& brick) const {
  const auto errors = integer_errors(view, dense, encoded.range);
  const bool is_bounded = bound_.detail_level == 0;
  if (!errors || (is_bounded && errors->largest > bound_.codes)) fail_brick(tier_, brick, "");
  encoded.max_error = errors->largest;
  encoded.squared_error = errors->squared;
}

void TierEncoder::keep(Work& work, Slot slot) {
  if (slot.failure) std::rethrow_exception(slot.failure);
  if (work.brings_model && work.number() == 0) sink_.add_model(work.model.serialized);
  const auto layer_bricks = static_cast<std::size_t>(levels_.brick_grid(tier_).x *
                                                     levels_.brick_grid(tier_).y);
  if (tier_ == 0 && (work.number() + 1) % layer_bricks == 0) add_plane_digests(work);
  sink_.add_brick(tier_, slot.encoded);
  store_parent(work.bricks[work.kept], slot.encoded.parent);
  if (work.brings_model && work.number() + 1 == work.all) sink_.end_group(work.block.crc);
  count_progress(work);
}

// Of the layer whose last brick is kept next.
void TierEncoder::add_plane_digests(const Work& work) {
  const Box layer = levels_.brick_box(tier_, work.bricks[work.kept]);
  const std::int64_t first = layer.lo.z - work.block.first_plane;
  if (work.block.band != nullptr) {
    if (work.block.band->digests.empty()) return;
    sink_.add_plane_digests(work.block.band->digests.subspan(
        static_cast<std::size_t>(first), static_cast<std::size_t>(layer.size().z)));
    return;
  }
  // The voxels of an exact coding are there themselves.
  const bool has_codes = bound_.coding && !bound_.coding->is_exact;
  const std::optional<SampleCoding> coding = has_codes ? bound_.coding : std::nullopt;
  sink_.add_plane_digests(plane_digests(work.block, first, layer.size().z, coding));
}

void TierEncoder::store_parent(const Index3& brick, std::int64_t parent) {
  const Size3 grid = levels_.brick_grid(tier_);
  const std::int64_t at = (brick.z * grid.y + brick.y) * grid.x + brick.x;
  with_voxel_type(type_, [&](auto id) {
    using T = typename decltype(id)::type;
    T value;
    if constexpr (std::is_integral_v<T>) value = static_cast<T>(parent);
    else value = std::bit_cast<T>(static_cast<std::uint32_t>(parent));
    std::memcpy(parents_.data() + at * static_cast<std::int64_t>(sizeof value), &value,
                sizeof value);
  });
}

void TierEncoder::count_progress(const Work& work) {
  // Planes of tier 0 count as work done; the tiers above it are too small to count.
  const std::int64_t planes = tier_ == 0 ? work.block.size.z : 0;
  const auto count = static_cast<std::int64_t>(work.all);
  const auto kept = static_cast<std::int64_t>(work.number());
  const std::int64_t units = (kept + 1) * planes / count - kept * planes / count;
  if (units > 0) progress_.advance(units);
}

}  // namespace octavo
