// A folder of inputs for each fuzz target.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>

#include "octavo/core/bytes.h"
#include "octavo/core/error.h"

namespace octavo::fuzz {

/// Appends a number as fuzz::Input takes it.
template <class Int>
void put(Bytes& out, Int value) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
  out.insert(out.end(), bytes, bytes + sizeof value);
}

inline void put_bytes(Bytes& out, ByteSpan bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

class SeedFolder {
 public:
  explicit SeedFolder(std::filesystem::path path) : path_(std::move(path)) {}

  /// Writes the next input of a target. Throws Error{io}.
  void save(const std::string& target, ByteSpan bytes) {
    const std::filesystem::path folder = path_ / target;
    std::filesystem::create_directories(folder);
    const std::filesystem::path path = folder / std::to_string(counts_[target]++);
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    if (!out.flush()) throw Error(ErrorKind::io, "cannot be written", path.string());
  }

 private:
  std::filesystem::path path_;
  std::map<std::string, int> counts_;
};

/// Bricks of every kind with their models, in the form that brick_input.h takes apart.
void save_bricks(SeedFolder& seeds);

/// Small files of every kind, type and shape.
void save_files(SeedFolder& seeds);

/// Metadata of every sort.
void save_metadata(SeedFolder& seeds);

/// Plans of builds in parts, and parts.
void save_parts(SeedFolder& seeds);

/// The small streams of bricks, and a journal.
void save_streams(SeedFolder& seeds);

/// The sections, pieces, models and metadata of a file, and the file itself unless it is large.
void save_sections(SeedFolder& seeds, const std::filesystem::path& path);

}  // namespace octavo::fuzz
