#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string_view>

#include <absl/status/statusor.h>

#include "client/bench/simulator/simulation.h"
#include "client/upload/frame_source.h"

namespace steadymap {

/// The frames of a simulated route, packed for upload: depth as ZSTD_UINT16, labels and instances
/// as ZSTD_UINT8 (instances as ZSTD_UINT16 if an id requires it), colour as PNG.
class SimulatedFrameSource : public FrameSource {
 public:
  SimulatedFrameSource(Route route, SimulationOptions options);

  /// Opens the route with this name. Errors: `InvalidArgument` for a name that `MakeRoute` rejects
  /// or a stride of 0.
  static absl::StatusOr<std::unique_ptr<SimulatedFrameSource>> Open(
      std::string_view route_name, const SimulationOptions& options);

  std::size_t frame_count() const override { return simulation_.frame_count(); }

  /// Never returns an error.
  absl::StatusOr<std::optional<v1::Frame>> Next() override;

  absl::StatusOr<v1::Frame> Read(std::size_t index) override;

  /// The underlying simulation, for its ground truth.
  const Simulation& simulation() const { return simulation_; }

 private:
  Simulation simulation_;
  std::size_t next_index_ = 0;
};

/// Packs a frame for upload in the encodings of `SimulatedFrameSource`. Omits empty images.
v1::Frame PackSimulatedFrame(const Frame& frame);

}  // namespace steadymap
