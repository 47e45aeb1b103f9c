// A writer that remembers what a build gives it, to give it to other writers.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "octavo/file/write/writer.h"

namespace octavo::testing {

class RecordingWriter final : public FileWriter {
 public:
  void add_model(const Bytes& model) override {
    calls_.push_back([model](FileWriter& writer) { writer.add_model(model); });
  }
  void add_brick(int tier, const EncodedBrick& brick) override {
    calls_.push_back([tier, brick](FileWriter& writer) { writer.add_brick(tier, brick); });
    if (tier == 0) bricks_.push_back(calls_.size());
  }
  void add_plane_digests(std::span<const Sha256Digest> digests) override {
    const std::vector<Sha256Digest> kept(digests.begin(), digests.end());
    calls_.push_back([kept](FileWriter& writer) { writer.add_plane_digests(kept); });
  }
  void add_part(Part part) override {
    calls_.push_back([part](FileWriter& writer) { writer.add_part(part); });
  }
  void end_group(std::uint32_t) override {}
  const std::vector<JournalGroup>& resumed() const override { return none_; }
  Bytes first_model() const override { return {}; }
  std::int64_t kept_layers() const override { return 0; }
  WrittenErrors written_errors() const override { return {}; }
  void set_metadata(const Metadata&) override {}
  void finish() override {}
  std::uint64_t bytes_written() const override { return 0; }

  /// Gives the calls behind the first `begin` layers of tier 0, up to the end of layer `end` or of
  /// all. Each of those layers is a group, whose checksum is its number from 1.
  void replay(FileWriter& writer, std::size_t layer_bricks, std::size_t begin,
              std::size_t end = std::numeric_limits<std::size_t>::max()) const {
    std::size_t next = begin * layer_bricks;
    std::size_t at = next == 0 ? 0 : bricks_[next - 1];
    for (; at < calls_.size(); ++at) {
      if (next / layer_bricks >= end && next % layer_bricks == 0) return;
      calls_[at](writer);
      if (next >= bricks_.size() || bricks_[next] != at + 1) continue;
      if (++next % layer_bricks == 0) {
        writer.end_group(static_cast<std::uint32_t>(next / layer_bricks));
      }
    }
  }

 private:
  std::vector<std::function<void(FileWriter&)>> calls_;
  std::vector<std::size_t> bricks_;  ///< calls up to and with each brick of tier 0
  std::vector<JournalGroup> none_;
};

}  // namespace octavo::testing
