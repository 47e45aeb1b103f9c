// octavo threshold: a mask, or classes, from the values of a volume.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/file_planes.h"
#include "common/inputs.h"
#include "common/masks.h"
#include "common/options.h"
#include "common/quantities.h"
#include "common/value_ranges.h"
#include "common/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "threshold", "Make a mask of the voxels whose value lies in a range.",
    "Ranges are in real units (HU), both ends included; an end left out is open. Several ranges\n"
    "and tissues add up. --class makes a label map of several classes in one pass; where\n"
    "classes overlap the one named first counts. Bricks whose least and greatest value decide\n"
    "are not decoded.\n\n"
    "Tissues, in HU, ends included: air (:-900), lung (-900:-500), fat (-190:-30),\n"
    "soft (-30:225), contrast (130:600), bone (226:).\n\n"
    "Examples:\n"
    "  octavo threshold head.8vo --range 226: -o bone.8vo\n"
    "  octavo threshold chest.8vo --tissue lung --tissue air -o gas.8vo\n"
    "  octavo threshold head.8vo --class 1=:-300 --class 2=-300:225 --class 3=226: -o classes.8vo\n"
    "  octavo threshold atlas.8vo --range 17:17 -o region.8vo"};

struct Arguments {
  std::string input;
  std::string output;
  std::vector<std::string> ranges;
  std::vector<std::string> tissues;
  std::vector<std::string> classes;
  bool stored = false;
};

struct Class {
  std::int64_t label = 1;
  ValueWindow window;
};

std::vector<Class> asked_classes(const Arguments& arguments, const VolumeDescription& volume,
                                 nlohmann::ordered_json& made_by) {
  std::vector<Class> classes;
  const auto add = [&](std::int64_t label, const AskedRange& range) {
    classes.push_back({label, stored_window(range, volume, arguments.stored)});
    made_by["ranges"].push_back({{"label", label},
                                 {"low", range_end_json(range.lowest)},
                                 {"high", range_end_json(range.highest)}});
  };
  for (const std::string& text : arguments.ranges) add(1, parse_range(text, "--range"));
  for (const std::string& name : arguments.tissues) {
    add(1, tissue_range(name, volume, arguments.input));
  }
  for (const std::string& text : arguments.classes) {
    const std::size_t equals = text.find('=');
    const std::int64_t label =
        equals == std::string::npos ? 0 : parse_integer(text.substr(0, equals), "--class");
    if (label < 1 || label > 255) {
      throw Error(ErrorKind::invalid_argument,
                  fmt::format("--class: '{}'; expected LABEL=LOW:HIGH with a label of 1 to 255",
                              escaped(text)));
    }
    add(label, parse_range(text.substr(equals + 1), "--class"));
  }
  if (classes.empty()) {
    throw Error(ErrorKind::invalid_argument,
                "threshold needs --range LOW:HIGH, --tissue or --class");
  }
  return classes;
}

/// Planes of class labels, from planes of values.
class ClassPlanes final : public PlaneSource {
 public:
  ClassPlanes(std::unique_ptr<PlaneSource> values, std::vector<Class> classes,
              const nlohmann::ordered_json& made_by)
      : values_(std::move(values)),
        classes_(std::move(classes)),
        description_(label_description(values_->description(), VoxelType::uint8, made_by)) {}

  const VolumeDescription& description() const override { return description_; }
  const std::vector<std::string>& warnings() const override { return values_->warnings(); }
  /// Voxels of each label.
  const std::array<std::uint64_t, 256>& counts() const { return counts_; }

  void read_plane(std::span<std::byte> plane) override {
    const VoxelType type = values_->description().type;
    buffer_.resize(plane.size() * static_cast<std::size_t>(bytes_per_voxel(type)));
    values_->read_plane(buffer_);
    with_voxel_type(type, [&](auto id) {
      using T = typename decltype(id)::type;
      for (std::size_t i = 0; i < plane.size(); ++i) {
        T value;
        std::memcpy(&value, buffer_.data() + i * sizeof value, sizeof value);
        const std::uint8_t label = label_of(static_cast<double>(value));
        plane[i] = static_cast<std::byte>(label);
        ++counts_[label];
      }
    });
  }

 private:
  std::uint8_t label_of(double value) const {
    for (const Class& c : classes_) {
      if (c.window.contains(value)) return static_cast<std::uint8_t>(c.label);
    }
    return 0;
  }

  std::unique_ptr<PlaneSource> values_;
  std::vector<Class> classes_;
  VolumeDescription description_;
  std::vector<std::byte> buffer_;
  std::array<std::uint64_t, 256> counts_{};
};

void report(const Arguments& arguments, const VolumeDescription& volume,
            const std::array<std::uint64_t, 256>& counts, const BuildResult& built,
            const Context& context) {
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  std::string text;
  for (std::size_t label = 1; label < counts.size(); ++label) {
    if (counts[label] == 0 && !(label == 1 && arguments.classes.empty())) continue;
    const double share =
        100 * static_cast<double>(counts[label]) / static_cast<double>(volume.size.voxel_count());
    objects.push_back({{"label", label},
                       {"voxels", counts[label]},
                       {"mm3", mm3_json(counts[label], volume)}});
    const std::string name = arguments.classes.empty() ? "" : fmt::format("label {}: ", label);
    text += fmt::format("{}: {}{} ({:.3g} % of the volume)\n", arguments.output, name,
                        volume_text(counts[label], volume), share);
  }
  if (context.json) {
    print_json({{"output", arguments.output},
                {"file_bytes", built.file_bytes},
                {"objects", objects},
                {"warnings", context.warnings}});
  } else if (!context.quiet) {
    print(text.empty() ? arguments.output + ": no voxel is in any class\n" : text);
  }
}

int run_threshold(const Arguments& arguments, Context& context) {
  require_computed_output(arguments.output, {arguments.input}, context);
  const std::shared_ptr<const FileReader> reader = open_octavo(arguments.input, context);
  const VolumeDescription& volume = reader->description();
  nlohmann::ordered_json made_by = {{"operation", "threshold"},
                                    {"units", arguments.stored ? "stored" : "real"}};
  const std::vector<Class> classes = asked_classes(arguments, volume, made_by);
  std::array<std::uint64_t, 256> counts{};
  BuildResult built;
  if (arguments.classes.empty()) {
    std::vector<ValueWindow> windows;
    for (const Class& c : classes) windows.push_back(c.window);
    const MaskTree mask = read_mask(*reader, 0, windows, context);
    counts[1] = mask.voxel_count();
    if (counts[1] == 0) {
      context.warn(arguments.output + ": no voxel lies in the range; the mask is empty");
    }
    built = write_mask(mask, volume, made_by, arguments.output, context);
  } else {
    ClassPlanes planes(std::make_unique<FilePlanes>(reader, 0, context.thread_count()), classes,
                       made_by);
    built = write_labels(planes, arguments.output, context);
    counts = planes.counts();
  }
  report(arguments, volume, counts, built, context);
  return kExitDone;
}

}  // namespace

void add_threshold(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_threshold(*arguments, context); });
  verb.add_option("file", arguments->input, "An .8vo file or a URL of one")
      ->type_name("FILE")
      ->required();
  verb.add_option("-o,--output", arguments->output, "The .8vo mask to write")
      ->type_name("FILE")
      ->required();
  Option range = verb.add_option("--range", arguments->ranges, "Values LOW:HIGH to take");
  range->type_name("LOW:HIGH")->allow_extra_args(false);
  Option tissue = verb.add_option("--tissue", arguments->tissues, "A range by name");
  tissue->type_name("NAME")->allow_extra_args(false)->check(one_of(tissue_names()));
  verb.add_option("--class", arguments->classes, "Values that get a label: LABEL=LOW:HIGH")
      ->type_name("N=LOW:HIGH")
      ->allow_extra_args(false)
      ->excludes(range)
      ->excludes(tissue);
  verb.add_flag("--stored", arguments->stored, "Ranges are stored values instead of real ones")
      ->excludes(tissue);
}

}  // namespace octavo::cli
