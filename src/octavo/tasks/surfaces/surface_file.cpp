#include "octavo/tasks/surfaces/surface_file.h"

#include "octavo/core/bytes.h"
#include "octavo/file/storage/pending_file.h"

namespace octavo {

std::uint64_t write_surface(const MeshDescription& mesh, MeshFormat format, const Output& output,
                            const std::string& report_path, const TaskContext& context) {
  Storage& storage = local_storage();
  if (!report_path.empty()) settle_pair(storage, report_path, output.path);
  PendingFile file(storage, output.path);
  write_mesh(mesh, format, context.watcher(), file);
  context.stop_if_cancelled();
  file.seal();
  if (report_path.empty()) {
    file.publish(output.overwrite);
    return file.size();
  }
  const std::string text = mesh.report + "\n";
  PendingFile report(storage, report_path);
  report.append({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  report.seal();
  publish_pair(storage, report, file, output.overwrite);
  return file.size();
}

}  // namespace octavo
