#include "octavo/tasks/surfaces/label_surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/label_color.h"
#include "octavo/core/sha256.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/mesh/decimation.h"
#include "octavo/mesh/mesh_normals.h"
#include "octavo/mesh/nets/interface_decimation.h"
#include "octavo/mesh/nets/interface_mesh.h"
#include "octavo/mesh/nets/net_extraction.h"
#include "octavo/mesh/nets/smoothed_interfaces.h"
#include "octavo/mesh/nets/touching_points.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/surfaces/part_folder.h"
#include "octavo/tasks/surfaces/part_names.h"
#include "octavo/tasks/surfaces/reduced_mesh.h"
#include "octavo/tasks/volume_facts.h"
#include "octavo/tasks/volume_parts.h"

namespace octavo {

namespace {

constexpr double kMaxVolumeChange = 0.01;

[[noreturn]] void reject_labels(const std::string& text, const std::string& path,
                                const char* field) {
  throw Error(ErrorKind::invalid_argument, text, path).with_field(field);
}

/// The ending of files of a format, with its dot.
std::string ending_of(MeshFormat format) {
  switch (format) {
    case MeshFormat::stl: return ".stl";
    case MeshFormat::ply: return ".ply";
    case MeshFormat::obj: return ".obj";
    case MeshFormat::glb: return ".glb";
    case MeshFormat::vtp: return ".vtp";
    case MeshFormat::three_mf: return ".3mf";
  }
  return "";
}

/// Makes and writes the surfaces of one file.
class LabelSurfaceWriter {
 public:
  LabelSurfaceWriter(const LabelSurfacesOptions& options, const TaskContext& context)
      : options_(options), context_(context), format_(mesh_format_of(options.output.path)) {
    check_output();
    reader_ = open_labels(options.input, context, kAsLabels);
    require_level(reader_->levels(), options.level);
    names_ = &reader_->description().metadata.facts().labels;
    asked_ = labels_of(options.labels, *names_, options.input);
    check_names();
    check_labels_to_write();
    geometry_ = reader_->levels().geometry(reader_->description().geometry, options.level);
    result_.max_deviation_mm = deviation_mm(options.max_deviation, geometry_);
    if (options.triangles) triangle_limit(*options.triangles, 1);
  }

  LabelSurfacesResult write() {
    if (!is_spacing_known(reader_->description())) {
      context_.warn(options_.input +
                    ": its spacing is not known; the surface is written as if voxels were 1 mm");
    }
    make();
    LabelParts parts(surfaces_.interfaces);
    for (const std::int64_t label : parts.labels()) {
      if (is_asked(label)) result_.labels.push_back(measured(label, parts));
    }
    warn_of_volumes();
    result_.is_sound = std::all_of(result_.labels.begin(), result_.labels.end(),
                                   [](const LabelSurface& part) { return part.is_sound(); });
    if (!result_.is_sound) return std::move(result_);
    if (options_.form == LabelSurfaceForm::interfaces) write_interfaces();
    else if (format_) write_parts_together(parts);
    else write_parts_apart(parts);
    result_.is_written = true;
    return std::move(result_);
  }

 private:
  void check_output() {
    if (options_.smoothing_steps < 0) {
      throw Error(ErrorKind::invalid_argument, "the steps of smoothing must be 0 or more");
    }
    const std::string& path = options_.output.path;
    if (options_.form == LabelSurfaceForm::interfaces) {
      const bool is_fit = format_ == MeshFormat::ply || format_ == MeshFormat::obj ||
                          format_ == MeshFormat::vtp;
      if (!is_fit) {
        reject_labels("surfaces between labels are written as .ply, .obj or .vtp, which know what "
                      "lies on both sides",
                      path, "surface.output");
      }
    } else if (format_ == MeshFormat::stl) {
      reject_labels("an STL file knows no parts; name a folder, or a .ply, .obj, .glb, .vtp or "
                    ".3mf file",
                    path, "");
    }
    require_no_input(path, {options_.input});
    if (format_) require_free(options_.output);
    else folder_.emplace(local_storage(), path, options_.output.overwrite);
  }

  /// Where only some labels are asked for, the names of their files are known from the beginning.
  void check_names() const {
    if (!folder_) return;
    require_names(file_names(asked_));
  }

  void require_names(const std::vector<std::string>& names) const {
    for (const std::string& name : names) {
      require_no_input(folder_->file(name), {options_.input});
      folder_->require_free(name);
    }
  }

  /// Of which labels the files will be is known from the beginning where they are asked for, and
  /// for all of a scan by its range.
  void check_labels_to_write() const {
    for (const std::int64_t label : asked_) require_writable(label);
    if (!asked_.empty() || options_.level != 0) return;
    const ValueRange range = reader_->range();
    for (const auto value : {range.min, range.max}) {
      require_writable(static_cast<std::int64_t>(reader_->description().voxel_of(value)));
    }
  }

  void require_writable(std::int64_t label) const {
    require_label(format_.value_or(options_.part_format), label, options_.output.path);
  }

  std::vector<std::string> file_names(const std::vector<std::int64_t>& labels) const {
    std::vector<std::string> names = part_names(labels, *names_);
    for (std::string& name : names) name += ending_of(options_.part_format);
    return names;
  }

  /// The surfaces between all labels, and what their voxels say.
  void make() {
    NetCollector collector(context_.max_memory_bytes);
    const Size3& size = reader_->levels().size(options_.level);
    const SurfaceFrame frame(geometry_, size);
    {
      const ProgressScope scope(context_.watcher(), "surface", size.z, "planes");
      context_.on_threads(
          [&] { extract_net(*reader_, options_.level, collector, context_.watcher()); });
    }
    const SurfaceNet net = collector.take();
    voxel_counts_ = voxel_counts(net, frame.is_mirrored());
    check_asked();
    constexpr std::uint64_t kBytesPerQuad = 150;
    context_.require_memory(kBytesPerQuad * net.quads.size(), "the surface");
    context_.on_threads([&] {
      surfaces_ = smoothed_interfaces(net, frame, options_.smoothing_steps, kMaxVolumeChange);
    });
    require_numbered(surfaces_.interfaces.mesh.triangles.size());
    longest_moves_ = longest_moves_mm(net, surfaces_.offsets, geometry_);
    voxel_volume_ = frame.voxel_volume();
    result_.volume = reader_->description();
    result_.voxel_digest = reader_->voxel_digest();
    result_.pair_count = net.pairs.size();
    result_.full_triangle_count = surfaces_.interfaces.mesh.triangles.size();
    if (options_.triangles || result_.max_deviation_mm > 0) reduce();
    result_.reduced_triangle_count = surfaces_.interfaces.mesh.triangles.size();
  }

  /// Takes triangles away as far as the deviation allows, or as are asked for.
  void reduce() {
    const TriangleMesh& mesh = surfaces_.interfaces.mesh;
    require_reducible(mesh, context_);
    DecimatedInterfaces reduced;
    if (options_.triangles) {
      reduced = reduced_to(triangle_limit(*options_.triangles, mesh.triangles.size()));
    } else {
      context_.on_threads([&] {
        reduced = decimate_interfaces(surfaces_.interfaces, result_.max_deviation_mm, geometry_,
                                      context_.watcher());
      });
    }
    surfaces_.interfaces = std::move(reduced.interfaces);
    result_.crossing_triangles = reduced.crossing_triangles;
  }

  DecimatedInterfaces reduced_to(std::uint64_t limit) {
    LimitedInterfaces limited;
    context_.on_threads([&] {
      limited = decimate_interfaces_to(surfaces_.interfaces, limit, geometry_, context_.watcher());
    });
    if (!limited.is_reached) {
      throw unreached_limit(limit, limited.triangle_count).with_field("label_surfaces.triangles");
    }
    result_.max_deviation_mm = limited.max_deviation_mm;
    return std::move(limited.reduced);
  }

  void check_asked() const {
    if (voxel_counts_.empty()) {
      reject_labels(fmt::format("has no surface: no voxel of level {} has a label", options_.level),
                    options_.input, "");
    }
    for (const auto& [label, count] : voxel_counts_) {
      if (options_.form == LabelSurfaceForm::interfaces || is_asked(label)) require_writable(label);
    }
    std::vector<std::int64_t> missing = asked_;
    std::erase_if(missing, [&](std::int64_t label) { return voxel_counts_.contains(label); });
    require_no_missing(missing, options_.level, *names_, options_.input);
  }

  bool is_asked(std::int64_t label) const {
    return asked_.empty() || std::binary_search(asked_.begin(), asked_.end(), label);
  }

  /// The closed surface of a label, no two points of it at one place.
  static TriangleMesh cut_out(std::int64_t label, LabelParts& parts) {
    TriangleMesh part = parts.cut(label);
    move_apart(parts.touching(), part);
    return part;
  }

  LabelSurface measured(std::int64_t label, LabelParts& parts) const {
    context_.stop_if_cancelled();
    const TriangleMesh mesh = cut_out(label, parts);
    LabelSurface surface;
    surface.touching_points = parts.touching().size();
    surface.label = label;
    surface.point_count = mesh.points.size();
    surface.triangle_count = mesh.triangles.size();
    context_.on_threads([&] { surface.check = check_mesh(mesh); });
    surface.measures = measure_mesh(mesh);
    surface.voxel_count = voxel_counts_.at(label);
    surface.volume_change =
        surface.measures.volume_mm3 /
            (static_cast<double>(surface.voxel_count) * voxel_volume_) - 1;
    surface.longest_move_mm = longest_moves_.at(label);
    return surface;
  }

  void warn_of_volumes() const {
    const auto changes_more = [](const LabelSurface& a, const LabelSurface& b) {
      return std::abs(a.volume_change) < std::abs(b.volume_change);
    };
    const auto most = std::max_element(result_.labels.begin(), result_.labels.end(), changes_more);
    if (std::abs(most->volume_change) <= kMaxVolumeChange) return;
    context_.warn(fmt::format("{}: volumes change by more than 1 %; that of {} by {:+.2g} %",
                              options_.input, label_words(*names_, most->label),
                              100 * most->volume_change));
  }

  std::vector<std::string> comments() const {
    return {"octavo surfaces of labels with SHA-256 " + hex_text(reader_->voxel_digest()),
            fmt::format("level {}, smoothed {} times", options_.level, options_.smoothing_steps)};
  }

  MeshPart part_of(std::int64_t label, std::size_t begin, std::size_t end) const {
    return {.name = names_->text_of(label),
            .label = label,
            .color = names_->color_of(label, label_color(label)),
            .begin = begin,
            .end = end};
  }

  /// Appends what `mesh` describes.
  void append(PendingFile& file, MeshFormat format, const TriangleMesh& mesh,
              const std::vector<MeshPart>& parts, const std::vector<LabelPair>& pairs) {
    const std::vector<std::string> lines = comments();
    std::vector<MeshPoint> normals;
    if (has_normals(format) && pairs.empty()) normals = area_normals(mesh);
    write_mesh({.mesh = mesh,
                .normals = normals,
                .pairs = pairs,
                .parts = parts,
                .comments = lines,
                .space = options_.space},
               format, context_.watcher(), file);
    context_.stop_if_cancelled();
    result_.point_count += mesh.points.size();
    result_.triangle_count += mesh.triangles.size();
  }

  /// The one file that was asked for.
  void write_one(const TriangleMesh& mesh, const std::vector<MeshPart>& parts,
                 const std::vector<LabelPair>& pairs) {
    PendingFile file(local_storage(), options_.output.path);
    append(file, *format_, mesh, parts, pairs);
    file.seal();
    file.publish(options_.output.overwrite);
    result_.file_bytes = file.size();
  }

  /// Those of the labels that are asked for, each once.
  void write_interfaces() {
    const InterfaceMesh& all = surfaces_.interfaces;
    constexpr std::uint32_t kUnused = 0xffffffff;
    std::vector<std::uint32_t> numbers(all.mesh.points.size(), kUnused);
    TriangleMesh mesh;
    std::vector<LabelPair> pairs;
    for (std::size_t i = 0; i < all.mesh.triangles.size(); ++i) {
      const LabelPair& pair = all.pairs[all.pair_of[i]];
      const bool is_wanted = asked_.empty() || std::any_of(pair.begin(), pair.end(), [&](auto l) {
        return l != 0 && is_asked(l);
      });
      if (!is_wanted) continue;
      MeshTriangle& t = mesh.triangles.emplace_back(all.mesh.triangles[i]);
      pairs.push_back(pair);
      for (std::uint32_t& point : t) {
        std::uint32_t& number = numbers[point];
        if (number == kUnused) {
          number = static_cast<std::uint32_t>(mesh.points.size());
          mesh.points.push_back(all.mesh.points[point]);
        }
        point = number;
      }
    }
    write_one(mesh, {}, pairs);
  }

  void write_parts_together(LabelParts& parts) {
    constexpr std::uint64_t kMostPoints = 0xffffffff;
    std::uint64_t point_count = 0;
    for (const LabelSurface& surface : result_.labels) point_count += surface.point_count;
    if (point_count > kMostPoints) {
      throw Error(ErrorKind::limit_exceeded,
                  fmt::format("the surfaces have {} points, more than {}", point_count,
                              kMostPoints))
          .with_field("level");
    }
    const std::uint64_t triangle_count = std::transform_reduce(
        result_.labels.begin(), result_.labels.end(), std::uint64_t{0}, std::plus<>(),
        [](const LabelSurface& surface) { return surface.triangle_count; });
    // Places, normals and their sums, what formats remember of points; the same again within GLB.
    constexpr std::uint64_t kBytesPerPoint = 60;
    const std::uint64_t times = *format_ == MeshFormat::glb ? 2 : 1;
    context_.require_memory(surfaces_.interfaces.memory_bytes() +
                                times * (kBytesPerPoint * point_count +
                                         sizeof(MeshTriangle) * triangle_count),
                            "the surfaces in one file");
    TriangleMesh all;
    all.points.reserve(point_count);
    all.triangles.reserve(triangle_count);
    std::vector<MeshPart> ranges;
    for (const LabelSurface& surface : result_.labels) {
      const TriangleMesh part = cut_out(surface.label, parts);
      const auto first = static_cast<std::uint32_t>(all.points.size());
      const std::size_t begin = all.triangles.size();
      all.points.insert(all.points.end(), part.points.begin(), part.points.end());
      for (const MeshTriangle& t : part.triangles) {
        all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
      }
      ranges.push_back(part_of(surface.label, begin, all.triangles.size()));
    }
    write_one(all, ranges, {});
  }

  void write_parts_apart(LabelParts& parts) {
    std::vector<std::int64_t> labels;
    for (const LabelSurface& surface : result_.labels) labels.push_back(surface.label);
    const std::vector<std::string> names = file_names(labels);
    require_names(names);
    const ProgressScope scope(context_.watcher(), "parts",
                              static_cast<std::int64_t>(labels.size()), "surfaces");
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const TriangleMesh part = cut_out(labels[i], parts);
      result_.labels[i].path = folder_->file(names[i]);
      result_.file_bytes += folder_->add(names[i], [&](PendingFile& file) {
        append(file, options_.part_format, part, {part_of(labels[i], 0, part.triangles.size())},
               {});
      });
      context_.watcher().advance(1);
    }
    folder_->publish();
  }

  const LabelSurfacesOptions& options_;
  const TaskContext& context_;
  std::optional<MeshFormat> format_;  // none of a folder
  std::optional<PartFolder> folder_;
  std::shared_ptr<const FileReader> reader_;
  const LabelNames* names_ = nullptr;
  std::vector<std::int64_t> asked_;
  Geometry geometry_;
  SmoothedInterfaces surfaces_;
  std::map<std::int64_t, std::int64_t> voxel_counts_;
  std::map<std::int64_t, double> longest_moves_;
  double voxel_volume_ = 0;
  LabelSurfacesResult result_;
};

}  // namespace

LabelSurfacesResult label_surfaces(const LabelSurfacesOptions& options,
                                   const TaskContext& context) {
  return LabelSurfaceWriter(options, context).write();
}

}  // namespace octavo
