#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
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

#include "core/geometry/geometry.h"
#include "core/map/map_snapshot.h"
#include "core/types/identifiers.h"
#include "core/types/timestamp.h"

#include "steadymap/v1/map_service.grpc.pb.h"
#include "steadymap/v1/query_service.grpc.pb.h"

namespace steadymap {

/// How long calls may take before they end with `DeadlineExceeded`.
struct MapClientOptions {
  std::chrono::milliseconds call_timeout{30'000};     ///< Calls with one answer.
  std::chrono::milliseconds stream_timeout{600'000};  ///< Exports and sections, which stream.
};

/// What a new map has beside its configuration. All of it can be changed later.
struct MapSettings {
  std::chrono::milliseconds max_commit_delay{};  ///< 0: as the server is configured.
  std::map<std::string, std::string> labels{};   ///< As `v1::Map.labels`.
  std::optional<v1::WorldFrame> world_frame{};   ///< As `v1::Map.world_frame`.
};

/// A ray in the world frame.
struct WorldRay {
  Eigen::Vector3d origin_world = Eigen::Vector3d::Zero();      ///< Metres.
  Eigen::Vector3d direction_world = Eigen::Vector3d::UnitX();  ///< Any length but zero.
};

/// Which objects of a map are asked for: those that pass every filter.
struct ObjectQuery {
  std::vector<ClassId> classes{};            ///< Empty: of any class.
  std::optional<Box> box_world{};            ///< Whose cuboid touches it.
  double min_stationarity = 0.0;             ///< In [0, 1].
  Revision changed_since{};                  ///< That changed after it; 0: all.
  bool with_archived_and_tentative = false;  ///< Else only those that are part of the map.
};

/// Which events of a map are asked for: those that pass every filter.
struct EventQuery {
  std::vector<v1::EventType> types{};  ///< Empty: of any type.
  std::vector<ObjectId> objects{};     ///< Empty: of any object.
  std::vector<ClassId> classes{};      ///< Empty: of any class.
  EventNumber first{};                 ///< From this number on; 0: from the first.
  Revision changed_since{};            ///< That came after it; 0: all.
  std::optional<Timestamp> start{};    ///< Of frames captured then or later.
  std::optional<Timestamp> end{};      ///< Of frames captured before; not below `start`.
};

/// A list, however many pages it took, and the revision of the last one.
template <typename Message>
struct MapList {
  Revision revision;
  std::vector<Message> entries;
};

/// Which part of a map's volumes is asked for.
struct VolumeSelection {
  std::optional<Box> box_world{};   ///< World frame, metres; none: everywhere.
  std::vector<ObjectId> objects{};  ///< 0 is the background. Empty: what the map shows.
};

/// What was exported.
struct ExportSummary {
  Revision revision;             ///< At which the map was read.
  std::uint64_t file_bytes = 0;  ///< Length of the file.
  std::uint64_t triangles = 0;   ///< Of the surface; 0 for volumes.
};

/// Creates, reads and queries maps on a server.
///
/// Every error carries the service's code and message, and where the service gave them the reason
/// and the field path (`ReasonOf`, `FieldOf` in core/types/error.h). Nothing is retried.
/// Thread-safe.
class MapClient {
 public:
  explicit MapClient(const std::shared_ptr<grpc::ChannelInterface>& channel,
                     const MapClientOptions& options = {});

  /// Creates a map; what `config` leaves out takes the server's defaults.
  absl::StatusOr<v1::Map> CreateMap(const MapName& name,
                                    const v1::MapConfig& config,
                                    const MapSettings& settings = {});

  absl::StatusOr<v1::Map> GetMap(const MapName& name);

  /// All maps of a tenant in the order of their names, however many pages that takes.
  absl::StatusOr<std::vector<v1::Map>> ListMaps(const std::string& tenant);

  /// Changes the fields of a map that the paths in `request.update_mask` name; `ChangeMap` in
  /// client/map/map_change.h says the same in terms of labels and classes. Errors: `Aborted` with
  /// reason `ETAG_MISMATCH` where `request.map.etag` is not the map's present one.
  absl::StatusOr<v1::Map> UpdateMap(const v1::UpdateMapRequest& request);

  absl::Status DeleteMap(const MapName& name);

  /// State of each point (world frame, metres) and its signed distance, at most 100 000 points.
  absl::StatusOr<v1::SampleDistanceResponse> SampleDistance(
      const MapName& name, std::span<const Eigen::Vector3d> points_world);

  /// First surface along each ray and how far it is free, at most 100 000 rays. `max_range_m` 0:
  /// the server's default.
  absl::StatusOr<v1::CastRaysResponse> CastRays(const MapName& name,
                                                std::span<const WorldRay> rays,
                                                double max_range_m = 0.0);

  /// One object, whatever its standing. Errors: `NotFound` with the field `object_id`.
  absl::StatusOr<v1::Object> GetObject(const MapName& name, ObjectId object);

  /// Objects by rising id, however many pages that takes.
  absl::StatusOr<MapList<v1::Object>> ListObjects(const MapName& name,
                                                  const ObjectQuery& query = {});

  /// Events by rising number, however many pages that takes.
  absl::StatusOr<MapList<v1::ObjectEvent>> ListEvents(const MapName& name,
                                                      const EventQuery& query = {});

  /// The part of the map whose leaves touch the selection, with the server's bits, and the objects
  /// they belong to. Its last capture time and what only a mapper needs are left out.
  /// Errors beside the service's: `DataLoss` for a leaf that does not unpack, `InvalidArgument` for
  /// an object that makes no sense, `Internal` for an answer that breaks the protocol.
  absl::StatusOr<MapSnapshot> GetMapSection(const MapName& name,
                                            const VolumeSelection& selection = {});

  /// Takes the next piece of a file; an error ends the export and is its result.
  using ChunkSink = std::function<absl::Status(std::string_view chunk)>;

  /// Streams the map as a file of `format` to `sink`, piece by piece. What `sink` got is the file
  /// only where this returns OK. Errors beside the service's and the sink's: `DataLoss` if the file
  /// is cut off or differs from what the server made; `Internal` for an answer that breaks the
  /// protocol.
  absl::StatusOr<ExportSummary> ExportMap(const MapName& name,
                                          v1::ExportFormat format,
                                          const VolumeSelection& selection,
                                          const ChunkSink& sink);

  /// Where the integrated frames were taken, in map_seq order, however many pages that takes.
  absl::StatusOr<std::vector<v1::FramePose>> ListFramePoses(const MapName& name);

 private:
  MapClientOptions options_;
  std::unique_ptr<v1::MapService::StubInterface> maps_;
  std::unique_ptr<v1::QueryService::StubInterface> queries_;
};

}  // namespace steadymap
