// Progress of steps within work that is announced as a whole.
#pragma once

#include <cstdint>
#include <string_view>

#include "octavo/core/progress.h"

namespace octavo {

/// Passes on whether to stop, and nothing else.
class QuietProgress final : public Progress {
 public:
  explicit QuietProgress(const Progress& watched) : watched_(watched) {}
  void begin(std::string_view, std::int64_t, std::string_view) override {}
  void advance(std::int64_t) override {}
  void end() override {}
  bool is_cancelled() const override { return watched_.is_cancelled(); }

 private:
  const Progress& watched_;
};

}  // namespace octavo
