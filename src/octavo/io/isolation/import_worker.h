// What runs inside an import worker: a process that reads one source and sends its planes away, so
// that a reader that crashes, hangs or asks for all memory takes nobody along.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "octavo/io/open_source.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

using SourceOpener = std::function<std::unique_ptr<PlaneSource>(const std::vector<std::string>&,
                                                                const SourceOptions&)>;

/// True in a process that open_isolated_source started.
bool has_import_request();

/// The whole of such a process: takes limits upon itself, reads the source that the request names,
/// sends its planes, and never returns. It installs signal handlers, and it ends when the process
/// that started it ends.
/// Limits   no core files; no file may be written; as much memory as the machine has or the request
///          allows until the source is known, then that of the planes being decoded and 1 GiB;
///          processor time for one plane after the other
/// Requires has_import_request()
[[noreturn]] void run_import_worker(const SourceOpener& opener = open_source);

}  // namespace octavo
