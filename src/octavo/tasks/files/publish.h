// A folder for any web server: the page of the viewer, and the volumes that it shows.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct PublishOptions {
  std::vector<std::string> inputs;  ///< .8vo files
  std::string page_folder;          ///< the built page
  Output output;                    ///< a folder, new or there; its files of other names stay
  bool keep_identity = false;       ///< files that keep what may tell who, where or when are taken
};

struct PublishedFile {
  std::string name;
  std::uint64_t bytes = 0;
};

struct PublishResult {
  std::vector<PublishedFile> volumes;
  std::vector<PublishedFile> page;  ///< and the list of volumes
  std::vector<std::string> listed;  ///< titles of volumes that were listed before, and still are
};

/// Writes all files, or none. Every volume is opened before; its bytes are copied as they are, and
/// all their checksums are proven before any file has its name. What comes from a URL and is
/// damaged is copied once more.
/// Volumes that were published there before stay listed as long as their files are there, behind
/// the new ones.
/// Throws  as open_volume; Error{corrupt} for a damaged volume, about the field "input.repair"
///         where repair turns the damage of a file back; Error{invalid_argument} about the field
///         "publish.keep_identity" for a volume that keeps identity; Error{io} where the page is
///         not there, a name is taken and not to be overwritten, and what writing throws;
///         Error{cancelled}
/// Memory  as verify_file, without bricks
PublishResult publish(const PublishOptions& options, const TaskContext& context);

}  // namespace octavo
