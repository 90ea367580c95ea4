#include "client/cli/bench/evaluate_command.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include <CLI/CLI.hpp>

#include "client/bench/evaluation/recording_evaluation.h"
#include "client/bench/evaluation/report/score_picture.h"
#include "client/bench/evaluation/report/score_table.h"
#include "client/bench/evaluation/report/stage_table.h"
#include "client/bench/evaluation/route_evaluation.h"
#include "client/bench/simulator/routes/named_routes.h"
#include "client/cli/bench/evaluation_json.h"
#include "client/cli/bench/parameter_option.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/text/json_text.h"
#include "client/cli/text/number_text.h"
#include "client/cli/text/output_file.h"
#include "client/cli/upload/progress_report.h"
#include "core/frame/image_codec.h"
#include "core/map/placed_volume.h"
#include "core/query/map_mesh.h"
#include "core/query/mesh_file.h"

namespace steadymap {
namespace {

/// Returns the error of a route name; empty if the name is valid.
std::string FindRouteFault(const std::string& name) {
  return std::string(MakeRoute(name).status().message());
}

std::string EvaluateFooter() {
  std::string footer =
      "Builds maps in this process, one for each policy, from the frames of a simulated route\n"
      "or of recorded sequences, and compares their surfaces with the ground truth at the end,\n"
      "voxel by voxel. Prints precision, recall and false positive rate, for matches in the\n"
      "same voxel and for matches within half a voxel (near). Ghosts: share of the vanished\n"
      "surface that the map still shows. Kept: share of the true surface observed only by\n"
      "earlier sequences that the map still has. Two references are always included: static\n"
      "fuses all frames, fresh only the last sequence. The ground truth of a recording is the\n"
      "map of its last sequence.\n\n"
      "Routes:";
  for (const std::string& route : RouteNames()) footer += " " + route;
  footer += " clutter-SEED\nPolicies:";
  for (const std::string& method : MethodNames()) footer += " " + method;
  return footer;
}

absl::Status WriteFile(const std::filesystem::path& path, std::string_view data) {
  absl::StatusOr<OutputFile> file = OutputFile::Create(path);
  if (!file.ok()) return file.status();
  const absl::Status status = file->Write(data);
  return status.ok() ? file->Commit() : status;
}

/// Returns the path of a file about a map: `title` and `method` without blanks.
std::filesystem::path PathOf(const std::string& folder,
                             const std::string& title,
                             const std::string& method,
                             const char* extension) {
  std::string name = title + "-" + method + extension;
  std::erase(name, ' ');
  return std::filesystem::path(folder) / name;
}

/// Returns the true visible surface as vertices without triangles.
Mesh PointsOf(const Reference& reference) {
  Mesh mesh;
  for (const std::vector<SurfacePoint>* points : {&reference.seen, &reference.ground}) {
    for (const SurfacePoint& point : *points) {
      mesh.vertices_world.push_back(point.position_world);
      mesh.normals_world.push_back(point.normal_world);
    }
  }
  return mesh;
}

}  // namespace

EvaluateCommand::EvaluateCommand(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const command =
      app->add_subcommand("evaluate", "Build maps by several policies and score them");
  command->footer(EvaluateFooter());
  AddSources(command);
  command->add_option("--policy", policies_, "Policies to compare (default: all)")
      ->check(CLI::IsMember(MethodNames()));
  AddParameterOption(command, &parameters_);
  command->add_option("--stride", stride_, "Use every N-th frame")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--voxel",
                   voxel_size_m_,
                   "Edge of the compared voxels (default: 0.06 m for table scenes, otherwise 0.2)")
      ->type_name("METRES")
      ->check(CLI::Range(0.02, 1.0));
  command
      ->add_option("--map-voxel",
                   map_voxel_size_m_,
                   "Edge of the maps' voxels, with a truncation of three voxels (default: 0.02 m "
                   "for table scenes, otherwise 0.05)")
      ->type_name("METRES")
      ->check(CLI::Range(0.001, 1.0));
  command
      ->add_option("--max-depth",
                   max_depth_m_,
                   "Largest depth that the maps use (default: 4 m for table scenes, otherwise 3)")
      ->type_name("METRES")
      ->check(CLI::Range(0.1, 100.0));
  command->add_flag("--ground", with_ground_, "Score the ground too");
  command->add_flag("--stages", with_stages_, "Show the time per stage of a frame");
  command->add_flag("--faults", with_faults_, "List what is wrong in the events of a route");
  command
      ->add_option(
          "--pictures", pictures_folder_, "Draw the scored voxels of each map into this folder")
      ->type_name("DIR");
  command
      ->add_option("--meshes",
                   meshes_folder_,
                   "Write the mesh of each map into this folder as PLY, and for a route its true "
                   "surface as points")
      ->type_name("DIR");
  command->add_flag("--json", as_json_, "Print the tables as JSON");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

void EvaluateCommand::AddSources(CLI::App* command) {
  CLI::Option* const route = command->add_option("--route", routes_, "Simulated routes")
                                 ->type_name("ROUTE")
                                 ->check(CLI::Validator(FindRouteFault, ""));
  command->add_option("--seed", seeds_, "Seeds of all noise; the scores are totals over all seeds")
      ->type_name("N")
      ->capture_default_str();
  CLI::Option* const ideal = command->add_flag_callback(
      "--ideal",
      [this] { sensor_ = SensorModel::Ideal(); },
      "Use a sensor without noise, holes or drift");
  command
      ->add_flag_callback(
          "--hard",
          [this] { sensor_ = SensorModel::Hard(); },
          "Use a sensor with correlated noise, fattened foreground, 7 % wrong labels, drift "
          "without bound and an offset of 5 cm between sequences")
      ->excludes(ideal);
  command
      ->add_option(
          "--wrong-labels",
          wrong_labels_,
          "Share of the objects in view that get a wrong class label, drawn for each frame; "
          "0.01 by default")
      ->type_name("SHARE")
      ->check(CLI::Range(0.0, 1.0))
      ->needs(route);
  command
      ->add_option("--lost",
                   lost_,
                   "Frames of a route in which the robot's pose is wrong by 1.5 m and 40 degrees: "
                   "the first frame, and their number")
      ->type_name("FRAME COUNT")
      ->expected(2)
      ->needs(route);
  CLI::Option* const format =
      command->add_option("--format", format_, "Layout of the recorded sequences")
          ->type_name("FORMAT")
          ->check(CLI::IsMember(DatasetFormats()));
  command->add_option("--sequence", sequences_, "Recorded sequences, in the order of the drives")
      ->type_name("PATH")
      ->needs(format)
      ->excludes(route);
  command->add_option("--label-map", label_map_file_, "Convert class ids to the map's")
      ->type_name("FILE");
  command
      ->add_option("--T-world-dataset",
                   T_world_dataset_file_,
                   "Transform from the recordings' world frame to the map's")
      ->type_name("FILE");
}

/// Returns the methods to compare, for maps with the configuration of a scene.
absl::StatusOr<std::vector<Method>> EvaluateCommand::MethodsFor(const MapConfig& config) const {
  const absl::StatusOr<MapConfig> base = ConfigOfMaps(config);
  if (!base.ok()) return base.status();
  return SelectMethods(policies_, *base);
}

absl::Status EvaluateCommand::Run() const {
  if (routes_.empty() && sequences_.empty()) {
    return absl::InvalidArgumentError("expected a --route, or a --format and its --sequence");
  }
  for (const std::string& folder : {pictures_folder_, meshes_folder_}) {
    if (folder.empty()) continue;
    if (absl::Status status = MakeFolder(folder); !status.ok()) return status;
  }
  const absl::StatusOr<std::vector<Evaluation>> evaluations = EvaluateAll();
  if (!evaluations.ok()) return evaluations.status();
  if (as_json_) context_->out << IndentedJson(EvaluationJson(*evaluations));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<Evaluation>> EvaluateCommand::EvaluateAll() const {
  std::vector<Evaluation> evaluations;
  const auto take = [&](absl::StatusOr<Evaluation> evaluation) {
    if (!evaluation.ok()) return evaluation.status();
    if (!as_json_) {
      context_->out << (evaluations.empty() ? "" : "\n") << ScoreTable(*evaluation);
      if (with_stages_) context_->out << StageTable(*evaluation);
      if (with_faults_) context_->out << EventFaultText(*evaluation);
      context_->out << std::flush;
    }
    evaluations.push_back(*std::move(evaluation));
    return absl::OkStatus();
  };
  for (const std::string& name : routes_) {
    const absl::Status status = take(EvaluateNamedRoute(name));
    if (!status.ok()) return status;
  }
  if (!sequences_.empty()) {
    const absl::Status status = take(EvaluateSequences());
    if (!status.ok()) return status;
  }
  return evaluations;
}

absl::StatusOr<Evaluation> EvaluateCommand::EvaluateNamedRoute(const std::string& name) const {
  absl::StatusOr<Route> route = MakeRoute(name);
  if (!route.ok()) return route.status();
  absl::StatusOr<std::vector<Method>> methods = MethodsFor(MapConfigFor(name));
  if (!methods.ok()) return methods.status();
  absl::Status write_status;
  RouteEvaluationOptions options;
  options.simulation.sensor = sensor_;
  if (wrong_labels_.has_value()) {
    options.simulation.sensor.label_flips = true;
    options.simulation.sensor.label_flip_share = *wrong_labels_;
  }
  options.simulation.stride = stride_;
  if (lost_.size() == 2) {
    options.simulation.lost.first_frame = lost_[0];
    options.simulation.lost.frame_count = lost_[1];
  }
  options.seeds = seeds_;
  options.voxel_size_m = voxel_size_m_ > 0.0 ? voxel_size_m_ : EvaluationVoxelFor(name);
  options.with_ground = with_ground_;
  options.methods = *std::move(methods);
  options.visit_map = MapWriter(name, &write_status);
  if (!meshes_folder_.empty()) {
    options.visit_reference = [&](const Reference& reference) {
      write_status.Update(
          WriteFile(PathOf(meshes_folder_, name, "truth", ".ply"), EncodePly(PointsOf(reference))));
    };
  }
  const std::size_t frame_total =
      Simulation(*route, options.simulation).frame_count() * seeds_.size();
  ProgressReport report(
      &context_->err, context_->err_is_terminal, "mapped", frame_total, SteadySeconds);
  std::size_t done = 0;
  options.on_frame = [&report, &done] {
    ++done;
    report.Update(done, done);
  };
  absl::StatusOr<Evaluation> evaluation = EvaluateRoute(*route, options);
  report.End();
  if (!write_status.ok()) return write_status;
  return evaluation;
}

absl::StatusOr<Evaluation> EvaluateCommand::EvaluateSequences() const {
  absl::StatusOr<std::vector<Method>> methods = MethodsFor(MapConfig());
  if (!methods.ok()) return methods.status();
  absl::Status write_status;
  RecordingEvaluationOptions options;
  options.format = format_;
  options.sequences.assign(sequences_.begin(), sequences_.end());
  options.dataset.stride = stride_;
  options.dataset.label_map_file = label_map_file_;
  options.dataset.T_world_dataset_file = T_world_dataset_file_;
  options.dataset.include_color = false;
  if (voxel_size_m_ > 0.0) options.voxel_size_m = voxel_size_m_;
  options.methods = *std::move(methods);
  options.visit_map = MapWriter(format_, &write_status);
  absl::StatusOr<Evaluation> evaluation = EvaluateRecording(options);
  if (!write_status.ok()) return write_status;
  return evaluation;
}

absl::StatusOr<MapConfig> EvaluateCommand::ConfigOfMaps(MapConfig defaults) const {
  absl::StatusOr<ParameterValues> parameters = ParseParameters(parameters_);
  if (!parameters.ok()) return parameters.status();
  defaults.parameters = *std::move(parameters);
  if (map_voxel_size_m_ > 0.0) {
    defaults.voxel_size_m = map_voxel_size_m_;
    defaults.truncation_m = DefaultTruncationM(map_voxel_size_m_);
  }
  if (max_depth_m_ > 0.0) defaults.max_depth_m = max_depth_m_;
  return defaults;
}

MapVisitor EvaluateCommand::MapWriter(const std::string& title, absl::Status* status) const {
  if (pictures_folder_.empty() && meshes_folder_.empty()) return {};
  return [this, title, status](
             const std::string& method, const MapScorer& scorer, const MethodOutcome& outcome) {
    if (!meshes_folder_.empty()) {
      const MapSnapshot& map = *outcome.map;
      status->Update(WriteFile(
          PathOf(meshes_folder_, title, method, ".ply"),
          EncodePly(ExtractMapMesh(ShownVolumes(map), map.scale, /*box_world=*/nullptr))));
    }
    if (pictures_folder_.empty()) return;
    const ScorePictureText text = {title + ", " + method,
                                   "surface scored within half a voxel of " +
                                       LengthText(scorer.voxel_size_m()) + ", from above"};
    status->Update(WriteFile(PathOf(pictures_folder_, title, method, ".png"),
                             EncodeColorPng(DrawScorePicture(
                                 scorer.Judge(outcome.surface), scorer.voxel_size_m(), text))));
  };
}

}  // namespace steadymap
