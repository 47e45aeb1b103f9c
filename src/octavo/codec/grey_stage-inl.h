// The body of a split, compiled once per instruction set. Include inside a namespace of its own
// after defining `Dot` there (see grey_stage_portable.cpp and grey_stage_simd.cpp).

template <class Int>
inline std::int32_t scaled_magnitude(Int value, int shift, std::int32_t most) {
  const Int magnitude = (value < 0 ? -value : value) >> shift;
  return magnitude > most ? most : static_cast<std::int32_t>(magnitude);
}

/// A Q12 sum to an integer; wraps like the sum itself.
template <class Int>
inline Int rounded_weights(Int sum) {
  using Unsigned = std::make_unsigned_t<Int>;
  return static_cast<Int>(static_cast<Unsigned>(sum) + (1u << (kWeightBits - 1))) >> kWeightBits;
}

/// Gradients of the means around every pair of a row, their activity class and the range limit.
template <class Sample>
void row_features(const Parameters& p, const Stage& stage, const SampleGrid<Sample>& means,
                  std::int64_t y, std::int64_t z, RowBuffers<Sample>& row) {
  using Int = Wide<Sample>;
  constexpr std::int64_t kSteps[3] = {1, SampleGrid<Sample>::kRow, SampleGrid<Sample>::kPlane};
  const std::int64_t along = kSteps[stage.axis];
  const std::int64_t across1 = kSteps[stage.axis == 0 ? 1 : 0];
  const std::int64_t across2 = kSteps[stage.axis == 2 ? 1 : 2];
  const Sample* m = means.row(y, z);
  const int shift = stage.shift;
  const auto min = static_cast<Int>(stage.min);
  const auto max = static_cast<Int>(stage.max);
  const std::int32_t threshold = p.activity_threshold;
  const int count = static_cast<int>(stage.pairs.x);
  const auto step = [shift](Int d) { return (d < 0 ? -d : d) >> shift; };
  const auto feature = [](Int sum) {
    return static_cast<std::int32_t>(sum < kMaxFeature ? sum : kMaxFeature);
  };
  for (int x = 0; x < count; ++x) {
    const Int c = m[x];
    const Int before = m[x - along] - c;
    const Int after = m[x + along] - c;
    // A damaged stream makes wide samples whose steps only Int can sum.
    const Int e0 = step(before) + step(after);
    const Int e1 = step(before + after);
    const Int e2 = step(m[x - across1] - c) + step(m[x + across1] - c) +
                   step(m[x - across2] - c) + step(m[x + across2] - c);
    const Int g = e0 + e2;
    row.activity[x] = static_cast<std::uint8_t>((g > 0) + (g >= threshold / 4) + (g >= threshold) +
                                                (g / 4 >= threshold));
    const Int room = c - min < max - c ? c - min : max - c;
    const Int limit = room > 0 ? 2 * room + 1 : 1;
    row.exact_limit[x] = limit;
    row.limit[x] = static_cast<std::int32_t>(limit >> shift);
    row.gradient_along[x] = feature(e0);
    row.curvature_along[x] = feature(e1);
    row.gradient_across[x] = feature(e2);
  }
}

/// Foreseen magnitude (Q8) to context: its half-octave, in a second bank where the range limits it.
inline std::uint8_t context_of(std::int32_t foreseen, std::int32_t limit) {
  const std::int32_t most = limit << 8;
  const bool is_limited = most < 2 * foreseen + 256;
  if (foreseen > most) foreseen = most;
  // The exponent and first mantissa bit of a float count half-octaves; 8 = 2^3 is number 0.
  const auto value = static_cast<float>(foreseen + 8);
  std::int32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  std::int32_t half_octave = (bits >> 22) - 260;
  if (half_octave > kMagnitudes - 1) half_octave = kMagnitudes - 1;
  return static_cast<std::uint8_t>(half_octave + (is_limited ? kMagnitudes : 0));
}

template <class Sample>
inline void row_contexts(const Parameters& p, const Stage& stage, const MagnitudeRows& near,
                         RowBuffers<Sample>& row) {
  const std::int32_t* w = p.context_weights[stage.group][stage.axis];
  const std::int16_t* s1 = near.sibling[0];
  const std::int16_t* s2 = near.sibling[1];
  const int count = static_cast<int>(stage.pairs.x);
  for (int x = 0; x < count; ++x) {
    std::int32_t t = w[0] * row.gradient_along[x] + w[1] * row.curvature_along[x] +
                     w[2] * row.gradient_across[x] + w[3] * s1[x] + w[4] * s2[x] + w[5];
    t += w[6] * near.up[x + 2] + w[7] * near.up[x - 2] + w[8] * near.up[x] +
         w[9] * near.up[x - 1] + w[10] * near.up[x + 1];
    t += w[11] * near.back[x] + w[12] * near.back[x - 1] + w[13] * near.back[x + 1];
    t += w[14] * near.back_up[x] + w[15] * near.back_down[x];
    row.context[x] = context_of(t, row.limit[x]);
  }
}

/// The rows of magnitudes around row (y, z) of the split along `axis`.
inline MagnitudeRows magnitude_rows(const SampleGrid<std::int16_t>* magnitudes, int axis,
                                    std::int64_t y, std::int64_t z, const std::int16_t* zeros) {
  const auto sibling = [&](int other, std::int64_t yy, std::int64_t zz) {
    const SampleGrid<std::int16_t>& grid = magnitudes[other];
    if (grid.size().voxel_count() == 0) return zeros;
    return grid.row(std::min(yy, grid.size().y - 1), std::min(zz, grid.size().z - 1));
  };
  MagnitudeRows near{{zeros, zeros}, nullptr, nullptr, nullptr, nullptr};
  if (axis == 1) near.sibling[0] = sibling(2, y, z / 2);
  if (axis == 0) {
    near.sibling[0] = sibling(1, y / 2, z);
    near.sibling[1] = sibling(2, y / 2, z / 2);
  }
  const SampleGrid<std::int16_t>& own = magnitudes[axis];
  near.up = y > 0 ? own.row(y - 1, z) : z > 0 ? own.row(y, z - 1) : zeros;
  near.back = z > 0 ? own.row(y, z - 1) : near.up;
  near.back_up = z > 0 && y > 0 ? own.row(y - 1, z - 1) : near.back;
  near.back_down = z > 0 && y + 1 < own.size().y ? own.row(y + 1, z - 1) : near.back;
  return near;
}

/// The cell flags along a row, or nullptr when none is set there.
inline const std::uint8_t* row_cells(const Stage& stage, std::int64_t y, std::int64_t z) {
  if (stage.cells == nullptr) return nullptr;
  const Size3& size = stage.cells->size;
  return stage.cells->flags.data() +
         ((z >> stage.cell_shift[2]) * size.y + (y >> stage.cell_shift[1])) * size.x;
}

/// Lists the coded pairs of a row.
template <class Sample>
inline int list_coded(const Stage& stage, const std::uint8_t* cells, RowBuffers<Sample>& row) {
  const int count = static_cast<int>(stage.pairs.x);
  int coded = 0;
  for (int x = 0; x < count; ++x) {
    row.order[coded] = static_cast<std::uint8_t>(x);
    coded += cells == nullptr || cells[x >> stage.cell_shift[0]] == 0;
  }
  return coded;
}

/// Magnitudes of the row just coded, with the margins that contexts look at.
template <class Sample>
inline void keep_magnitudes(std::int16_t* magnitudes, const RowBuffers<Sample>& row, int count,
                            int shift) {
  for (int x = 0; x < count; ++x) {
    magnitudes[x] =
        static_cast<std::int16_t>(scaled_magnitude(row.residual[x], shift, kMaxMagnitude));
  }
  magnitudes[-1] = magnitudes[-2] = magnitudes[0];
  magnitudes[count] = magnitudes[count + 1] = magnitudes[count - 1];
}

/// Runs a split. Mode supplies the residuals of a row (decoding) or learns them (encoding,
/// training):
///   take(row, coded)                 before reconstruction
///   detail(x, y, z, prediction, ..)  the detail of a coded pair; notes its residual in the row
///   put(row, coded)                  after reconstruction
template <int kAxis, class Sample, class Mode>
void run_split(const Parameters& p, const Stage& stage, Workspace<Sample>& work, Mode& mode) {
  using Int = Wide<Sample>;
  SampleGrid<std::int16_t>& own = work.magnitudes[kAxis];
  own.set_size(stage.pairs);
  if (stage.pairs.voxel_count() == 0) return;
  RowBuffers<Sample>& row = work.row;
  const int count = static_cast<int>(stage.pairs.x);
  constexpr std::int64_t kStep =
      kAxis == 0 ? 1 : kAxis == 1 ? SampleGrid<Sample>::kRow : SampleGrid<Sample>::kPlane;
  constexpr std::int64_t kStretch = kAxis == 0 ? 2 : 1;
  for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
    for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
      const std::uint8_t* cells = row_cells(stage, y, z);
      const int coded = list_coded(stage, cells, row);
      if (coded < count) std::fill_n(row.residual, count, Int{0});
      if (coded > 0) {
        row_features(p, stage, work.means, y, z, row);
        row_contexts(p, stage, magnitude_rows(work.magnitudes, kAxis, y, z, row.zeros + 4), row);
        mode.take(row, coded);
        Sample* const first = work.fine.row(kAxis == 1 ? 2 * y : y, kAxis == 2 ? 2 * z : z);
        Dot<kAxis, Sample> dot(first);
        for (int x = 0; x < count; ++x) {
          Sample* const at = first + kStretch * x;
          const Int mean = *at;
          Pair<Int> pair{mean, mean};
          if (cells == nullptr || cells[x >> stage.cell_shift[0]] == 0) {
            const Int sum = dot(at, p.weights[stage.group][kAxis][row.activity[x]]);
            Int prediction = rounded_weights(sum);
            const Int limit = row.exact_limit[x];
            prediction = prediction > limit ? limit : prediction < -limit ? -limit : prediction;
            pair = pair_of<Int>(mean, mode.detail(x, y, z, prediction, at, mean), stage.rounding);
          }
          at[0] = static_cast<Sample>(pair.a);
          at[kStep] = static_cast<Sample>(pair.b);
          dot.advance(static_cast<Sample>(pair.a), static_cast<Sample>(pair.b));
        }
        mode.put(row, coded, y, z);
      }
      keep_magnitudes(own.row(y, z), row, count, stage.shift);
    }
  }
}

template <class Sample, class Mode>
void run_stage(const Parameters& p, const Stage& stage, Workspace<Sample>& work, Mode& mode) {
  if (stage.axis == 0) run_split<0>(p, stage, work, mode);
  else if (stage.axis == 1) run_split<1>(p, stage, work, mode);
  else run_split<2>(p, stage, work, mode);
}

template <class Sample>
struct Decoding {
  using Int = Wide<Sample>;
  SymbolReader& symbols;
  RowBuffers<Sample>& row;
  void take(RowBuffers<Sample>& r, int coded) {
    symbols.take_row(r.context, r.order, coded, r.residual);
  }
  Int detail(int x, std::int64_t, std::int64_t, Int prediction, const Sample*, Int) const {
    // A true detail is within the limit; a damaged one is brought there, so that nothing overflows.
    const std::int64_t limit = row.exact_limit[x];
    const std::int64_t d = std::int64_t{prediction} + row.residual[x];
    return static_cast<Int>(d > limit ? limit : d < -limit ? -limit : d);
  }
  void put(RowBuffers<Sample>&, int, std::int64_t, std::int64_t) const {}
};

/// The true detail of pair (x, y, z) of a split along `axis`.
template <class Sample>
inline Wide<Sample> true_detail(const Truth<Sample>& truth, int axis, std::int64_t x,
                                std::int64_t y, std::int64_t z) {
  const std::int64_t step = axis == 0 ? 1 : axis == 1 ? truth.size.x : truth.size.x * truth.size.y;
  const std::int64_t fx = axis == 0 ? 2 * x : x;
  const std::int64_t fy = axis == 1 ? 2 * y : y;
  const std::int64_t fz = axis == 2 ? 2 * z : z;
  const Sample* a = truth.samples + (fz * truth.size.y + fy) * truth.size.x + fx;
  return static_cast<Wide<Sample>>(a[0]) - a[step];
}

template <class Sample>
struct Encoding {
  using Int = Wide<Sample>;
  const Truth<Sample>& truth;
  int axis;
  RowBuffers<Sample>& row;
  std::vector<Symbol>& symbols;
  void take(RowBuffers<Sample>&, int) const {}
  Int detail(int x, std::int64_t y, std::int64_t z, Int prediction, const Sample*, Int) {
    const Int d = true_detail(truth, axis, x, y, z);
    row.residual[x] = d - prediction;
    return d;
  }
  void put(RowBuffers<Sample>& r, int coded, std::int64_t, std::int64_t) {
    for (int i = 0; i < coded; ++i) {
      const int x = r.order[i];
      symbols.push_back({zigzag(r.residual[x]), r.context[x],
                         static_cast<std::uint8_t>(i % kMaxStates)});
    }
  }
};

template <class Sample>
void decode_stage(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                  SymbolReader& symbols) {
  Decoding<Sample> mode{symbols, work.row};
  run_stage(p, stage, work, mode);
}

template <class Sample>
void encode_stage(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                  const Truth<Sample>& truth, std::vector<Symbol>& symbols) {
  Encoding<Sample> mode{truth, stage.axis, work.row, symbols};
  run_stage(p, stage, work, mode);
}
