// octavo-mpi render: pictures of rays by all ranks.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/render_options.h"
#include "mpi/mpi_verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kMpiRenderText = {
    "render", "Draw grey values by rays, seen from a side, by all ranks.",
    "Modes volume, mip, minip, mean and iso of octavo render, with its options but for\n"
    "--time-budget, --progressive, --adaptive and --smooth-edges. Each rank owns whole nodes of\n"
    "the octree and reads what its rays come to in them; colors and opacities, those of meshes\n"
    "in its nodes among them, are then composited in the order of the octants, each rank its\n"
    "share of the picture. The picture is that of one machine within a level of grey of 255.\n\n"
    "Examples:\n"
    "  mpirun -n 4 octavo-mpi render head.8vo --mode volume --transfer skin -o head.png\n"
    "  mpirun -n 8 octavo-mpi render head.8vo --mesh implant.ply=steel:0.6 -o implant.png\n"
    "  mpirun -n 64 octavo-mpi render scan.8vo --mode iso --isovalue 90 --turntable 36 "
    "-o turn.apng"};

struct MpiRenderArguments {
  RenderOptions render;
  RankArguments ranks;
};

void print_render_of_ranks(const RenderResult& result, const Communicator& ranks,
                           const Context& context) {
  const RenderCounts& counts = result.counts;
  const auto pictures = static_cast<double>(std::max(counts.rays.pictures, std::int64_t{1}));
  const double fps = result.seconds > 0 ? pictures / result.seconds : 0;
  print_result(context,
               {{"outputs", result.outputs},
                {"ranks", ranks.size()},
                {"level", result.level},
                {"size", {result.width, result.height}},
                {"samples", counts.rays.samples},
                {"bricks_decoded", counts.decoded_bricks},
                {"first_seconds", result.first_seconds},
                {"seconds", result.seconds},
                {"fps", fps}},
               fmt::format("{}: {} x {} pixels, level {}, by {} ranks, {:.2f} fps\n",
                           result.outputs.front(), result.width, result.height, result.level,
                           ranks.size(), fps));
}

int run_mpi_render(const MpiRenderArguments& arguments, Context& context) {
  return run_at_ranks(arguments.ranks, context, [&](Communicator& ranks, const TaskContext& task) {
    const RenderResult result = render_by_ranks(arguments.render, ranks, task);
    if (ranks.is_first()) print_render_of_ranks(result, ranks, context);
    return kExitDone;
  });
}

}  // namespace

void add_mpi_render(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kMpiRenderText, run_mpi_render);
  arguments.render.mode = RenderMode::volume;
  add_render_options(verb, arguments.render);
  add_waiting_options(verb, arguments.ranks);
}

}  // namespace octavo::cli
