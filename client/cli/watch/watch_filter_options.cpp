#include "client/cli/watch/watch_filter_options.h"

#include <CLI/CLI.hpp>

#include "client/cli/text/argument_text.h"

namespace steadymap {

void AddWatchFilterOptions(CLI::App* command, WatchFilterOptions* options) {
  command
      ->add_option("--box",
                   options->boxes,
                   "Only objects and leaves that touch the box; may be given several times")
      ->allow_extra_args(false)
      ->type_name("x0,y0,z0,x1,y1,z1");
  command->add_option("--class", options->classes, "Only this class; may be given several times")
      ->allow_extra_args(false)
      ->type_name("ID|NAME");
  command
      ->add_option("--object",
                   options->objects,
                   "Only this object, 0 for the background; may be given several times")
      ->check(CLI::NonNegativeNumber)
      ->allow_extra_args(false)
      ->type_name("ID");
}

absl::StatusOr<MapFilter> ReadWatchFilter(const WatchFilterOptions& options,
                                          const ClassNames& classes) {
  MapFilter filter;
  for (const std::string& text : options.boxes) {
    const absl::StatusOr<Box> box_world = ParseBox(text);
    if (!box_world.ok()) return box_world.status();
    filter.boxes_world.push_back(*box_world);
  }
  const absl::StatusOr<std::vector<ClassId>> ids = classes.ParseAll(options.classes);
  if (!ids.ok()) return ids.status();
  filter.classes = {ids->begin(), ids->end()};
  for (const std::uint64_t id : options.objects) filter.objects.insert(ObjectId(id));
  return filter;
}

}  // namespace steadymap
