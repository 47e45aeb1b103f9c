#include "octavo/codec/grey_codec.h"

#include "octavo/codec/grey_brick.h"

namespace octavo::grey {

namespace {

std::uint64_t stored_bytes(const SampleScale& scale, const Size3& size) {
  return (static_cast<std::uint64_t>(size.voxel_count()) *
              static_cast<std::uint64_t>(scale.plain_width()) + 7) / 8;
}

/// Samples as plain bits above the smallest one.
template <class Sample>
Bytes encode_plain(const SampleScale& scale, const std::vector<Sample>& samples) {
  Bytes out;
  BitWriter bits(out);
  for (const Sample s : samples) {
    bits.put(static_cast<std::uint64_t>(s - scale.min_sample()), scale.plain_width());
  }
  bits.finish();
  return out;
}

template <class Sample>
std::vector<Sample> decode_plain(const SampleScale& scale, ByteSpan bytes, const Size3& size) {
  if (bytes.size() != stored_bytes(scale, size)) {
    throw Error(ErrorKind::corrupt, "plain samples: " + std::to_string(bytes.size()) + " bytes, " +
                                        std::to_string(stored_bytes(scale, size)) + " expected");
  }
  std::vector<Sample> samples(static_cast<std::size_t>(size.voxel_count()));
  BitReader bits(bytes);
  for (Sample& s : samples) {
    const auto above = static_cast<std::int64_t>(bits.get(scale.plain_width()));
    s = static_cast<Sample>(std::min(scale.min_sample() + above, scale.max_sample()));
  }
  return samples;
}

/// The segment of in-brick level 1 starts with the cell flags: a varint of their length, then the
/// bytes.
void put_cells(Bytes& segment, const BrickShape& shape, int level, const UniformCells& cells) {
  if (level != 1 || !has_cells(shape)) return;
  const Bytes flags = encode_cells(cells);
  put_varint(segment, flags.size());
  segment.insert(segment.end(), flags.begin(), flags.end());
}

template <class Sample>
EncodedBrick encode_samples(const Model& model, const BrickShape& shape,
                            const AnalyzedBrick<Sample>& brick) {
  EncodedBrick result;
  result.range = brick.scale.range;
  result.parent = brick.parent;
  result.segments.resize(static_cast<std::size_t>(shape.level_count));
  result.segments.back() = encode_plain(brick.scale, brick.coarsest);

  Workspace<Sample>& work = thread_workspace<Sample>();
  load_means(work, brick.coarsest.data(),
             shape.size[static_cast<std::size_t>(shape.level_count) - 1]);
  std::vector<Symbol> symbols;
  for (int level = shape.level_count - 2; level >= 0; --level) {
    const auto slot = static_cast<std::size_t>(level);
    symbols.clear();
    run_level(work, shape, brick.scale, model.parameters.predictor, level, brick.cells_or_null(),
              [&](const Stage& stage, const Split& split) {
                const auto& samples = brick.steps[slot][static_cast<std::size_t>(split.axis)];
                const StagePasses<Sample>& passes = stage_functions().of<Sample>();
                load_details(work, stage, Truth<Sample>{samples.data(), split.fine_size});
                passes.predict(model.parameters, stage, work);
                passes.list_symbols(model.parameters, stage, work, symbols);
              });
    put_cells(result.segments[slot], shape, level, brick.cells);
    if (symbols.empty()) continue;
    const Bytes coded = encode_symbols(model, table_set(level), symbols, brick.scale.shift());
    result.segments[slot].insert(result.segments[slot].end(), coded.begin(), coded.end());
  }
  return result;
}

/// A brick that coding would enlarge is stored: all voxels plain in segment 0, the other segments
/// empty.
template <class Sample>
void store_if_smaller(EncodedBrick& encoded, const BrickShape& shape, const BrickView& view,
                      const AnalyzedBrick<Sample>& brick) {
  std::uint64_t coded = 0;
  for (const Bytes& segment : encoded.segments) coded += segment.size();
  if (shape.level_count == 1 || coded < stored_bytes(brick.scale, shape.size[0])) return;
  BrickShape flat = shape;
  flat.level_count = 1;
  for (Bytes& segment : encoded.segments) segment.clear();
  encoded.segments[0] =
      encode_plain(brick.scale, analyze<Sample>(flat, view, encoded.range).coarsest);
}

template <class T, class Sample>
void write_out(const Sample* samples, std::int64_t count, const SampleScale& scale, T* out) {
  if constexpr (std::is_integral_v<T> && sizeof(T) <= sizeof(Sample)) {
    // Voxels are sums modulo their type.
    using Unsigned = std::make_unsigned_t<T>;
    const auto base = static_cast<Unsigned>(scale.base());
    for (std::int64_t i = 0; i < count; ++i) {
      out[i] = static_cast<T>(static_cast<Unsigned>(static_cast<Unsigned>(samples[i]) + base));
    }
  } else {
    const std::int64_t base = scale.base();
    for (std::int64_t i = 0; i < count; ++i) out[i] = static_cast<T>(samples[i] + base);
  }
}

template <class Sample>
void write_grid(const SampleGrid<Sample>& grid, VoxelType type, const SampleScale& scale,
                void* out) {
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    T* to = static_cast<T*>(out);
    const Size3& size = grid.size();
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y, to += size.x)
        write_out(grid.row(y, z), size.x, scale, to);
    }
  });
}

template <class Sample>
void decode_stored(const BrickShape& shape, VoxelType type, const SampleScale& scale,
                   ByteSpan segment, int level, void* out) {
  std::vector<Sample> samples = decode_plain<Sample>(scale, segment, shape.size[0]);
  for (int i = 0; i < level; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    samples = coarser_level(std::move(samples), shape.size[slot], shape.halving[slot],
                            shape.first_level + i);
  }
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    write_out(samples.data(), static_cast<std::int64_t>(samples.size()), scale,
              static_cast<T*>(out));
  });
}

template <class Sample>
void decode_samples(const Model& model, const BrickShape& shape, VoxelType type,
                    const SampleScale& scale, std::span<const ByteSpan> segments, int level,
                    void* out) {
  const auto last = static_cast<std::size_t>(shape.level_count) - 1;
  const std::vector<Sample> coarsest =
      decode_plain<Sample>(scale, segments[last], shape.size[last]);
  Workspace<Sample>& work = thread_workspace<Sample>();
  load_means(work, coarsest.data(), shape.size[last]);
  UniformCells cells;
  for (int at = static_cast<int>(last) - 1; at >= level; --at) {
    ByteSpan segment = segments[static_cast<std::size_t>(at)];
    if (at == 1 && has_cells(shape)) {
      const std::uint64_t length = take_varint(segment);
      cells = decode_cells(take_bytes(segment, length), shape.size[2]);
    }
    const UniformCells* flagged = cells.flags.empty() ? nullptr : &cells;
    const std::int64_t details = level_detail_count(shape, scale, at, flagged);
    if (details == 0) {
      if (!segment.empty())
        throw Error(ErrorKind::corrupt, "a segment without details is not empty");
      run_level(work, shape, scale, Predictor::neighbours, at, flagged,
                [&](const Stage&, const Split&) {});
      continue;
    }
    SymbolReader symbols(model, table_set(at), segment, details, scale.shift());
    run_level(work, shape, scale, model.parameters.predictor, at, flagged,
              [&](const Stage& stage, const Split&) {
      stage_functions().of<Sample>().decode(model.parameters, stage, work, symbols);
    });
    symbols.finish();
  }
  write_grid(work.means, type, scale, out);
}

}  // namespace

GreyCodec::GreyCodec(const Parameters& parameters) {
  auto model = std::make_unique<Model>();
  model->parameters = parameters;
  build_tables(*model);
  model_ = std::move(model);
}

EncodedBrick GreyCodec::encode(const BrickShape& shape, const BrickView& view) const {
  const ValueRange range = range_of(view);
  if (range.min == range.max) {
    return {range, range.min, 0, std::vector<Bytes>(static_cast<std::size_t>(shape.level_count))};
  }
  return with_sample_type(SampleScale{range}, [&](auto sample) {
    using Sample = decltype(sample);
    const auto brick = analyze<Sample>(shape, view, range);
    EncodedBrick encoded = encode_samples(*model_, shape, brick);
    store_if_smaller(encoded, shape, view, brick);
    return encoded;
  });
}

void GreyCodec::decode(const BrickShape& shape, VoxelType type, const ValueRange& range,
                       std::span<const ByteSpan> segments, int level, void* out) const {
  const SampleScale scale{range};
  const std::int64_t count = shape.size[static_cast<std::size_t>(level)].voxel_count();
  if (range.min == range.max) {
    with_voxel_type(type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      std::fill_n(static_cast<T*>(out), count, static_cast<T>(range.min));
    });
    return;
  }
  with_sample_type(scale, [&](auto sample) {
    using Sample = decltype(sample);
    const bool is_stored = shape.level_count > 1 && segments.back().empty();
    const auto holds_bytes = [](ByteSpan segment) { return !segment.empty(); };
    if (is_stored && std::any_of(segments.begin() + 1, segments.end(), holds_bytes)) {
      throw Error(ErrorKind::corrupt, "a stored brick has more than one segment");
    }
    if (is_stored) decode_stored<Sample>(shape, type, scale, segments[0], level, out);
    else decode_samples<Sample>(*model_, shape, type, scale, segments, level, out);
  });
}

}  // namespace octavo::grey

namespace octavo {

std::unique_ptr<BrickCodec> parse_grey_model(VoxelType type, ByteSpan bytes) {
  if (!is_integer(type)) throw Error(ErrorKind::corrupt, "a grey model for float voxels");
  return std::make_unique<grey::GreyCodec>(grey::parse_parameters(bytes));
}

}  // namespace octavo
