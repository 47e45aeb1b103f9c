#include "octavo/mesh/formats/glb_buffers.h"

#include <meshoptimizer.h>

#include <utility>

namespace octavo {

namespace {

constexpr const char* kMeshopt = "EXT_meshopt_compression";
constexpr std::uint64_t kGlbAlignment = 4;

ByteSpan bytes_of(const void* data, std::size_t size) {
  return {static_cast<const std::uint8_t*>(data), size};
}

std::uint64_t aligned(std::uint64_t size) {
  return (size + kGlbAlignment - 1) / kGlbAlignment * kGlbAlignment;
}

}  // namespace

std::size_t GlbBuffers::add_points(const void* data, std::size_t count, std::size_t stride,
                                   GlbType type, const char* filter, JsonObject about) {
  about.set("componentType", static_cast<int>(type)).set("type", "VEC3");
  const Array array{count, stride, "ATTRIBUTES", filter, true};
  const ByteSpan plain = bytes_of(data, count * stride);
  if (is_plain_) return add_accessor(array, plain, plain, std::move(about));
  meshopt_encodeVertexVersion(0);  // the one that the extension knows
  Bytes packed(meshopt_encodeVertexBufferBound(count, stride));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), data, count, stride));
  return add_accessor(array, plain, packed, std::move(about));
}

std::size_t GlbBuffers::add_triangles(const std::vector<std::uint32_t>& numbers,
                                      std::size_t point_count) {
  // 65535 begins a strip anew.
  const bool is_short = point_count <= 65535;
  JsonObject accessor;
  accessor.set("componentType", static_cast<int>(is_short ? GlbType::uint16 : GlbType::uint32))
      .set("type", "SCALAR");
  const std::size_t stride = is_short ? sizeof(std::uint16_t) : sizeof(std::uint32_t);
  const Array array{numbers.size(), stride, "TRIANGLES", "NONE", false};
  if (!is_plain_) {
    meshopt_encodeIndexVersion(1);  // the one that the extension knows
    Bytes packed(meshopt_encodeIndexBufferBound(numbers.size(), point_count));
    packed.resize(
        meshopt_encodeIndexBuffer(packed.data(), packed.size(), numbers.data(), numbers.size()));
    return add_accessor(array, bytes_of(nullptr, numbers.size() * stride), packed,
                        std::move(accessor));
  }
  if (!is_short) {
    const ByteSpan plain = bytes_of(numbers.data(), numbers.size() * stride);
    return add_accessor(array, plain, plain, std::move(accessor));
  }
  const std::vector<std::uint16_t> halves(numbers.begin(), numbers.end());
  const ByteSpan plain = bytes_of(halves.data(), halves.size() * stride);
  return add_accessor(array, plain, plain, std::move(accessor));
}

std::size_t GlbBuffers::add_accessor(const Array& array, ByteSpan data, ByteSpan packed,
                                     JsonObject accessor) {
  constexpr int kPointsOfArrays = 34962;
  constexpr int kNumbersOfPoints = 34963;
  JsonObject view;
  view.set("buffer", is_plain_ ? 0 : 1)
      .set("byteOffset", is_plain_ ? bytes_.size() : unpacked_bytes_)
      .set("byteLength", data.size());
  if (array.is_of_points) view.set("byteStride", array.stride);
  view.set("target", array.is_of_points ? kPointsOfArrays : kNumbersOfPoints);
  if (!is_plain_) {
    JsonObject meshopt;
    meshopt.set("buffer", 0)
        .set("byteOffset", bytes_.size())
        .set("byteLength", packed.size())
        .set("byteStride", array.stride)
        .set("mode", array.mode)
        .set("count", array.count);
    if (std::string_view(array.filter) != "NONE") meshopt.set("filter", array.filter);
    JsonObject extensions;
    extensions.set(kMeshopt, meshopt);
    view.set("extensions", extensions);
  }
  accessor.set("bufferView", views_.size()).set("count", array.count);
  views_.push_back(std::move(view));
  accessors_.push_back(std::move(accessor));
  bytes_.insert(bytes_.end(), packed.begin(), packed.end());
  bytes_.resize(aligned(bytes_.size()));
  unpacked_bytes_ = aligned(unpacked_bytes_ + data.size());
  return accessors_.size() - 1;
}

void GlbBuffers::describe(JsonObject& json) const {
  if (is_empty()) return;
  std::vector<JsonObject> buffers(1);
  buffers[0].set("byteLength", bytes_.size());
  if (!is_plain_) {
    JsonObject stand_in;
    stand_in.set("fallback", true);
    JsonObject extensions;
    extensions.set(kMeshopt, stand_in);
    buffers.emplace_back().set("byteLength", unpacked_bytes_).set("extensions", extensions);
  }
  json.set("accessors", accessors_).set("bufferViews", views_).set("buffers", buffers);
}

}  // namespace octavo
