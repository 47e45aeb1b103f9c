// Labels as people ask for them: by number and by name.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/core/label_names.h"

namespace octavo {

struct AskedLabels {
  std::vector<std::int64_t> numbers = {};
  std::vector<std::string> names = {};  ///< each stands for all labels of that name

  bool is_empty() const { return numbers.empty() && names.empty(); }
};

/// The labels that are asked for, ascending, each once; none where none is asked for.
/// names  of the labels of the file `path`
/// Throws Error{invalid_argument} for 0, the background, and for a name that no label has
std::vector<std::int64_t> labels_of(const AskedLabels& asked, const LabelNames& names,
                                    const std::string& path);

/// Throws Error{invalid_argument} that names labels which no voxel of a level has; does nothing
/// where there are none.
/// missing  ascending
void require_no_missing(const std::vector<std::int64_t>& missing, int level,
                        const LabelNames& names, const std::string& path);

/// "label 3", or "label 3 (liver)" where it has a name.
std::string label_words(const LabelNames& names, std::int64_t label);

}  // namespace octavo
