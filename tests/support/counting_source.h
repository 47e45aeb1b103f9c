// A source that counts what is read of it.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "octavo/file/storage/byte_source.h"
#include "octavo/file/storage/storage.h"

namespace octavo::testing {

class CountingSource final : public ByteSource {
 public:
  explicit CountingSource(std::vector<std::uint8_t> content)
      : inner_(byte_source_of(std::move(content), "counted.8vo")) {}
  std::uint64_t size() const override { return inner_->size(); }
  const std::string& name() const override { return inner_->name(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    ++reads;
    bytes += out.size();
    inner_->read(offset, out);
  }

  mutable std::atomic<int> reads = 0;
  mutable std::atomic<std::uint64_t> bytes = 0;

 private:
  std::shared_ptr<ByteSource> inner_;
};

}  // namespace octavo::testing
