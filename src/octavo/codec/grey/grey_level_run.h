// A level of a brick, or a part of level 0, on its way from its means to its samples. Several of
// them may go at the same time: the symbols of one do not wait for those of the others.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "octavo/codec/grey/edge_pairs.h"
#include "octavo/codec/grey/grey_brick.h"
#include "octavo/codec/grey/grey_stage.h"

namespace octavo::grey {

/// A split of a level of which a box is looked at. The last split needs all samples of those before
/// it: its contexts look around their pairs.
inline Stage needed_of(Stage stage, const Split& split, const BrickShape& shape, int level,
                       const Box& box) {
  if (split.fine_size != shape.size[static_cast<std::size_t>(level)]) return stage;
  // Nothing in the first planes of the last split looks at later ones.
  stage.first_row = stage.axis == 1 ? box.lo.y / 2 : box.lo.y;
  stage.last_row = stage.axis == 1 ? (box.hi.y + 1) / 2 : box.hi.y;
  const std::int64_t pairs = stage.axis == 2 ? (box.hi.z + 1) / 2 : box.hi.z;
  if (pairs >= stage.pairs.z) return stage;
  stage.pairs.z = pairs;
  // The last pair of all is left out.
  if (stage.axis == 2) stage.last_pair = {};
  return stage;
}

/// Decodes the splits of a level from its edges and residuals; its means stand in the work space,
/// and so do its samples in the end.
template <class Sample>
class LevelRun {
 public:
  /// What a level is decoded with.
  struct Setting {
    const Model& model;
    const SampleScale& scale;
    int level;
    int most_states;
  };

  /// box  of the samples that are looked at
  /// Requires that the level has details. All arguments but the segment outlive the run.
  LevelRun(const Setting& setting, const Part& part, ByteSpan segment, const BrickHints& hints,
           const Box& box, Workspace<Sample>& work)
      : setting_(setting),
        part_(part),
        hints_(hints),
        box_(box),
        work_(work),
        symbols_(setting.model, table_set(setting.level), segment,
                 level_detail_count(part.shape, setting.level, hints.cells),
                 setting.scale.shift(), setting.most_states),
        splits_(splits_of(part.shape, setting.level)) {
    for (auto& grid : work.magnitudes) grid.set_size({0, 0, 0});
  }

  const Parameters& parameters() const { return setting_.model.parameters; }
  const std::vector<Split>& splits() const { return splits_; }

  /// What is needed of the i-th split.
  Stage begin(std::size_t i) {
    const Split& split = splits_[i];
    const Stage all = begin_split(work_, part_, setting_.scale, parameters(), setting_.level,
                                  hints_, split);
    if (all.has_edges) take_edges(all, work_, symbols_);
    const Stage own = needed_of(all, split, part_.shape, setting_.level, box_);
    is_whole_ = is_whole_ && own.pairs == all.pairs;
    return own;
  }
  SplitTask<Sample> task(const Stage& stage) { return {stage, work_, symbols_}; }
  void end(std::size_t i) {
    end_split(work_, part_, parameters(), splits_[i], reach_of(parameters().predictor),
              setting_.level == 0 && i + 1 == splits_.size());
  }

  /// Throws Error{corrupt} unless the segment was taken exactly, where all of it was to be taken.
  void finish() const {
    if (is_whole_) symbols_.finish();
  }

 private:
  const Setting setting_;
  const Part& part_;
  const BrickHints& hints_;
  Box box_;
  Workspace<Sample>& work_;
  SymbolReader symbols_;
  std::vector<Split> splits_;
  bool is_whole_ = true;  ///< all symbols are taken
};

/// Whether two parts are split along the same axes.
inline bool are_split_alike(const BrickShape& a, const BrickShape& b, int level) {
  const auto slot = static_cast<std::size_t>(level);
  return a.halving[slot] == b.halving[slot];
}

/// Runs at most kMostTogether levels to their end, all of one model and along the same axes.
template <class Sample>
void run_together(std::span<LevelRun<Sample>* const> runs) {
  const Parameters& p = runs.front()->parameters();
  for (std::size_t i = 0; i < runs.front()->splits().size(); ++i) {
    std::array<Stage, kMostTogether> stages;
    std::vector<SplitTask<Sample>> tasks;
    for (std::size_t k = 0; k < runs.size(); ++k) {
      stages[k] = runs[k]->begin(i);
      tasks.push_back(runs[k]->task(stages[k]));
    }
    stage_functions().of<Sample>().decode_together(p, tasks);
    for (LevelRun<Sample>* const run : runs) run->end(i);
  }
  for (const LevelRun<Sample>* const run : runs) run->finish();
}

}  // namespace octavo::grey
