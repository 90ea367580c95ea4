#include "server/query_answers.h"

#include <cstdint>

#include <absl/strings/str_cat.h>

#include "core/error.h"
#include "core/map_sampler.h"
#include "proto/convert_geometry.h"
#include "server/page_token.h"

namespace steadymap {
namespace {

constexpr int kMaxPoints = 100'000;
constexpr double kDefaultRangeM = 20.0;
constexpr double kMaxRangeM = 1000.0;
constexpr std::uint32_t kDefaultPoses = 1000;
constexpr std::uint32_t kMaxPoses = 10'000;

absl::Status CheckCount(const char* field, int count) {
  if (count <= kMaxPoints) return absl::OkStatus();
  return InvalidField(reason::kBadValue,
                      field,
                      absl::StrCat(field, " may hold ", kMaxPoints, " entries, got ", count));
}

absl::Status CheckFinite(const std::string& field, const Eigen::Vector3d& vector) {
  if (vector.allFinite()) return absl::OkStatus();
  return InvalidField(reason::kBadValue, field, field + " must be finite");
}

v1::DistanceSample MakeMessage(const MapDistance& answer) {
  v1::DistanceSample message;
  if (!answer.sample.known) return message;
  message.set_known(true);
  message.set_distance_m(answer.sample.distance_m);
  *message.mutable_gradient() = ToProto(answer.sample.gradient);
  message.set_weight(answer.sample.weight);
  message.set_object_id(answer.object.value());
  message.set_class_id(answer.class_id.value());
  return message;
}

v1::RayHit MakeMessage(const MapRayHit& answer) {
  v1::RayHit message;
  if (!answer.hit.hit) return message;
  message.set_hit(true);
  message.set_range_m(answer.hit.range_m);
  *message.mutable_point_m() = ToProto(answer.hit.point_m);
  *message.mutable_normal() = ToProto(answer.hit.normal);
  message.set_object_id(answer.object.value());
  message.set_class_id(answer.class_id.value());
  return message;
}

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
                                  v1::SampleDistanceResponse* response) {
  absl::Status status = CheckCount("points_m", request.points_m_size());
  if (!status.ok()) return status;
  response->set_revision(snapshot.revision.value());
  MapSampler sampler(snapshot);
  for (int i = 0; i < request.points_m_size(); ++i) {
    const Eigen::Vector3d point_world = FromProto(request.points_m(i));
    status = CheckFinite(absl::StrCat("points_m[", i, "]"), point_world);
    if (!status.ok()) return status;
    *response->add_samples() = MakeMessage(sampler.Sample(point_world));
  }
  return absl::OkStatus();
}

absl::Status AnswerCastRays(const MapSnapshot& snapshot,
                            const v1::CastRaysRequest& request,
                            v1::CastRaysResponse* response) {
  absl::Status status = CheckCount("rays", request.rays_size());
  if (!status.ok()) return status;
  const absl::StatusOr<double> max_range_m = ReadMaxRange(request);
  if (!max_range_m.ok()) return max_range_m.status();
  response->set_revision(snapshot.revision.value());
  MapSampler sampler(snapshot);
  for (int i = 0; i < request.rays_size(); ++i) {
    const std::string path = absl::StrCat("rays[", i, "]");
    const Eigen::Vector3d origin_world = FromProto(request.rays(i).origin_m());
    const Eigen::Vector3d direction_world = FromProto(request.rays(i).direction());
    status = CheckFinite(path + ".origin_m", origin_world);
    if (status.ok()) status = CheckFinite(path + ".direction", direction_world);
    if (!status.ok()) return status;
    if (direction_world.isZero(0.0)) {
      return InvalidField(reason::kBadValue, path + ".direction", "a direction must not be zero");
    }
    // Stable: the squares of very long and very short directions leave the range of a double.
    const Eigen::Vector3d unit = direction_world.stableNormalized();
    *response->add_hits() = MakeMessage(sampler.CastRay(origin_world, unit, *max_range_m));
  }
  return absl::OkStatus();
}

absl::Status AnswerListFramePoses(Store& store,
                                  const MapRuntime& map,
                                  const v1::ListFramePosesRequest& request,
                                  v1::ListFramePosesResponse* response) {
  const absl::StatusOr<std::size_t> page_size =
      ReadPageSize(request.page_size(), kDefaultPoses, kMaxPoses);
  if (!page_size.ok()) return page_size.status();
  const std::string scope = absl::StrCat("poses of ", map.key().value(), " behind ");
  const absl::StatusOr<std::uint64_t> last = ReadNumberToken(scope, request.page_token());
  if (!last.ok()) return last.status();
  const std::shared_ptr<const MapSnapshot> snapshot = map.snapshot();
  // One more than asked for tells whether there is another page.
  absl::StatusOr<std::vector<FramePose>> poses =
      store.ReadPoses(map.key(), MapSequence(*last).Next(), snapshot->integrated(), *page_size + 1);
  if (!poses.ok()) return poses.status();
  const bool more = poses->size() > *page_size;
  if (more) poses->pop_back();
  response->set_revision(snapshot->revision.value());
  for (const FramePose& pose : *poses) {
    v1::FramePose* message = response->add_poses();
    message->set_map_seq(pose.sequence.value());
    *message->mutable_capture_time() = ToProto(pose.capture_time);
    message->set_robot(pose.source.robot);
    message->set_sensor(pose.source.sensor);
    *message->mutable_world_from_camera() = ToProto(pose.T_world_camera);
  }
  if (more) {
    response->set_next_page_token(
        MakePageToken(scope, absl::StrCat(poses->back().sequence.value())));
  }
  return absl::OkStatus();
}

}  // namespace steadymap
