// What joins leave beside the name of their file, and what it says.
//
// Beside NAME stand meanwhile
//
//   .NAME.join                 the file that grows
//   .NAME.join-layout          the layout, once the file is laid out
//   .NAME.join-draft-PLAN      the file while it is laid out
//   .NAME.join-copied-ID-A-B   for each part, groups A .. B, whose bytes are on disk; of a band
//                              ID-A-B-C-D, bricks C .. D. ID is that of the layout
//   .NAME.join-sealed-PLAN     once the file is whole, until nothing else of this is left: the
//                              trailer of the file, which holds a checksum of all its bytes, and
//                              how many floats only its level 0 holds
//   .NAME.join-done-PLAN       the same, from then on: so that a step that is done again, or a
//                              join that has consumed its parts, knows the file of its plan
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/dist/build_plan.h"
#include "octavo/dist/join_layout.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

/// Where the file for `path` grows.
std::string joined_name(const std::string& path);

/// Whether the file of a plan has its name, and not all that stood beside it is removed.
/// Throws Error{io}
bool is_sealed(const BuildPlan& plan, Storage& storage, const std::string& path);

/// Whether the file of a plan stands under its name, by the marks that steps have left: that of
/// another plan, of a build, or one that was changed since is not taken for it.
/// Throws Error{io}
bool is_joined(const BuildPlan& plan, Storage& storage, const std::string& path);

/// Whether a join that consumes its parts has nothing to do: the file is_joined. Where it may be
/// replaced, parts that are there again are to be joined anew.
/// paths  of the parts, of which any may be gone
/// Throws Error{io}
bool is_consumed(const BuildPlan& plan, const std::vector<std::string>& paths, Storage& storage,
                 const std::string& path, bool overwrite);

/// Removes what steps of a join have left beside a name, unless a join by another plan has begun
/// there, or one whose layout cannot be read.
/// Throws Error{io}
void discard_steps(const BuildPlan& plan, Storage& storage, const std::string& path);

/// The layout that stands there for a plan; nothing where none does.
/// Throws Error{io}
std::optional<JoinLayout> find_layout(const BuildPlan& plan, Storage& storage,
                                      const std::string& path);

/// The parts of the layout that were not copied.
std::vector<PartPlace> uncopied_parts(const JoinLayout& layout, Storage& storage,
                                      const std::string& path);

// --- For the steps themselves. All of these throw Error{io}.

std::string layout_name(const std::string& path);

/// Where a file is laid out: those who do so at once, by one plan, write the same bytes.
std::string draft_name(const std::string& path, const BuildPlan& plan);

/// The mark of a part that was copied for this layout: those of an earlier one say nothing of this
/// file.
std::string copied_name(const JoinLayout& layout, const std::string& path, const PartPlace& place);

std::string sealed_name(const std::string& path, const BuildPlan& plan);

/// The parts that were copied for a layout, looked up at once.
class CopiedMarks {
 public:
  /// layout, path  outlive it
  CopiedMarks(const JoinLayout& layout, Storage& storage, const std::string& path);
  bool hold(const PartPlace& place) const;

 private:
  const JoinLayout& layout_;
  const std::string& path_;
  std::vector<std::string> names_;
};

/// A file of these bytes under a name, whole or not at all.
void put_join_file(Storage& storage, const std::string& name, std::string_view bytes);

void remove_names(Storage& storage, const std::vector<std::string>& names);

/// What killed joins to `path` were writing: nobody has it locked.
void remove_unfinished(Storage& storage, const std::string& path);

/// Everything with which joins to `path` grow. The marks of copies go first: a layout without them
/// is copied anew, marks without a layout would say what is not so. That of the plan goes last: it
/// says that all is done.
void discard_join(Storage& storage, const std::string& path);

/// A join that was not finished may be all that is left of parts that are gone.
void require_none_of_others(const BuildPlan& plan, Storage& storage, const std::string& path);

/// Whether what stands there is still this layout, and not one of another laying out.
bool is_still_laid_out(const JoinLayout& layout, Storage& storage, const std::string& path);

/// Whether two whole files hold the same, by their lengths and what their ends say of all bytes.
bool is_same_file(Storage& storage, const std::string& a, const std::string& b);

/// What a mark is to hold of the file at `path`.
std::string joined_mark(Storage& storage, const std::string& path, const ClippedVoxels& clipped);

/// Requires the mark of a plan whose file is_joined.
ClippedVoxels clipped_of_marks(const BuildPlan& plan, Storage& storage, const std::string& path);

/// Leaves of all marks beside a joined file the one that says of what plan it is. Requires the
/// lock of the folder.
void leave_done_mark(const BuildPlan& plan, Storage& storage, const std::string& path);

}  // namespace octavo
