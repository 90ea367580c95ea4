#include "client/cli/render_command.h"

#include <map>
#include <vector>

#include <CLI/CLI.hpp>

#include "client/cli/argument_text.h"
#include "client/cli/number_text.h"
#include "client/cli/output_file.h"
#include "client/map_client.h"
#include "core/image_codec.h"
#include "core/tsdf_mesh.h"

namespace steadymap {
namespace {

constexpr char kFooter[] =
    "A bird's-eye picture: the surface from straight above, lit and coloured by height (or by the\n"
    "colours that were recorded), the robots' paths and a scale bar. A ceiling is cut away.";

std::vector<RobotPath> PathsOf(const std::vector<v1::FramePose>& poses) {
  std::map<std::string, RobotPath> paths;
  for (const v1::FramePose& pose : poses) {
    RobotPath& path = paths[pose.robot()];
    path.robot = pose.robot();
    const v1::Vector3& position = pose.world_from_camera().position_m();
    path.positions_world.emplace_back(position.x(), position.y(), position.z());
  }
  std::vector<RobotPath> ordered;
  ordered.reserve(paths.size());
  for (auto& [robot, path] : paths) ordered.push_back(std::move(path));
  return ordered;
}

}  // namespace

RenderCommand::RenderCommand(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const command = app->add_subcommand("render", "Draw a map from above");
  command->footer(kFooter);
  command->add_option("NAME", map_, "The map")->required();
  command->add_option("--output", output_, "The PNG file")->required()->type_name("FILE");
  command->add_option("--size", picture_.longest_side_px, "Length of the longer side, pixels")
      ->check(CLI::Range(600, 8000))
      ->capture_default_str();
  command->add_flag("--by-height", by_height_, "Colour by height even where colours were recorded");
  command
      ->add_option_function<double>(
          "--cut-height",
          [this](const double& height_m) { picture_.cut_height_m = height_m; },
          "Leave out what is higher, metres; without it, only a ceiling")
      ->type_name("METRES");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status RenderCommand::Run() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(map_);
  if (!name.ok()) return name.status();
  absl::StatusOr<OutputFile> file = OutputFile::Create(output_);
  if (!file.ok()) return file.status();
  MapClient client(context_->Channel());
  const absl::StatusOr<MapSnapshot> section = client.GetMapSection(*name);
  if (!section.ok()) return section.status();
  const absl::StatusOr<std::vector<v1::FramePose>> poses = client.ListFramePoses(*name);
  if (!poses.ok()) return poses.status();

  const Mesh mesh = ExtractMesh(section->background, section->scale, nullptr);
  BirdsEyeOptions options = picture_;
  options.title = name->ToString();
  options.subtitle = CountText(poses->size()) + " frames, " +
                     LengthText(section->scale.voxel_size_m) + " voxels, revision " +
                     std::to_string(section->revision.value());
  options.use_mesh_colors = !by_height_;
  const BirdsEyePicture picture = DrawBirdsEye(mesh, PathsOf(*poses), options);
  absl::Status status = file->Write(EncodeColorPng(picture.image));
  if (status.ok()) status = file->Commit();
  if (!status.ok()) return status;
  context_->out << output_ << ": " << picture.image.width_px() << " x " << picture.image.height_px()
                << " pixels, revision " << section->revision.value() << " of " << name->ToString()
                << '\n';
  return absl::OkStatus();
}

}  // namespace steadymap
