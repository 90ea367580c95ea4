#include "client/cli/upload_command.h"

#include <filesystem>
#include <memory>

#include <CLI/CLI.hpp>

namespace steadymap {
namespace {

constexpr char kUploadFooter[] =
    "A PATH is the folder of a sequence or one that holds several; sequences are played one after\n"
    "the other. Returns when every frame is part of the map, and fails if any was refused or "
    "could\n"
    "not be read. Lost connections and server restarts are survived: only frames that are not\n"
    "durable yet are sent again, and none counts twice.\n\n"
    "  torwic        TorWIC-Mapping: Depth/, RGB/, Segmentation/, poses.txt\n"
    "  seven-scenes  7-Scenes: frame-000000.depth.png, .color.png, .pose.txt; its world is turned\n"
    "                so that z is up\n"
    "  tum           TUM RGB-D: depth.txt, rgb.txt, groundtruth.txt\n"
    "  co-fusion     Co-Fusion: calibration.txt, colour/, depth_original/ or else depth_noise/,\n"
    "                mask_id/, trajectories/gt-cam-0.txt; masks are instances, and classes for\n"
    "                --label-map to turn into the map's. Its world is wherever the first camera\n"
    "                pose puts it: --T-world-dataset sets it upright\n"
    "  panoptic      the flat of panoptic mapping: timestamps.csv, 000000_depth.tiff, _color.png,\n"
    "                _pose.txt, _segmentation.png with groundtruth_labels.csv beside the runs, or\n"
    "                _predicted.png with _labels.json\n\n"
    "--label-map names a text file with a line `FROM TO` for each class id of the recording that\n"
    "the map knows by another one. --T-world-dataset names a text file with the 4x4 matrix that\n"
    "takes the recording's world to the map's. A map that does not exist is created if --policy "
    "says\n"
    "how; the options from --policy to --classes are those of `steadymap map create`, whose "
    "--help\n"
    "tells more of them.";

}  // namespace

UploadCommand::UploadCommand(CLI::App* app, CommandContext* context) : context_(context) {
  options_.source = {"robot", SensorName::kDefaultSensor};
  CLI::App* const command =
      app->add_subcommand("upload", "Upload a recording and wait until it is in the map");
  command->footer(kUploadFooter);
  command->add_option("NAME", options_.map, "The map")->required();
  command->add_option("PATH", paths_, "Folders of the recording")->required();
  command->add_option("--format", format_, "Layout of the recording")
      ->required()
      ->check(CLI::IsMember(DatasetFormats()));
  command->add_option("--stride", dataset_.stride, "Upload every N-th frame")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--label-map", label_map_file_, "Turn class ids into the map's")
      ->type_name("FILE");
  command->add_option("--T-world-dataset", T_world_dataset_file_, "Place the recording in the map")
      ->type_name("FILE");
  AddUploadRunOptions(command, &options_);
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status UploadCommand::Run() const {
  DatasetOptions dataset = dataset_;
  dataset.label_map_file = label_map_file_;
  dataset.T_world_dataset_file = T_world_dataset_file_;
  const std::vector<std::filesystem::path> paths(paths_.begin(), paths_.end());
  const absl::StatusOr<std::unique_ptr<DatasetSource>> source =
      OpenDataset(format_, paths, dataset);
  if (!source.ok()) return source.status();
  absl::Status status = RunUpload(options_, source->get(), context_);
  if ((*source)->skipped_count() > 0) {
    context_->err << (*source)->skipped_count() << " frames without a usable pose were left out\n";
  }
  return status;
}

}  // namespace steadymap
