// The passes of a split over 16-bit samples for every instruction set that Highway knows, chosen at
// run time. Wide samples run on the portable passes.

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "octavo/codec/grey/edge_candidates.h"
#include "octavo/codec/grey/grey_portable.h"
#include "octavo/codec/simd_level.h"

#include "octavo/codec/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octavo/codec/grey/grey_stage_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off
#include "octavo/codec/grey/grey_edges-inl.h"
#include "octavo/codec/grey/grey_exact-inl.h"
#include "octavo/codec/grey/grey_planes-inl.h"
#include "octavo/codec/grey/grey_push-inl.h"
#include "octavo/codec/grey/grey_residuals-inl.h"
#include "octavo/codec/grey/grey_rows-inl.h"
#include "octavo/codec/grey/grey_symbols-inl.h"
#include "octavo/codec/grey/grey_waves-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace octavo::grey {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

StagePasses<std::int16_t> narrow_passes() { return portable_stage_functions().narrow; }
PushTokens push_pass() { return push_tokens; }

#else

struct Kernel {
  static void row_features(const Parameters& p, const Stage& stage,
                           Workspace<std::int16_t>& work, std::int64_t y, std::int64_t z) {
    features_of_row(p, stage, work, y, z);
  }
  static void close_row(RowMask coded, std::int64_t count, std::uint16_t* limits) {
    close_limits(coded, count, limits);
  }
  static void row_contexts(const Parameters& p, const Stage& stage, const MagnitudeRows& near,
                           const RowBuffers& row, std::uint16_t* contexts) {
    const std::int32_t* const weights = p.context_weights[stage.group][stage.axis];
    if (p.predictor == Predictor::means)
      contexts_of_row<false>(weights, stage, near, row, contexts);
    else contexts_of_row<true>(weights, stage, near, row, contexts);
  }
  static void take_row(SymbolReader& symbols, std::uint16_t* contexts, RowMask coded, int count,
                       std::int32_t* residuals) {
    take_residuals(symbols, contexts, coded, count, residuals);
  }
  static bool takes_planes(const Parameters& p, const Stage& stage) {
    return suits_planes(p, stage);
  }
  static void take_plane(const Parameters& p, const SplitTask<std::int16_t>& task,
                         std::int64_t z) {
    if (task.stage.axis == 0) decode_plane<0>(p, task, z);
    else if (task.stage.axis == 1) decode_plane<1>(p, task, z);
    else decode_plane<2>(p, task, z);
  }
  static void take_planes(const Parameters& p, std::span<const SplitTask<std::int16_t>> tasks,
                          std::int64_t z) {
    const int axis = tasks.front().stage.axis;
    if (axis == 0) decode_planes<0>(p, tasks, z);
    else if (axis == 1) decode_planes<1>(p, tasks, z);
    else decode_planes<2>(p, tasks, z);
  }
  static void give_plane(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                         std::int64_t z) {
    if (stage.axis == 0) predict_plane<0>(p, stage, work, z);
    else if (stage.axis == 1) predict_plane<1>(p, stage, work, z);
    else predict_plane<2>(p, stage, work, z);
  }
  static void keep_magnitudes(const std::int32_t* residuals, int count, int,
                              std::int16_t* magnitudes) {
    magnitudes_of_row(residuals, count, magnitudes);
  }
  static bool predicts_rows(const Parameters& p, const Stage& stage) {
    return p.predictor == Predictor::means || stage.step == 1;
  }
  static void predict_row(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                          std::int64_t y, std::int64_t z) {
    if (p.predictor == Predictor::means) reconstruct_row<true>(p, stage, work, y, z);
    else if (stage.axis == 0) predict_exact_row<0>(p, stage, work, y, z);
    else if (stage.axis == 1) predict_exact_row<1>(p, stage, work, y, z);
    else predict_exact_row<2>(p, stage, work, y, z);
  }
  template <bool kIsEncoding>
  static void reconstruct_row(const Parameters& p, const Stage& stage,
                              Workspace<std::int16_t>& work, std::int64_t y, std::int64_t z) {
    if (stage.axis == 0) reconstruct_from_means<0, kIsEncoding>(p, stage, work, y, z);
    else if (stage.axis == 1) reconstruct_from_means<1, kIsEncoding>(p, stage, work, y, z);
    else reconstruct_from_means<2, kIsEncoding>(p, stage, work, y, z);
  }
  static void write_row(const std::int32_t* residuals, const std::uint16_t* contexts, int count,
                        SymbolWriter& writer) {
    write_residuals(residuals, contexts, count, writer);
  }
  template <bool kIsEncoding>
  static void reconstruct(const Parameters& p, const Stage& stage,
                          Workspace<std::int16_t>& work) {
    if (stage.axis == 0) reconstruct_waves<0, kIsEncoding>(p, stage, work);
    else if (stage.axis == 1) reconstruct_waves<1, kIsEncoding>(p, stage, work);
    else reconstruct_waves<2, kIsEncoding>(p, stage, work);
  }
};

struct EdgeKernel {
  static RowMask background(const std::int16_t* means, std::int64_t count, std::int16_t lowest) {
    return background_of_row(means, static_cast<int>(count), lowest);
  }
  static void describe(const Stage& stage, const std::int16_t* means, const EdgeMasks& beside,
                       CandidateRow& row) {
    describe_row(stage, means, beside, row);
  }
};

StagePasses<std::int16_t> narrow_passes() { return passes_of<std::int16_t, Kernel, EdgeKernel>(); }
PushTokens push_pass() { return push_token_vectors; }

#endif

}  // namespace HWY_NAMESPACE
}  // namespace octavo::grey
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octavo::grey {

HWY_EXPORT(narrow_passes);
HWY_EXPORT(push_pass);

namespace {

/// Those for the best of `targets`; the portable ones for none.
StageFunctions functions_of(std::int64_t targets) {
  StageFunctions functions = portable_stage_functions();
  if (targets == 0) return functions;
  const SimdTargetsInUse in_use(targets);
  functions.narrow = HWY_DYNAMIC_DISPATCH(narrow_passes)();
  functions.push = HWY_DYNAMIC_DISPATCH(push_pass)();
  return functions;
}

}  // namespace

std::optional<StageFunctions> stage_functions_of(std::string_view level) {
  if (level == "scalar") return portable_stage_functions();
  const std::int64_t targets = simd_targets_of(level);
  if (targets == 0) return std::nullopt;
  return functions_of(targets);
}

const StageFunctions& stage_functions() {
  static const StageFunctions functions = functions_of(chosen_simd_targets());
  return functions;
}

}  // namespace octavo::grey
#endif
