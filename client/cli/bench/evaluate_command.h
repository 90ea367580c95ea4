#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "client/bench/evaluation/method/method.h"
#include "client/bench/evaluation/report/evaluation.h"
#include "client/cli/text/command_context.h"
#include "client/dataset/dataset.h"

namespace steadymap {

/// The command `steadymap evaluate`. Its lifetime must cover parsing and execution.
class EvaluateCommand {
 public:
  EvaluateCommand(CLI::App* app, CommandContext* context);

 private:
  void AddSources(CLI::App* command);

  absl::Status Run() const;
  absl::StatusOr<std::vector<Evaluation>> EvaluateAll() const;
  absl::StatusOr<Evaluation> EvaluateNamedRoute(const std::string& name) const;
  absl::StatusOr<Evaluation> EvaluateSequences() const;

  absl::StatusOr<std::vector<Method>> MethodsFor(const MapConfig& config) const;

  /// Returns the configuration of the maps: `defaults` with the given options.
  absl::StatusOr<MapConfig> ConfigOfMaps(MapConfig defaults) const;

  /// Returns a visitor that writes the mesh and the picture of each map into the folders for them;
  /// empty without folders. Stores the first error in `status`.
  MapVisitor MapWriter(const std::string& title, absl::Status* status) const;

  CommandContext* context_;
  std::vector<std::string> routes_;
  std::vector<std::string> sequences_;
  std::string format_;
  std::string label_map_file_;
  std::string T_world_dataset_file_;
  std::vector<std::string> policies_;
  std::vector<std::string> parameters_;
  std::vector<std::uint64_t> seeds_ = {1};
  std::size_t stride_ = 1;
  std::optional<double> wrong_labels_;
  std::vector<std::size_t> lost_;  ///< First frame and number of frames; empty: none.
  double voxel_size_m_ = 0.0;      ///< 0: the default of the route.
  double map_voxel_size_m_ = 0.0;  ///< Of the maps; 0: the default of the route.
  double max_depth_m_ = 0.0;       ///< Of the maps; 0: the default of the route.
  std::string pictures_folder_;
  std::string meshes_folder_;
  SensorModel sensor_ = SensorModel::Full();
  bool with_ground_ = false;
  bool with_stages_ = false;
  bool with_faults_ = false;
  bool as_json_ = false;
};

}  // namespace steadymap
