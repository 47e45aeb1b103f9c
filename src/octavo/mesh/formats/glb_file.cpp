// GLB, glTF 2.0 in one binary file, with KHR_mesh_quantization and EXT_meshopt_compression.
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "octavo/core/json_text.h"
#include "octavo/mesh/cancellation.h"
#include "octavo/mesh/formats/glb_buffers.h"
#include "octavo/mesh/formats/mesh_bytes.h"
#include "octavo/mesh/formats/mesh_formats.h"
#include "octavo/mesh/formats/used_points.h"

namespace octavo {

namespace {

/// From mm with x to the left, y to the back and z up, to meters with y up and z to the front:
/// columns of a matrix.
constexpr std::array<double, 16> kLpsToGlb = {0.001, 0, 0,     0, 0, 0, -0.001, 0,
                                              0,     0.001, 0, 0, 0, 0, 0,      1};

/// A color of a screen as the light that it gives, four digits.
double linear_of(std::uint8_t value) {
  const double share = value / 255.0;
  const double light = share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
  return std::round(light * 1e4) / 1e4;
}

JsonObject material_of(const MeshPart& part) {
  const LabelColor color = part.color.value_or(kPlainColor);
  JsonObject surface;
  surface
      .set("baseColorFactor", std::array<double, 4>{linear_of(color[0]), linear_of(color[1]),
                                                    linear_of(color[2]), 1})
      .set("metallicFactor", 0)
      .set("roughnessFactor", 0.7);
  JsonObject material;
  material.set("name", part_name(part)).set("pbrMetallicRoughness", surface);
  return material;
}

/// Triangles in an order in which numbers repeat soon, and points in the order in which they come,
/// which compresses well.
class OrderedPart {
 public:
  OrderedPart(const MeshPart& part, UsedPoints& used, bool is_plain) {
    used.take(part.begin, part.end);
    numbers_.reserve(3 * (part.end - part.begin));
    for (std::size_t i = part.begin; i < part.end; ++i) {
      const MeshTriangle t = used.triangle(i);
      numbers_.insert(numbers_.end(), t.begin(), t.end());
    }
    points_ = used.points();
    if (is_plain) return;
    meshopt_optimizeVertexCache(numbers_.data(), numbers_.data(), numbers_.size(), points_.size());
    std::vector<unsigned> places(points_.size());
    meshopt_optimizeVertexFetchRemap(places.data(), numbers_.data(), numbers_.size(),
                                     points_.size());
    meshopt_remapIndexBuffer(numbers_.data(), numbers_.data(), numbers_.size(), places.data());
    for (std::size_t i = 0; i < places.size(); ++i) points_[places[i]] = used.points()[i];
  }

  const std::vector<std::uint32_t>& numbers() const { return numbers_; }
  const std::vector<std::uint32_t>& points() const { return points_; }  ///< of the mesh

 private:
  std::vector<std::uint32_t> numbers_;  // of the points of triangles
  std::vector<std::uint32_t> points_;
};

/// The smallest and the largest of each coordinate.
template <class Number, std::size_t kSize>
JsonObject range_of(const std::vector<std::array<Number, kSize>>& places) {
  std::array<std::array<Number, 3>, 2> range;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    range[0][axis] = range[1][axis] = places.front()[axis];
    for (const auto& place : places) {
      range[0][axis] = std::min(range[0][axis], place[axis]);
      range[1][axis] = std::max(range[1][axis], place[axis]);
    }
  }
  JsonObject about;
  return about.set("min", range[0]).set("max", range[1]);
}

class GlbWriter {
 public:
  GlbWriter(const MeshDescription& described, const Progress& watcher)
      : described_(described),
        watcher_(watcher),
        buffers_(described.is_plain),
        used_(described.mesh) {}

  void write(PendingFile& file) {
    for (const MeshPart& part : objects_of(described_)) add_part(part);
    std::string json = json_of_file();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const Bytes& bytes = buffers_.bytes();
    constexpr std::uint64_t kHeadBytes = 12;
    constexpr std::uint64_t kChunkHeadBytes = 8;
    std::uint64_t size = kHeadBytes + kChunkHeadBytes + json.size();
    if (!bytes.empty()) size += kChunkHeadBytes + bytes.size();
    require_countable(size, std::numeric_limits<std::uint32_t>::max(), "bytes", file);

    MeshBytes out(file, watcher_);
    out.text("glTF");
    out.number(std::uint32_t{2});
    out.number(static_cast<std::uint32_t>(size));
    out.number(static_cast<std::uint32_t>(json.size()));
    out.text("JSON");
    out.text(json);
    if (!bytes.empty()) {
      out.number(static_cast<std::uint32_t>(bytes.size()));
      out.text(std::string_view("BIN\0", 4));
      out.text({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    }
    out.flush();
  }

 private:
  void add_part(const MeshPart& part) {
    stop_if_cancelled(watcher_);
    const OrderedPart ordered(part, used_, described_.is_plain);
    stop_if_cancelled(watcher_);
    JsonObject node;
    node.set("name", part_name(part)).set("mesh", meshes_.size());
    JsonObject attributes;
    attributes.set("POSITION", add_positions(ordered.points(), node));
    stop_if_cancelled(watcher_);
    if (!described_.normals.empty()) {
      attributes.set("NORMAL", add_normals(ordered.points()));
    }
    JsonObject primitive;
    primitive.set("attributes", attributes)
        .set("indices", buffers_.add_triangles(ordered.numbers(), ordered.points().size()))
        .set("material", materials_.size());
    JsonObject mesh;
    mesh.set("name", part_name(part)).set("primitives", std::vector{primitive});
    if (part.label) {
      JsonObject extras;
      extras.set("label", *part.label);
      node.set("extras", extras);
    }
    meshes_.push_back(mesh);
    materials_.push_back(material_of(part));
    nodes_.push_back(node);
  }

  std::size_t add_positions(const std::vector<std::uint32_t>& points, JsonObject& node) {
    if (described_.is_plain || !described_.grid) {
      std::vector<MeshPoint> places;
      places.reserve(points.size());
      for (const std::uint32_t point : points) places.push_back(described_.mesh.points[point]);
      return buffers_.add_points(places.data(), places.size(), sizeof(MeshPoint), GlbType::float32,
                                 "NONE", range_of(places));
    }
    const PointGrid& grid = *described_.grid;
    std::vector<std::array<std::uint16_t, 4>> places;  // three and a filler
    places.reserve(points.size());
    for (const std::uint32_t point : points) {
      const auto [x, y, z] = grid.numbers_of(described_.mesh.points[point]);
      places.push_back({x, y, z, 0});
    }
    node.set("translation", grid.origin_mm).set("scale", Point3{grid.step_mm, grid.step_mm,
                                                                grid.step_mm});
    has_small_numbers_ = true;
    return buffers_.add_points(places.data(), places.size(), sizeof places[0], GlbType::uint16,
                               "NONE", range_of(places));
  }

  std::size_t add_normals(const std::vector<std::uint32_t>& points) {
    if (described_.is_plain) {
      std::vector<MeshPoint> normals;
      normals.reserve(points.size());
      for (const std::uint32_t point : points) normals.push_back(described_.normals[point]);
      return buffers_.add_points(normals.data(), normals.size(), sizeof(MeshPoint),
                                 GlbType::float32, "NONE", {});
    }
    constexpr int kBits = 8;
    std::vector<std::array<float, 4>> normals;
    normals.reserve(points.size());
    for (const std::uint32_t point : points) {
      const auto [x, y, z] = described_.normals[point];
      normals.push_back({x, y, z, 0});
    }
    std::vector<std::array<std::int8_t, 4>> packed(normals.size());
    meshopt_encodeFilterOct(packed.data(), packed.size(), sizeof packed[0], kBits,
                            normals.front().data());
    has_small_numbers_ = true;
    JsonObject about;
    about.set("normalized", true);
    return buffers_.add_points(packed.data(), packed.size(), sizeof packed[0], GlbType::int8,
                               "OCTAHEDRAL", about);
  }

  JsonObject asset() const {
    JsonObject extras;
    extras.set("comments", described_.comments);
    if (!described_.report.empty()) extras.set_json("report", described_.report);
    JsonObject asset;
    return asset.set("version", "2.0").set("generator", "octavo").set("extras", extras);
  }

  std::string json_of_file() const {
    std::vector<std::string> extensions;
    if (has_small_numbers_) extensions.push_back("KHR_mesh_quantization");
    if (!described_.is_plain && !buffers_.is_empty()) {
      extensions.push_back("EXT_meshopt_compression");
    }
    JsonObject root;
    root.set("name", "LPS mm").set("matrix", kLpsToGlb);
    if (!nodes_.empty()) {
      std::vector<std::size_t> children(nodes_.size());
      std::iota(children.begin(), children.end(), 1);
      root.set("children", children);
    }
    std::vector<JsonObject> nodes = {root};
    nodes.insert(nodes.end(), nodes_.begin(), nodes_.end());
    JsonObject scene;
    scene.set("nodes", std::array<int, 1>{0});

    JsonObject json;
    json.set("asset", asset());
    if (!extensions.empty()) {
      json.set("extensionsUsed", extensions).set("extensionsRequired", extensions);
    }
    json.set("scene", 0).set("scenes", std::vector{scene}).set("nodes", nodes);
    if (!meshes_.empty()) json.set("meshes", meshes_).set("materials", materials_);
    buffers_.describe(json);
    return json.text();
  }

  const MeshDescription& described_;
  const Progress& watcher_;
  GlbBuffers buffers_;
  UsedPoints used_;
  bool has_small_numbers_ = false;  // of 8 or 16 bits
  std::vector<JsonObject> nodes_;   // below the root
  std::vector<JsonObject> meshes_;
  std::vector<JsonObject> materials_;
};

}  // namespace

void write_glb(const MeshDescription& described, const Progress& watcher, PendingFile& file) {
  GlbWriter(described, watcher).write(file);
}

}  // namespace octavo
