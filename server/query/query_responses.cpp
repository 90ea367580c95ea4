#include "server/query/query_responses.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <absl/strings/str_cat.h>

#include "core/map/contradiction.h"
#include "core/query/map_sampler.h"
#include "core/types/error.h"
#include "proto/convert_geometry.h"
#include "proto/convert_robot.h"
#include "server/rpc/page_token.h"

namespace steadymap {
namespace {

constexpr int kMaxPoints = 100'000;
constexpr double kDefaultRangeM = 20.0;
constexpr double kMaxRangeM = 1000.0;
constexpr std::uint32_t kDefaultPoses = 1000;
constexpr std::uint32_t kMaxPoses = 10'000;

// About 1 ms; cancellation is checked between two reads.
constexpr std::size_t kPosesPerRead = 1000;

absl::Status CheckCount(const char* field, int count) {
  if (count <= kMaxPoints) return absl::OkStatus();
  return InvalidField(
      reason::kBadValue,
      field,
      absl::StrCat(field, " must have at most ", kMaxPoints, " entries, got ", count));
}

absl::Status CheckFinite(const std::string& field, const Eigen::Vector3d& vector) {
  if (vector.allFinite()) return absl::OkStatus();
  return InvalidField(reason::kBadValue, field, field + " must be finite");
}

absl::Status CheckRay(const v1::Ray& ray, int place) {
  const std::string path = absl::StrCat("rays[", place, "]");
  absl::Status status = CheckFinite(path + ".origin_m", FromProto(ray.origin_m()));
  if (!status.ok()) return status;
  const Eigen::Vector3d direction = FromProto(ray.direction());
  status = CheckFinite(path + ".direction", direction);
  if (!status.ok()) return status;
  if (!direction.isZero(0.0)) return absl::OkStatus();
  return InvalidField(reason::kBadValue, path + ".direction", "a direction must not be zero");
}

/// Returns OK, or the reason for which `work` ended; `field` contains the items to reduce.
absl::Status StatusOf(const QueryWork& work, const char* field) {
  if (!absl::IsResourceExhausted(work.status())) return work.status();
  return MakeError(
      absl::StatusCode::kResourceExhausted,
      reason::kWorkLimit,
      absl::StrCat(work.status().message(), "; request fewer or shorter ", field, " per call"),
      field);
}

v1::PointState StateMessage(PointState state) {
  switch (state) {
    case PointState::kUnknown:
      return v1::POINT_STATE_UNKNOWN;
    case PointState::kFree:
      return v1::POINT_STATE_FREE;
    case PointState::kSurface:
      return v1::POINT_STATE_SURFACE;
  }
  return v1::POINT_STATE_UNSPECIFIED;
}

v1::DistanceSample MakeMessage(const MapDistance& answer) {
  v1::DistanceSample message;
  message.set_state(StateMessage(answer.state));
  if (!answer.sample.known) return message;
  message.set_distance_m(answer.sample.distance_m);
  *message.mutable_gradient() = ToProto(answer.sample.gradient);
  message.set_weight(answer.sample.weight);
  message.set_object_id(answer.object.value());
  message.set_class_id(answer.class_id.value());
  return message;
}

v1::RayHit MakeMessage(const MapRayHit& answer) {
  v1::RayHit message;
  message.set_state(StateMessage(answer.state));
  message.set_free_until_m(answer.free_until_m);
  if (!answer.hit.hit) return message;
  message.set_range_m(answer.hit.range_m);
  *message.mutable_point_m() = ToProto(answer.hit.point_m);
  *message.mutable_normal() = ToProto(answer.hit.normal);
  message.set_object_id(answer.object.value());
  message.set_class_id(answer.class_id.value());
  return message;
}

v1::FramePose MakeMessage(const FramePose& pose) {
  v1::FramePose message;
  message.set_map_seq(pose.sequence.value());
  *message.mutable_capture_time() = ToProto(pose.capture_time);
  message.set_robot(pose.source.robot);
  message.set_sensor(pose.source.sensor);
  *message.mutable_world_from_camera() = ToProto(pose.T_world_camera);
  return message;
}

/// A response page with poses.
class PosePage {
 public:
  PosePage(std::size_t page_size, v1::ListFramePosesResponse* response)
      : page_size_(page_size), response_(response) {}

  /// Adds the pose. Returns false if the page is full.
  bool Add(const FramePose& pose) {
    if (static_cast<std::size_t>(response_->poses_size()) == page_size_ || bytes_ > kMaxPageBytes) {
      return false;
    }
    v1::FramePose* message = response_->add_poses();
    *message = MakeMessage(pose);
    bytes_ += message->ByteSizeLong();
    return true;
  }

 private:
  const std::size_t page_size_;
  v1::ListFramePosesResponse* const response_;
  std::size_t bytes_ = 0;
};

absl::StatusOr<double> ReadMaxRange(const v1::CastRaysRequest& request) {
  if (request.max_range_m() == 0.0) return kDefaultRangeM;
  // NaN fails the comparison.
  if (request.max_range_m() > 0.0 && request.max_range_m() <= kMaxRangeM) {
    return request.max_range_m();
  }
  return InvalidField(
      reason::kBadValue,
      "max_range_m",
      absl::StrCat("max_range_m must lie in (0, ", kMaxRangeM, "], got ", request.max_range_m()));
}

}  // namespace

absl::Status AnswerSampleDistance(const MapSnapshot& snapshot,
                                  const v1::SampleDistanceRequest& request,
                                  const Cancellation& cancellation,
                                  v1::SampleDistanceResponse* response,
                                  std::uint64_t max_steps) {
  absl::Status status = CheckCount("points_m", request.points_m_size());
  if (!status.ok()) return status;
  response->set_revision(snapshot.revision.value());
  MapSampler sampler(snapshot, QueryWork(cancellation, max_steps));
  for (int i = 0; i < request.points_m_size() && sampler.work().status().ok(); ++i) {
    const Eigen::Vector3d point_world = FromProto(request.points_m(i));
    status = CheckFinite(absl::StrCat("points_m[", i, "]"), point_world);
    if (!status.ok()) return status;
    *response->add_samples() = MakeMessage(sampler.Sample(point_world));
  }
  return StatusOf(sampler.work(), "points_m");
}

absl::Status AnswerCastRays(const MapSnapshot& snapshot,
                            const v1::CastRaysRequest& request,
                            const Cancellation& cancellation,
                            v1::CastRaysResponse* response,
                            std::uint64_t max_steps) {
  absl::Status status = CheckCount("rays", request.rays_size());
  if (!status.ok()) return status;
  const absl::StatusOr<double> max_range_m = ReadMaxRange(request);
  if (!max_range_m.ok()) return max_range_m.status();
  response->set_revision(snapshot.revision.value());
  MapSampler sampler(snapshot, QueryWork(cancellation, max_steps));
  for (int i = 0; i < request.rays_size() && sampler.work().status().ok(); ++i) {
    status = CheckRay(request.rays(i), i);
    if (!status.ok()) return status;
    // `stableNormalized`: the squared norms of very long and very short directions are outside the
    // range of a double.
    const Eigen::Vector3d unit = FromProto(request.rays(i).direction()).stableNormalized();
    *response->add_hits() =
        MakeMessage(sampler.CastRay(FromProto(request.rays(i).origin_m()), unit, *max_range_m));
  }
  return StatusOf(sampler.work(), "rays");
}

absl::Status AnswerListRobots(const MapSnapshot& snapshot, v1::ListRobotsResponse* response) {
  response->set_revision(snapshot.revision.value());
  const auto contradictions = FindContradictions(snapshot);
  for (const auto& [name, state] : snapshot.robots) {
    v1::Robot* robot = response->add_robots();
    *robot = ToProto(name, state);
    const auto found = contradictions.find(name);
    if (found == contradictions.end()) continue;
    for (const SensorContradiction& other : found->second) {
      *robot->add_contradictions() = ToProto(other);
    }
  }
  return absl::OkStatus();
}

absl::Status AnswerListFramePoses(Store& store,
                                  MapKey map,
                                  const MapSnapshot& snapshot,
                                  const v1::ListFramePosesRequest& request,
                                  const Cancellation& cancellation,
                                  v1::ListFramePosesResponse* response) {
  const absl::StatusOr<std::size_t> page_size =
      ReadPageSize(request.page_size(), kDefaultPoses, kMaxPoses);
  if (!page_size.ok()) return page_size.status();
  const std::string scope = ScopeOf("poses", map, request);
  const absl::StatusOr<ListingPosition> start = ReadListingToken(
      scope, request.page_token(), {0, snapshot.integrated().value(), snapshot.revision});
  if (!start.ok()) return start.status();
  response->set_revision(start->revision.value());
  PosePage page(*page_size, response);
  MapSequence next = MapSequence(start->last).Next();
  while (true) {
    if (absl::Status status = cancellation.Check(); !status.ok()) return status;
    const absl::StatusOr<std::vector<FramePose>> poses =
        store.ReadPoses(map, next, MapSequence(start->end), kPosesPerRead);
    if (!poses.ok()) return poses.status();
    for (const FramePose& pose : *poses) {
      if (page.Add(pose)) continue;
      response->set_next_page_token(
          MakeListingToken(scope, {pose.sequence.value() - 1, start->end, start->revision}));
      return absl::OkStatus();
    }
    if (poses->size() < kPosesPerRead) return absl::OkStatus();
    next = poses->back().sequence.Next();
  }
}

}  // namespace steadymap
