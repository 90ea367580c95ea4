#include "client/cli/query/render_command.h"

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "client/cli/text/argument_text.h"
#include "client/cli/text/number_text.h"
#include "client/cli/text/output_file.h"
#include "client/map/map_client.h"
#include "core/frame/image_codec.h"
#include "core/map/placed_volume.h"
#include "core/query/map_mesh.h"
#include "proto/convert_geometry.h"
#include "proto/convert_object.h"

namespace steadymap {
namespace {

constexpr char kRenderFooter[] =
    "Draws the map from above: the surface, shaded and coloured by height (or in the recorded\n"
    "colours), the paths of the robots and a scale bar. A ceiling is cut away. Objects are\n"
    "outlined in the colour of their E[v], the probability that they are still in their place.\n"
    "Broken outlines show the former places of objects that were removed or moved.";

std::vector<RobotPath> PathsOf(const std::vector<v1::FramePose>& poses) {
  std::map<SensorName, RobotPath> paths;
  for (const v1::FramePose& pose : poses) {
    const SensorName source{pose.robot(), pose.sensor()};
    RobotPath& path = paths[source];
    path.robot = source.ToString();
    const v1::Vector3& position = pose.world_from_camera().position_m();
    path.positions_world.emplace_back(position.x(), position.y(), position.z());
  }
  std::vector<RobotPath> ordered;
  ordered.reserve(paths.size());
  for (auto& [source, path] : paths) ordered.push_back(std::move(path));
  return ordered;
}

// Events of objects that left their place.
constexpr std::array<v1::EventType, 2> kDepartures = {v1::EVENT_TYPE_REMOVED, v1::EVENT_TYPE_MOVED};

/// Returns the shown objects, and the former places of removed or moved objects. An object that
/// returned has no such mark.
absl::StatusOr<std::vector<ObjectMark>> ReadMarks(MapClient* client,
                                                  const MapName& name,
                                                  const MapSnapshot& section) {
  std::vector<ObjectMark> marks;
  marks.reserve(section.objects.size());
  for (const auto& [id, object] : section.objects) {
    marks.push_back({object->cuboid, object->belief.stationarity(), false});
  }
  const absl::StatusOr<MapList<v1::Object>> objects =
      client->ListObjects(name, {.with_archived_and_tentative = true});
  if (!objects.ok()) return objects.status();
  std::map<std::uint64_t, ObjectState> states;
  for (const v1::Object& message : objects->entries) {
    const absl::StatusOr<ObjectState> state = FromProto(message);
    if (!state.ok()) return state.status();
    states.emplace(message.id(), *state);
  }
  const absl::StatusOr<MapList<v1::ObjectEvent>> events =
      client->ListEvents(name, {.types = {kDepartures.begin(), kDepartures.end()}});
  if (!events.ok()) return events.status();
  for (const v1::ObjectEvent& event : events->entries) {
    const auto found = states.find(event.object_id());
    if (found == states.end()) continue;
    ObjectMark ghost{found->second.cuboid, 0.0, true};
    if (event.has_old_center_m()) {
      ghost.cuboid.center_world = FromProto(event.old_center_m());
    } else if (found->second.status != ObjectStatus::kArchived) {
      continue;
    }
    marks.push_back(ghost);
  }
  return marks;
}

}  // namespace

RenderCommand::RenderCommand(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const command = app->add_subcommand("render", "Draw a map from above");
  command->footer(kRenderFooter);
  command->add_option("NAME", map_, "The map")->required();
  command->add_option("--output", output_, "The PNG file to write")->required()->type_name("FILE");
  command->add_option("--size", picture_.longest_side_px, "Length of the longer side, pixels")
      ->check(CLI::Range(600, 8000))
      ->capture_default_str();
  command->add_flag("--by-height", by_height_, "Colour by height even if colours were recorded");
  command
      ->add_option_function<double>(
          "--cut-height",
          [this](const double& height_m) { picture_.cut_height_m = height_m; },
          "Omit everything above this height, metres (default: only a ceiling)")
      ->type_name("METRES");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status RenderCommand::Run() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(map_);
  if (!name.ok()) return name.status();
  if (absl::Status status = CheckEnding(output_, ".png"); !status.ok()) return status;
  absl::StatusOr<OutputFile> file = OutputFile::Create(output_);
  if (!file.ok()) return file.status();
  MapClient client(context_->Channel());
  const absl::StatusOr<MapSnapshot> section = client.GetMapSection(*name);
  if (!section.ok()) return section.status();
  const absl::StatusOr<std::vector<v1::FramePose>> poses = client.ListFramePoses(*name);
  if (!poses.ok()) return poses.status();

  const absl::StatusOr<std::vector<ObjectMark>> marks = ReadMarks(&client, *name, *section);
  if (!marks.ok()) return marks.status();

  const Mesh mesh = ExtractMapMesh(ShownVolumes(*section), section->scale, nullptr);
  BirdsEyeOptions options = picture_;
  options.title = name->ToString();
  options.subtitle = CountText(poses->size()) + " frames, " +
                     LengthText(section->scale.voxel_size_m) + " voxels, " +
                     CountText(section->objects.size()) + " objects, revision " +
                     std::to_string(section->revision.value());
  options.use_mesh_colors = !by_height_;
  const BirdsEyePicture picture = DrawBirdsEye(mesh, PathsOf(*poses), *marks, options);
  absl::Status status = file->Write(EncodeColorPng(picture.image));
  if (status.ok()) status = file->Commit();
  if (!status.ok()) return status;
  context_->out << output_ << ": " << picture.image.width_px() << " x " << picture.image.height_px()
                << " pixels, revision " << section->revision.value() << " of " << name->ToString()
                << '\n';
  return absl::OkStatus();
}

}  // namespace steadymap
