#include "client/cli/upload/upload_command.h"

#include <array>
#include <filesystem>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "client/cli/text/argument_text.h"
#include "client/cli/text/enumerator_text.h"
#include "core/types/error.h"

namespace steadymap {
namespace {

// Enough frames that a single covered lens or close wall does not determine the median. They are
// read in a fraction of a second.
constexpr std::size_t kSampledFrames = 9;

constexpr char kUploadFooter[] =
    "A PATH is the folder of a sequence, or a folder that contains several; sequences are\n"
    "played one after the other. The command returns when every frame is in the map, and fails\n"
    "if a frame was refused or could not be read. The upload continues after lost connections\n"
    "and server restarts. Only frames that are not durable yet are sent again, and frames that\n"
    "the server lost because its disk was restored from an older copy. No frame is integrated\n"
    "twice.\n\n"
    "A question mark after a folder or a file marks it as optional. Images are associated by\n"
    "their position in natural order (torwic), by their number or by their time. Unless stated\n"
    "otherwise, depth is 16-bit PNG, where 0 and 65535 mean no depth, and poses are those of\n"
    "the camera (x right, y down, z forward).\n\n"
    "  torwic        TorWIC-Mapping. Depth/*.png in mm; poses.txt, one line per image: id sec\n"
    "                nsec x y z qx qy qz qw of the robot's base in metres; RGB/? ;\n"
    "                Segmentation/? with classes; Instances/? ; calibration.txt? with three\n"
    "                lines: w= h= fx= fy= cx= cy= of the camera, tx ty tz qx qy qz qw of the\n"
    "                camera in the base frame, metres per depth unit\n"
    "  seven-scenes  7-Scenes. frame-000000.depth.png in mm, frame-000000.pose.txt with the\n"
    "                4x4 matrix of the camera, frame-000000.color.png?; 640 x 480 with a focal\n"
    "                length of 585, or camera-intrinsics.txt? with the 3x3 camera matrix. The\n"
    "                world frame is rotated so that z is up\n"
    "  tum           TUM RGB-D. depth.txt and rgb.txt?, one line per image: time file;\n"
    "                groundtruth.txt, one line per pose: time tx ty tz qx qy qz qw; times in\n"
    "                seconds, at most 20 ms apart. Depth has 5000 units per metre, or\n"
    "                --depth-scale; the camera is 640 x 480 with a focal length of 525, or\n"
    "                camera-intrinsics.txt? or --intrinsics\n"
    "  co-fusion     Co-Fusion. calibration.txt: fx fy cx cy, optionally followed by w h;\n"
    "                depth_original/, otherwise depth_noise/, with *0001.exr in metres;\n"
    "                trajectories/gt-cam-0.txt, one line per pose: frame tx ty tz qx qy qz qw;\n"
    "                colour/? ; mask_id/?, used as instances, and as classes that --label-map\n"
    "                converts to the map's. The world frame depends on the first camera pose:\n"
    "                --T-world-dataset makes z point up\n"
    "  panoptic      the flat of Panoptic Mapping. timestamps.csv, one line per frame: id,\n"
    "                nanoseconds; 000000_depth.tiff in metres; 000000_pose.txt with the 4x4\n"
    "                matrix of the camera; 000000_color.png? ; 000000_segmentation.png? with\n"
    "                groundtruth_labels.csv in the folder or its parent, or\n"
    "                000000_predicted.png? with 000000_labels.json\n\n"
    "A recording with a median depth below 5 cm or above 100 m is refused, because its unit\n"
    "must be wrong. --depth-scale and --intrinsics are for torwic, seven-scenes and tum.\n\n"
    "--label-map is a text file with one line `FROM TO` for each class id of the recording\n"
    "that has another id in the map. --T-world-dataset is a text file with the 4x4 matrix that\n"
    "transforms the recording's world frame to the map's. A map that does not exist is created\n"
    "if --policy is given. The options from --preset to --set are those of `steadymap map\n"
    "create`, whose --help describes them.";

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
  command->add_option("--label-map", label_map_file_, "Convert class ids to the map's")
      ->type_name("FILE");
  command
      ->add_option("--T-world-dataset",
                   T_world_dataset_file_,
                   "Transform from the recording's world frame to the map's")
      ->type_name("FILE");
  command
      ->add_option("--depth-scale",
                   dataset_.metres_per_unit,
                   "Metres per unit of depth images, 1e-6 to 0.1 (default: that of the format)")
      ->type_name("METRES");
  command
      ->add_option(
          "--intrinsics", intrinsics_, "Camera intrinsics, pixels (default: those of the format)")
      ->type_name("fx,fy,cx,cy");
  command
      ->add_option("--depth-sensor",
                   depth_sensor_,
                   "Kind of the depth camera, which determines the assumed noise: " +
                       WordsOf(v1::DepthSensor_descriptor()) + " (default: that of the format)")
      ->type_name("KIND");
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
  if (!depth_sensor_.empty()) {
    const int sensor = NumberOf(v1::DepthSensor_descriptor(), depth_sensor_);
    if (sensor == 0) {
      return InvalidField(reason::kBadValue,
                          "depth-sensor",
                          "the depth sensor must be one of " +
                              WordsOf(v1::DepthSensor_descriptor()) + ", got \"" + depth_sensor_ +
                              "\"");
    }
    dataset.depth_sensor = static_cast<v1::DepthSensor>(sensor);
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
    context_->err << (*source)->skipped_count() << " frames without a usable pose were skipped\n";
  }
  return status;
}

}  // namespace steadymap
