// Codecs that take turns on one volume, and the rows that come of it.
#pragma once

#include <string>
#include <vector>

#include "bench/peers/peer.h"

namespace octavo::bench {

struct ContestSettings {
  std::string commit = "unknown";
  std::vector<std::string> only;     ///< names of the codecs that run; empty: all
  std::vector<std::string> without;  ///< names of the codecs that do not
  int rounds = 5;
  double budget_seconds = 60;        ///< of a codec for a volume; the first round is always run
};

/// The names of the columns that run_contest prints; docs/benchmarks.md explains them.
std::string contest_header();

/// Runs every wanted codec once per round and prints two rows for each, encode and decode.
/// A codec leaves the rounds when another one would exceed its budget.
/// Throws Error{internal} when a codec fails or a decode differs by more than `max_error`.
void run_contest(const Peers& peers, const RawVolume& volume, std::int64_t max_error,
                 const ContestSettings& settings);

}  // namespace octavo::bench
