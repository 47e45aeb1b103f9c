// A join in steps, of which many machines can do one at a time.
//
//   lay_out     the file at its full size, with all that is not a part's; what belongs where
//   copy_part   the streams of one part to their places: any number of them side by side
//   seal        the name, once every part is there
//
// join_files.h says what stands beside NAME meanwhile.
//
// Invariants
//   A step that is done again changes nothing. NAME holds a whole file or what it held before.
// Consequences
//   Who is killed starts again; what stands already is kept, and a part that is copied is needed no
//   more.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "octavo/dist/join_files.h"
#include "octavo/dist/join_layout.h"
#include "octavo/dist/parts.h"

namespace octavo {

/// Lays out the file for `path`; where that was done for this plan, also by another program
/// meanwhile, what stands there counts and no part is asked for.
/// Throws as join_parts; Error{io} where parts were copied for another plan, or for a layout that
///        cannot be read
JoinLayout lay_out_join(const BuildPlan& plan, const std::vector<std::shared_ptr<PartFile>>& parts,
                        Storage& storage, const std::string& path, bool overwrite,
                        const PartWork& work, Progress& progress);

/// Copies parts to their places in a file that is laid out. What one of them takes does not grow
/// with the number of the others.
class PartCopier {
 public:
  /// plan, storage  outlive it
  PartCopier(const BuildPlan& plan, JoinLayout layout, Storage& storage, std::string path);

  /// Whether a part was copied for this layout.
  bool is_copied(const PartPlace& place) const;

  /// Copies a part, proves it on the way, and makes it durable there.
  /// consumes  whether the part is removed then
  /// Throws Error{invalid_argument} for a part that is not the one laid out; as PartFile::copy;
  ///        Error{io}, also where the file was laid out anew meanwhile
  void copy(const std::shared_ptr<PartFile>& part, bool consumes, Progress& progress) const;

 private:
  const BuildPlan& plan_;
  JoinLayout layout_;
  Storage& storage_;
  std::string path_;
  std::map<BrickAt, std::vector<CopiedRun>> runs_;  ///< of each part, by its first brick
};

/// PartCopier::copy of one part, by the layout that stands there. Throws as that; Error{io} where
/// nothing is laid out
void copy_part(const BuildPlan& plan, const std::shared_ptr<PartFile>& part, Storage& storage,
               const std::string& path, bool consumes, Progress& progress);

/// Proves every byte of the file, gives it its name, and removes what stood beside it, but for the
/// mark that this was done. Where it is_joined, the file stays as it is.
/// Returns the length of the file
/// Throws  Error{io} that names the parts that were not copied; Error{corrupt} that names those
///         whose copies were changed since, which have to be copied again; as FileWriter
std::uint64_t seal_join(const BuildPlan& plan, Storage& storage, const std::string& path,
                        bool overwrite, const PartWork& work, Progress& progress);

/// Joins parts and removes each as soon as it is copied, so that no more is needed beside the file
/// than the largest of them. All are proven before the first goes. Killed, it goes on with those
/// that are left, once it has proven what was copied. Leaves the mark that seal_join leaves; where
/// it is_consumed, file and parts stay.
/// paths  of the parts, of which some may be gone after an earlier join
/// Throws as the steps; before anything is removed Error{io} where the disk is too small, or parts
///        are missing that were not copied, and Error{corrupt} for copies that were changed since
/// clipped  gets the clipped voxels of all parts, those that are gone among them
/// Returns the length of the file
std::uint64_t consume_parts(const BuildPlan& plan, const std::vector<std::string>& paths,
                            Storage& storage, const std::string& path, bool overwrite,
                            const PartWork& work, Progress& progress,
                            ClippedVoxels* clipped = nullptr);

}  // namespace octavo
