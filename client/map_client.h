#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <grpcpp/channel.h>

#include "core/geometry.h"
#include "core/identifiers.h"
#include "core/map_snapshot.h"

#include "steadymap/v1/map_service.grpc.pb.h"
#include "steadymap/v1/query_service.grpc.pb.h"

namespace steadymap {

/// How long calls may take before they end with `DeadlineExceeded`.
struct MapClientOptions {
  std::chrono::milliseconds call_timeout{30'000};     ///< Calls with one answer.
  std::chrono::milliseconds stream_timeout{600'000};  ///< Exports and sections, which stream.
};

/// A ray in the world frame.
struct WorldRay {
  Eigen::Vector3d origin_world = Eigen::Vector3d::Zero();      ///< Metres.
  Eigen::Vector3d direction_world = Eigen::Vector3d::UnitX();  ///< Any length but zero.
};

/// Creates, reads and queries maps on a server.
///
/// Every error carries the service's code and message, and where the service gave them the reason
/// and the field path (`ReasonOf`, `FieldOf` in core/error.h). Nothing is retried. Thread-safe.
class MapClient {
 public:
  explicit MapClient(const std::shared_ptr<grpc::ChannelInterface>& channel,
                     const MapClientOptions& options = {});

  /// Creates a map; what `config` leaves out takes the server's defaults.
  absl::StatusOr<v1::Map> CreateMap(const MapName& name, const v1::MapConfig& config);

  absl::StatusOr<v1::Map> GetMap(const MapName& name);

  /// All maps of a tenant in the order of their names, however many pages that takes.
  absl::StatusOr<std::vector<v1::Map>> ListMaps(const std::string& tenant);

  absl::Status DeleteMap(const MapName& name);

  /// Signed distance at each point (world frame, metres), at most 100 000 points.
  absl::StatusOr<v1::SampleDistanceResponse> SampleDistance(
      const MapName& name, std::span<const Eigen::Vector3d> points_world);

  /// First surface along each ray, at most 100 000 rays. `max_range_m` 0: the server's default.
  absl::StatusOr<v1::CastRaysResponse> CastRays(const MapName& name,
                                                std::span<const WorldRay> rays,
                                                double max_range_m = 0.0);

  /// The map, or the part of it whose leaves touch `box` (world frame), with the server's bits.
  /// Its last capture time is left out. Errors beside the service's: `DataLoss` for a leaf that
  /// does not unpack, `Internal` for an answer that breaks the protocol.
  absl::StatusOr<MapSnapshot> GetMapSection(const MapName& name,
                                            const std::optional<Box>& box = std::nullopt);

  /// Takes the next piece of a file; an error ends the export and is its result.
  using ChunkSink = std::function<absl::Status(std::string_view chunk)>;

  /// Streams the map as a file of `format` to `sink`, piece by piece. Errors beside the service's
  /// and the sink's: `DataLoss` if the pieces add up to another length than announced.
  absl::StatusOr<v1::ExportMapResponse::Header> ExportMap(const MapName& name,
                                                          v1::ExportFormat format,
                                                          const std::optional<Box>& box,
                                                          const ChunkSink& sink);

  /// Where the integrated frames were taken, in map_seq order, however many pages that takes.
  absl::StatusOr<std::vector<v1::FramePose>> ListFramePoses(const MapName& name);

 private:
  MapClientOptions options_;
  std::unique_ptr<v1::MapService::StubInterface> maps_;
  std::unique_ptr<v1::QueryService::StubInterface> queries_;
};

}  // namespace steadymap
