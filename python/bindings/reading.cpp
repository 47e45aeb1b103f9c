#include "reading.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <cstring>
#include <mutex>
#include <span>
#include <tuple>
#include <vector>

#include "asked.h"
#include "octavo/core/sha256.h"
#include "octavo/core/url_text.h"
#include "octavo/file/parallel_read.h"
#include "octavo/file/storage/round_meter.h"
#include "octavo/file/storage/sparse_source.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/verify.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

/// Bytes that Python functions give, on whatever thread they are asked for: some at a time, and
/// those of a server all that a read needs in one call.
class PythonBytes final : public ByteSource {
 public:
  /// given  as OpenFile gets it
  PythonBytes(const nb::dict& given, std::shared_ptr<const Waiters> waiters)
      : read_at_(given["read_at"]),
        waiters_(std::move(waiters)),
        has_fetch_(waiters_ != nullptr),
        size_(asked_for<std::uint64_t>(given, "size")),
        name_(asked_for<std::string>(given, "name")) {
    if (!has_fetch_) return;
    fetch_ = given["fetch"];
    forget_ = given["forget"];
    using Answers = std::vector<std::pair<double, std::uint64_t>>;
    for (const auto& [seconds, bytes] : asked_for<Answers>(given, "answers")) {
      meter_.add(seconds, bytes);
    }
  }

  ~PythonBytes() override {
    const nb::gil_scoped_acquire acquire;
    read_at_.reset();
    fetch_.reset();
    forget_.reset();
  }

  std::uint64_t fetched_bytes_kept() const override {
    return has_fetch_ ? std::uint64_t{64} << 20 : 0;
  }

  std::uint64_t bytes_per_round() const override {
    const std::lock_guard guard(lock_);
    return meter_.bytes_per_round();
  }

  std::vector<ByteRange> missing(std::span<const ByteRange> ranges) const override {
    if (!has_fetch_) return {};
    const std::lock_guard guard(lock_);
    return kept_.missing(ranges);
  }

  std::shared_ptr<const void> hold(std::span<const ByteRange> ranges) const override {
    const std::lock_guard guard(lock_);
    return kept_.hold(ranges);
  }

  bool forget(std::span<const ByteRange> ranges) const override {
    if (!has_fetch_) return false;
    called(0, [&] { forget_(); });
    const std::lock_guard guard(lock_);
    kept_.drop(ranges);
    return true;
  }

  void fetch(std::span<const ByteRange> ranges) const override {
    const std::vector<ByteRange> wanted = missing(ranges);
    if (wanted.empty()) return;
    std::vector<std::uint64_t> offsets;
    std::vector<std::uint64_t> lengths;
    for (const ByteRange& range : wanted) {
      offsets.push_back(range.offset);
      lengths.push_back(range.length);
    }
    called(offsets.front(), [&] {
      const auto [brought, seconds, asked] = nb::cast<Brought>(fetch_(offsets, lengths));
      const std::lock_guard guard(lock_);
      meter_.add(seconds, asked);
      for (std::size_t i = 0; i < wanted.size(); ++i) {
        const auto bytes = nb::cast<nb::bytes>(brought[i]);
        if (bytes.size() != lengths[i]) {
          throw Error(ErrorKind::truncated, "ends early", name_, offsets[i] + bytes.size());
        }
        kept_.put(offsets[i],
                  {reinterpret_cast<const std::uint8_t*>(bytes.c_str()), bytes.size()});
      }
      kept_.shrink_to(fetched_bytes_kept());
    });
  }

  std::uint64_t size() const override { return size_; }
  const std::string& name() const override { return name_; }

  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    if (offset > size_ || out.size() > size_ - offset) {
      throw Error(ErrorKind::truncated, "ends early", name_, offset);
    }
    if (has_fetch_) {
      const std::lock_guard guard(lock_);
      if (kept_.read(offset, out)) return;
    }
    called(offset, [&] {
      const auto bytes = nb::cast<nb::bytes>(read_at_(offset, out.size()));
      if (bytes.size() != out.size()) {
        throw Error(ErrorKind::truncated, "ends early", name_, offset + bytes.size());
      }
      std::memcpy(out.data(), bytes.data(), out.size());
    });
  }

 private:
  using Brought = std::tuple<nb::list, double, std::uint64_t>;

  /// Runs `work` with the GIL; what Python raises becomes an Error, or ends the call of this
  /// thread.
  template <class Work>
  void called(std::uint64_t offset, Work&& work) const {
    const nb::gil_scoped_acquire acquire;
    try {
      work();
    } catch (const nb::python_error& error) {
      // Ctrl-C and the like are no failure of the file.
      if (!error.matches(PyExc_Exception)) {
        if (const Call* const call = current_call()) call->end_with_raised();
        throw Error(ErrorKind::cancelled, "stopped", name_);
      }
      if (waiters_ && waiters_->are_stopped()) {
        throw Error(ErrorKind::cancelled, "stopped", name_);
      }
      throw Error(ErrorKind::io, escaped(nb::str(error.value()).c_str()), name_, offset);
    }
  }

  nb::object read_at_;
  nb::object fetch_;
  nb::object forget_;
  std::shared_ptr<const Waiters> waiters_;
  bool has_fetch_;
  std::uint64_t size_;
  std::string name_;
  mutable std::mutex lock_;  // of kept_ and meter_
  mutable SparseBytes kept_;
  mutable RoundMeter meter_;
};

const CallWatcher& watcher() {
  static const CallWatcher kWatcher;
  return kWatcher;
}

ReaderOptions options_with(std::uint64_t cache_bytes) {
  ReaderOptions options;
  options.cache_bytes = cache_bytes;
  options.watcher = &watcher();
  return options;
}

nb::tuple level_facts(const FileReader& reader, int level) {
  const Levels& levels = reader.levels();
  const Geometry geometry = levels.geometry(reader.description().geometry, level);
  std::array<std::int64_t, 3> factor;
  for (int axis = 0; axis < 3; ++axis) {
    factor[static_cast<std::size_t>(2 - axis)] =
        std::int64_t{1} << levels.halving_count(level, axis);
  }
  return nb::make_tuple(zyx_of(levels.size(level)), zyx_of(geometry.spacing_mm),
                        zyx_of(geometry.origin_mm), factor,
                        zyx_of(brick_side_at(levels, level)));
}

nb::object real_end(const VolumeDescription& volume, std::int64_t code) {
  if (volume.is_unbounded(code)) return nb::float_(code > 0 ? INFINITY : -INFINITY);
  if (is_integer(volume.type)) return nb::int_(code);
  return nb::float_(volume.voxel_of(code));
}

nb::dict facts_of(const OpenFile& file) {
  const FileReader& reader = file.reader();
  const VolumeDescription& volume = reader.description();
  nb::list levels;
  for (int level = 0; level < reader.levels().count(); ++level) {
    levels.append(level_facts(reader, level));
  }
  nb::dict facts = volume_facts(volume);
  facts["kind"] = word_of(volume.kind);
  facts["levels"] = levels;
  facts["slope"] = volume.rescale.slope;
  facts["intercept"] = volume.rescale.intercept;
  facts["unit"] = volume.metadata.facts().unit;
  facts["min"] = real_end(volume, reader.range().min);
  facts["max"] = real_end(volume, reader.range().max);
  facts["max_error"] = reader.max_error();
  facts["detail_level"] = reader.detail_level();
  facts["file_bytes"] = reader.file_bytes();
  facts["voxels_sha256"] = hex_text(reader.voxel_digest());
  facts["format_version"] = reader.format_version();
  return facts;
}

using Writable = nb::ndarray<nb::c_contig, nb::device::cpu>;

void require_room(const FileReader& reader, const Box& box, const Writable& out) {
  const auto voxels = static_cast<std::uint64_t>(box.size().voxel_count());
  const auto bytes = static_cast<std::uint64_t>(bytes_per_voxel(reader.description().type));
  if (box.is_empty() || out.nbytes() != bytes * voxels) {
    throw Error(ErrorKind::invalid_argument, "out does not hold what the box has");
  }
}

void read_box(const OpenFile& file, const Zyx& start, const Zyx& stop, int level,
              const Writable& out, int threads) {
  const Box box{index_of(start), index_of(stop)};
  require_room(file.reader(), box, out);
  void* const voxels = out.data();
  Call call;
  // What was read before takes no thread of its own.
  const bool waits = file.waiters() && call.run([&] {
    return !file.reader().ranges_of(box, level).ranges.empty();
  });
  call.run_reading({waits ? file.waiters() : nullptr},
                   [&] { read_parallel(file.reader(), box, level, voxels, threads); });
}

/// The smallest and the largest voxel of each brick of level 0, as the index has them.
void read_brick_ranges(const OpenFile& file, nb::ndarray<double, nb::c_contig, nb::device::cpu> low,
                       nb::ndarray<double, nb::c_contig, nb::device::cpu> high) {
  const FileReader& reader = file.reader();
  const VolumeDescription& volume = reader.description();
  const Size3 grid = reader.levels().brick_grid(0);
  const auto count = static_cast<std::size_t>(grid.voxel_count());
  if (low.size() != count || high.size() != count) {
    throw Error(ErrorKind::invalid_argument, "out does not hold what the grid has");
  }
  double* lowest = low.data();
  double* highest = high.data();
  const auto end_of = [&](std::int64_t code) {
    return volume.is_unbounded(code) ? (code > 0 ? INFINITY : -INFINITY) : volume.voxel_of(code);
  };
  Call call;
  call.run_reading({file.waiters()}, [&] {
    visit_cells(box_of(grid), {1, 1, 1}, [&](const Index3& at) {
      const ValueRange range = reader.brick(0, at).range;
      *lowest++ = end_of(range.min);
      *highest++ = end_of(range.max);
      if (call.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      return true;
    });
  });
}

}  // namespace

OpenFile::OpenFile(const std::string& path, std::uint64_t cache_bytes) {
  Call call;
  call.run([&] {
    source_ = open_byte_source(local_storage(), path);
    reader_ = FileReader::open(source_, options_with(cache_bytes));
  });
}

OpenFile::OpenFile(const nb::dict& bytes, std::uint64_t cache_bytes) {
  if (bytes.contains("waiters")) waiters_ = asked_for<std::shared_ptr<Waiters>>(bytes, "waiters");
  source_ = std::make_shared<PythonBytes>(bytes, waiters_);
  Call call;
  call.run_reading({waiters_},
                   [&] { reader_ = FileReader::open(source_, options_with(cache_bytes)); });
}

void bind_reading(nb::module_& module) {
  module.def("public_name", &public_name, "url"_a);
  module.def("without_secrets", &without_secrets, "text"_a);
  nb::class_<Waiters>(module, "Waiters")
      .def(nb::init<>())
      .def("are_stopped", &Waiters::are_stopped);
  nb::class_<OpenFile>(module, "OpenFile")
      .def(nb::init<const std::string&, std::uint64_t>(), "path"_a, "cache_bytes"_a)
      .def(nb::init<const nb::dict&, std::uint64_t>(), "bytes"_a, "cache_bytes"_a)
      .def("facts", &facts_of)
      .def("read", &read_box, "start"_a, "stop"_a, "level"_a, "out"_a, "threads"_a)
      .def("read_brick_ranges", &read_brick_ranges, "low"_a, "high"_a);
}

}  // namespace octavo::python
