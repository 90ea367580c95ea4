#include "client/cli/upload/upload_command.h"

#include <array>
#include <filesystem>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "client/cli/text/argument_text.h"

namespace steadymap {
namespace {

// Enough that a covered lens or a close wall does not decide; read in a fraction of a second.
constexpr std::size_t kSampledFrames = 9;

constexpr char kUploadFooter[] =
    "A PATH is the folder of a sequence or one that holds several; sequences are played one after\n"
    "the other. Returns when every frame is part of the map, and fails if any was refused or "
    "could\n"
    "not be read. Lost connections and server restarts are survived: only frames that are not\n"
    "durable yet are sent again, and those that the server lost because its disk was set back; "
    "none\n"
    "counts twice.\n\n"
    "Where a folder or file name is followed by a question mark, a recording may lack it. Images\n"
    "belong together by their place in natural order (torwic), by their number or by their time.\n"
    "Depth is 16-bit PNG, 0 and 65535 meaning none, unless told otherwise; poses are those of the\n"
    "camera (x right, y down, z forward) unless told otherwise.\n\n"
    "  torwic        TorWIC-Mapping. Depth/*.png in mm; poses.txt, a line an image: id sec nsec x "
    "y z\n"
    "                qx qy qz qw of the robot's base in metres; RGB/? ; Segmentation/? classes;\n"
    "                Instances/? ; calibration.txt? of three lines: w= h= fx= fy= cx= cy= of the "
    "camera,\n"
    "                tx ty tz qx qy qz qw of the camera on the base, metres a depth unit\n"
    "  seven-scenes  7-Scenes. frame-000000.depth.png in mm, frame-000000.pose.txt with the 4x4 "
    "matrix\n"
    "                of the camera, frame-000000.color.png?; 640 x 480 with a focal length of 585, "
    "or\n"
    "                camera-intrinsics.txt? with the 3x3 camera matrix. Its world is turned so "
    "that z\n"
    "                is up\n"
    "  tum           TUM RGB-D. depth.txt and rgb.txt?, a line an image: time file; "
    "groundtruth.txt,\n"
    "                a line a pose: time tx ty tz qx qy qz qw; times in seconds, at most 20 ms "
    "apart.\n"
    "                Depth has 5000 units a metre unless --depth-scale says otherwise, the camera "
    "is\n"
    "                640 x 480 with a focal length of 525 unless camera-intrinsics.txt? or "
    "--intrinsics do\n"
    "  co-fusion     Co-Fusion. calibration.txt: fx fy cx cy, or with w h behind; depth_original/ "
    "or\n"
    "                else depth_noise/ with *0001.exr in metres; trajectories/gt-cam-0.txt, a line "
    "a\n"
    "                pose: frame tx ty tz qx qy qz qw; colour/? ; mask_id/?, which are instances, "
    "and\n"
    "                classes for --label-map to turn into the map's. Its world is wherever the "
    "first\n"
    "                camera pose puts it: --T-world-dataset sets it upright\n"
    "  panoptic      the flat of panoptic mapping. timestamps.csv, a line a frame: id, "
    "nanoseconds;\n"
    "                000000_depth.tiff in metres; 000000_pose.txt with the 4x4 matrix of the "
    "camera;\n"
    "                000000_color.png? ; 000000_segmentation.png? with groundtruth_labels.csv in "
    "the\n"
    "                folder or beside it, or 000000_predicted.png? with 000000_labels.json\n\n"
    "Depth whose median is below 5 cm or above 100 m is refused as of a wrong unit. --depth-scale "
    "and\n"
    "--intrinsics are for torwic, seven-scenes and tum.\n\n"
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
  command
      ->add_option("--depth-scale",
                   dataset_.metres_per_unit,
                   "Metres a unit of depth images, 1e-6 to 0.1; without it, as the format has it")
      ->type_name("METRES");
  command
      ->add_option(
          "--intrinsics", intrinsics_, "The camera, pixels; without it, as the format has it")
      ->type_name("fx,fy,cx,cy");
  AddUploadRunOptions(command, &options_);
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status UploadCommand::Run() const {
  DatasetOptions dataset = dataset_;
  dataset.label_map_file = label_map_file_;
  dataset.T_world_dataset_file = T_world_dataset_file_;
  if (!intrinsics_.empty()) {
    const absl::StatusOr<std::array<double, 4>> intrinsics = ParseIntrinsics(intrinsics_);
    if (!intrinsics.ok()) return intrinsics.status();
    dataset.intrinsics = *intrinsics;
  }
  const std::vector<std::filesystem::path> paths(paths_.begin(), paths_.end());
  const absl::StatusOr<std::unique_ptr<DatasetSource>> source =
      OpenDataset(format_, paths, dataset);
  if (!source.ok()) return source.status();
  const RecordingSample sample = (*source)->Sample(kSampledFrames);
  absl::Status status = CheckDepth(sample, HasDepthUnit(format_));
  if (!status.ok()) return status;
  if (const std::optional<std::string> note = NoteOnTimes(sample)) context_->err << *note << '\n';
  status = RunUpload(options_, source->get(), context_);
  if ((*source)->skipped_count() > 0) {
    context_->err << (*source)->skipped_count() << " frames without a usable pose were left out\n";
  }
  return status;
}

}  // namespace steadymap
