#include "octavo/tasks/files/write_phantom.h"

#include "octavo/core/error.h"

namespace octavo {

WritePhantomResult write_phantom(const WritePhantomOptions& options, const TaskContext& context) {
  const Output& output = options.output;
  require_free(output);
  const auto source = make_phantom(options.phantom);
  context.require_voxels(source->description().size, output.path);
  if (is_plain_path(output.path)) {
    return {source->description(),
            write_plain_planes(*source, output.path, output.overwrite, context.watcher())};
  }
  if (output.path.ends_with(".8vo")) {
    return {source->description(),
            build_planes(*source, {.is_resumable = false}, output, "phantom", context)};
  }
  throw Error(ErrorKind::invalid_argument, "a phantom is written as .8vo, .raw or .mhd",
              output.path)
      .with_field("output.format");
}

}  // namespace octavo
