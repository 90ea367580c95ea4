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

/// Timeouts of the calls, which end with `DeadlineExceeded`.
struct MapClientOptions {
  std::chrono::milliseconds call_timeout{30'000};  ///< Unary calls.
  std::chrono::milliseconds stream_timeout{
      600'000};  ///< Streaming calls: exports and map sections.
};

/// Settings of a new map besides its configuration. All of them can be changed later.
struct MapSettings {
  std::chrono::milliseconds max_commit_delay{};  ///< 0: the server's default.
  std::map<std::string, std::string> labels{};   ///< See `v1::Map.labels`.
  std::optional<v1::WorldFrame> world_frame{};   ///< See `v1::Map.world_frame`.
};

/// A ray in the world frame.
struct WorldRay {
  Eigen::Vector3d origin_world = Eigen::Vector3d::Zero();      ///< Metres.
  Eigen::Vector3d direction_world = Eigen::Vector3d::UnitX();  ///< Any length but zero.
};

/// Selects the objects of a map that pass every filter.
struct ObjectQuery {
  std::vector<ClassId> classes{};            ///< Empty: any class.
  std::optional<Box> box_world{};            ///< Overlapped by the object's cuboid.
  double min_stationarity = 0.0;             ///< In [0, 1].
  Revision changed_since{};                  ///< Changed after it; 0: all.
  bool with_archived_and_tentative = false;  ///< False: only objects that are part of the map.
};

/// Selects the events of a map that pass every filter.
struct EventQuery {
  std::vector<v1::EventType> types{};  ///< Empty: any type.
  std::vector<ObjectId> objects{};     ///< Empty: any object.
  std::vector<ClassId> classes{};      ///< Empty: any class.
  EventNumber first{};                 ///< Smallest event number; 0: no limit.
  Revision changed_since{};            ///< Recorded after it; 0: all.
  std::optional<Timestamp> start{};    ///< Earliest capture time, included.
  std::optional<Timestamp> end{};      ///< Latest capture time, excluded; >= `start`.
};

/// A list collected from all its pages, and the revision of the last page.
template <typename Message>
struct MapList {
  Revision revision;
  std::vector<Message> entries;
};

/// Selects a part of a map's volumes.
struct VolumeSelection {
  std::optional<Box> box_world{};   ///< World frame, metres; none: everywhere.
  std::vector<ObjectId> objects{};  ///< 0: background. Empty: the whole current map.
};

/// Result of an export.
struct ExportSummary {
  Revision revision;             ///< Of the exported map.
  std::uint64_t file_bytes = 0;  ///< Length of the file.
  std::uint64_t triangles = 0;   ///< Of the surface; 0 for volumes.
};

/// Creates, reads and queries maps on a server.
///
/// Every error has the service's code and message and, if the service sent them, the reason and the
/// field path (`ReasonOf`, `FieldOf` in core/types/error.h). No call is retried. Thread-safe.
class MapClient {
 public:
  explicit MapClient(const std::shared_ptr<grpc::ChannelInterface>& channel,
                     const MapClientOptions& options = {});

  /// Creates a map. Fields missing in `config` take the server's defaults.
  absl::StatusOr<v1::Map> CreateMap(const MapName& name,
                                    const v1::MapConfig& config,
                                    const MapSettings& settings = {});

  absl::StatusOr<v1::Map> GetMap(const MapName& name);

  /// Returns all maps of a tenant, sorted by name. Reads all pages.
  absl::StatusOr<std::vector<v1::Map>> ListMaps(const std::string& tenant);

  /// Changes the fields named by the paths in `request.update_mask`. `ChangeMap` in
  /// client/map/map_change.h is the same operation in terms of labels and classes. Errors:
  /// `Aborted` with reason `ETAG_MISMATCH` if `request.map.etag` is not the current etag of the
  /// map.
  absl::StatusOr<v1::Map> UpdateMap(const v1::UpdateMapRequest& request);

  absl::Status DeleteMap(const MapName& name);

  /// Returns the state and the signed distance of each point (world frame, metres). At most 100 000
  /// points.
  absl::StatusOr<v1::SampleDistanceResponse> SampleDistance(
      const MapName& name, std::span<const Eigen::Vector3d> points_world);

  /// Returns the first surface along each ray and the length of its free part. At most 100 000
  /// rays. `max_range_m` 0: the server's default.
  absl::StatusOr<v1::CastRaysResponse> CastRays(const MapName& name,
                                                std::span<const WorldRay> rays,
                                                double max_range_m = 0.0);

  /// Returns one object in any state, including archived and tentative. Errors: `NotFound` with the
  /// field `object_id`.
  absl::StatusOr<v1::Object> GetObject(const MapName& name, ObjectId object);

  /// Returns objects in ascending order of id. Reads all pages.
  absl::StatusOr<MapList<v1::Object>> ListObjects(const MapName& name,
                                                  const ObjectQuery& query = {});

  /// Returns events in ascending order of number. Reads all pages.
  absl::StatusOr<MapList<v1::ObjectEvent>> ListEvents(const MapName& name,
                                                      const EventQuery& query = {});

  /// Returns the leaves that overlap the selection, bit for bit as on the server, and the objects
  /// they belong to. Omits the last capture time and the mapper's internal state. Errors besides
  /// the service's: `DataLoss` for a leaf that cannot be unpacked, `InvalidArgument` for an invalid
  /// object, `Internal` for a protocol violation.
  absl::StatusOr<MapSnapshot> GetMapSection(const MapName& name,
                                            const VolumeSelection& selection = {});

  /// Receives the next chunk of a file. An error ends the export and becomes its result.
  using ChunkSink = std::function<absl::Status(std::string_view chunk)>;

  /// Streams the map as a file of `format` to `sink`, chunk by chunk. The received file is valid
  /// only if this function returns OK. Errors besides the service's and the sink's: `DataLoss` if
  /// the file is incomplete or its checksum differs; `Internal` for a protocol violation.
  absl::StatusOr<ExportSummary> ExportMap(const MapName& name,
                                          v1::ExportFormat format,
                                          const VolumeSelection& selection,
                                          const ChunkSink& sink);

  /// Returns the camera poses of the integrated frames in map_seq order. Reads all pages.
  absl::StatusOr<std::vector<v1::FramePose>> ListFramePoses(const MapName& name);

  /// Returns the robots that a map knows, by robot and sensor.
  absl::StatusOr<MapList<v1::Robot>> ListRobots(const MapName& name);

 private:
  MapClientOptions options_;
  std::unique_ptr<v1::MapService::StubInterface> maps_;
  std::unique_ptr<v1::QueryService::StubInterface> queries_;
};

}  // namespace steadymap
