// The verbs of the program. Each add_... declares one verb with its options on `app`; when that
// verb is parsed, it leaves its work in context.run.
#pragma once

#include "common/context.h"

namespace CLI {
class App;
}

namespace octavo::cli {

void add_build(CLI::App& app, Context& context);
void add_plan(CLI::App& app, Context& context);
void add_part(CLI::App& app, Context& context);
void add_join(CLI::App& app, Context& context);
void add_threshold(CLI::App& app, Context& context);
void add_combine(CLI::App& app, Context& context);
void add_components(CLI::App& app, Context& context);
void add_measure(CLI::App& app, Context& context);
void add_touch(CLI::App& app, Context& context);
void add_fill_holes(CLI::App& app, Context& context);
void add_dilate(CLI::App& app, Context& context);
void add_erode(CLI::App& app, Context& context);
void add_open(CLI::App& app, Context& context);
void add_close(CLI::App& app, Context& context);
void add_distance(CLI::App& app, Context& context);
void add_align(CLI::App& app, Context& context);
void add_morphometry(CLI::App& app, Context& context);
void add_shell(CLI::App& app, Context& context);
void add_surface(CLI::App& app, Context& context);
void add_hexahedra(CLI::App& app, Context& context);
void add_transform(CLI::App& app, Context& context);
void add_phantom(CLI::App& app, Context& context);
void add_info(CLI::App& app, Context& context);
void add_verify(CLI::App& app, Context& context);
void add_repair(CLI::App& app, Context& context);
void add_export(CLI::App& app, Context& context);
void add_extract(CLI::App& app, Context& context);
void add_slice(CLI::App& app, Context& context);
void add_render(CLI::App& app, Context& context);
void add_probe(CLI::App& app, Context& context);
void add_codes(CLI::App& app, Context& context);
void add_serve(CLI::App& app, Context& context);
void add_view(CLI::App& app, Context& context);
void add_publish(CLI::App& app, Context& context);
void add_compare(CLI::App& app, Context& context);
void add_condense(CLI::App& app, Context& context);
void add_completion(CLI::App& app, Context& context);
void add_manual(CLI::App& app, Context& context);

}  // namespace octavo::cli
