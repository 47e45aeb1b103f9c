#include "octavo/tasks/parts/plan_file.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "octavo/core/error.h"
#include "octavo/core/url_text.h"
#include "octavo/dist/plan_text.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/tasks/parts/scan_recipe.h"

namespace octavo {

namespace {

constexpr const char* kPlanEnding = ".plan";
constexpr std::uint64_t kMaxPlanBytes = std::uint64_t{4} << 30;

/// With a slash at its end.
std::string absolute_folder(const std::string& folder) {
  const auto path = std::filesystem::absolute(folder).lexically_normal() / "";
  return path.lexically_normal().string();
}

/// Links and ".." stay.
std::string absolute_path(const std::string& path) {
  if (is_url(path) || path.starts_with('/')) return path;
  return (std::filesystem::current_path() / "").string() + path;
}

std::string kept_path(const std::string& path, const std::string& root) {
  const std::string whole = absolute_path(path);
  if (!whole.starts_with(root)) return whole;
  const std::size_t below = whole.find_first_not_of('/', root.size());
  return below == std::string::npos ? whole : whole.substr(below);
}

bool is_relative(const std::string& path) { return !is_url(path) && !path.starts_with('/'); }

template <class F>
void change_paths(BuildPlan& plan, F change) {
  for (std::string& input : plan.inputs) input = change(input);
  for (SourceStamp& file : plan.files) file.path = change(file.path);
  if (!plan.stack) return;
  for (std::string& path : plan.stack->files.paths) path = change(path);
}

/// The name of a plan without its ending.
std::string stem_of(std::string name) {
  const std::string ending = kPlanEnding;
  if (name.ends_with(ending) && name.size() > ending.size()) {
    name.resize(name.size() - ending.size());
  }
  return name;
}

std::string text_of_plan(const std::string& path) {
  const auto file = local_storage().open_read(path);
  if (file->size() > kMaxPlanBytes) {
    throw Error(ErrorKind::limit_exceeded, "is larger than any plan", path);
  }
  std::string text(static_cast<std::size_t>(file->size()), '\0');
  file->read(0, {reinterpret_cast<std::uint8_t*>(text.data()), text.size()});
  return text;
}

}  // namespace

void require_root(const std::string& root) {
  if (root.empty() || local_storage().path_type(root) == PathType::folder) return;
  throw Error(ErrorKind::invalid_argument, "is no folder, in which paths could begin", root);
}

BuildPlan write_plan(BuildPlan plan, const std::string& path, const std::string& root,
                     bool overwrite) {
  ScanRecipe recipe = parse_recipe(plan.recipe);
  recipe.root = root.empty() ? "" : absolute_folder(root);
  plan.recipe = recipe_text(recipe);
  const std::string base = absolute_folder(root.empty() ? folder_of(path) : root);
  change_paths(plan, [&](const std::string& one) { return kept_path(one, base); });
  plan.id = id_of(plan);
  const std::string text = plan_text(plan);
  PendingFile file(local_storage(), path);
  file.append({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  file.seal();
  file.publish(overwrite);
  return plan;
}

BuildPlan read_plan(const std::string& path, const std::string& root) {
  const std::string text = text_of_plan(path);
  if (!text.starts_with("{\"")) throw Error(ErrorKind::not_octavo, "is no plan of a build", path);
  try {
    BuildPlan plan = parse_plan(text);
    if (plan.inputs.empty()) throw Error(ErrorKind::corrupt, "the plan names no source");
    const ScanRecipe recipe = parse_recipe(plan.recipe);
    const bool has_relative =
        std::ranges::any_of(plan.inputs, is_relative) ||
        std::ranges::any_of(plan.files, is_relative, &SourceStamp::path);
    if (!root.empty() && !has_relative) move_files(plan, absolute_folder(root));
    const std::string base = !root.empty()          ? absolute_folder(root)
                             : recipe.root.empty() ? absolute_folder(folder_of(path))
                                                   : recipe.root;
    change_paths(plan, [&](const std::string& one) {
      return is_relative(one) ? base + one : one;
    });
    return plan;
  } catch (const Error& error) {
    throw error.with_path(path);
  }
}

std::string proposed_volume(const std::string& plan_path) {
  const std::string name = base_name_of(plan_path);
  return plan_path.substr(0, plan_path.size() - name.size()) + stem_of(name) + ".8vo";
}

std::string part_name(const std::string& plan_path, std::int64_t part, std::int64_t count) {
  const auto number = [](std::int64_t value) {
    const std::string digits = std::to_string(value);
    return std::string(4 - std::min<std::size_t>(4, digits.size()), '0') + digits;
  };
  return stem_of(base_name_of(plan_path)) + ".part-" + number(part) + "-of-" + number(count);
}

}  // namespace octavo
