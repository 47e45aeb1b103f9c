// octavo build: a scan in, one .8vo file out.
#include <filesystem>
#include <memory>

#include "common/building.h"
#include "common/inputs.h"
#include "common/label_hint.h"
#include "common/verb.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "build", "Fold a scan into one .8vo file, losslessly.",
    "A source is a DICOM folder, a TIFF or PNG stack, a NIfTI, NRRD or MetaImage file, raw\n"
    "voxels or another .8vo file. Stored voxels are kept as they are.\n\n"
    "Examples:\n"
    "  octavo build scans/head/ -o head.8vo\n"
    "  octavo build slices/*.tif --spacing 0.0195 -o bone.8vo\n"
    "  octavo build volume.raw --raw 512,512,300,int16 --spacing 0.8,0.8,1 -o volume.8vo\n"
    "  octavo build aal.nii.gz --labels -o aal.8vo"};

struct Arguments {
  std::vector<std::string> inputs;
  std::string output;
  bool labels = false;
  bool grey = false;
  SourceArguments source;
};

/// What was asked for, what the source says, what its name hints at: in this order.
VolumeKind choose_kind(const Arguments& arguments, const VolumeDescription& description,
                       const Context& context) {
  if (arguments.labels) return VolumeKind::labels;
  if (arguments.grey) return VolumeKind::grey;
  if (description.kind == VolumeKind::labels) {
    context.note(arguments.inputs.front() +
                 ": the source says it holds labels: building as labels; --grey changes that");
    return VolumeKind::labels;
  }
  if (const auto hint = label_hint(arguments.inputs.front(), description)) {
    context.note(arguments.inputs.front() + ": looks like labels (" + *hint +
                 "): building as labels; --grey changes that");
    return VolumeKind::labels;
  }
  return VolumeKind::grey;
}

/// A build never replaces the scan it reads, not even with --force; an .8vo file may be built anew.
void require_no_input(const std::string& output, const std::vector<std::string>& inputs) {
  std::error_code none;
  for (const std::string& input : inputs) {
    if (is_octavo_path(input) || !std::filesystem::equivalent(output, input, none)) continue;
    throw Error(ErrorKind::invalid_argument, "is the source itself; name another output", output);
  }
}

int run_build(const Arguments& arguments, Context& context) {
  require_free_output(arguments.output, context);
  require_no_input(arguments.output, arguments.inputs);
  const auto source = open_planes(arguments.inputs, arguments.source, context);
  const VolumeKind kind = choose_kind(arguments, source->description(), context);
  return build_and_report(*source, kind, arguments.output, context);
}

}  // namespace

void add_build(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App& verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_build(*arguments, context); });
  verb.add_option("inputs", arguments->inputs, "One folder or file, or the files of a stack")
      ->type_name("SOURCE")
      ->required();
  verb.add_option("-o,--output", arguments->output, "The file to write")
      ->type_name("FILE")
      ->required();
  CLI::Option* labels =
      verb.add_flag("--labels", arguments->labels, "A mask or label map: numbers are names");
  verb.add_flag("--grey", arguments->grey,
                "Measured values (default; labels are told by their name)")
      ->excludes(labels);
  add_source_options(verb, arguments->source);
}

}  // namespace octavo::cli
