#include "core/change/visibility.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace steadymap {
namespace {

// Surface seen flatter than this is not judged: its depth changes too fast along the picture.
constexpr float kMinJudgedCosine = 0.25F;

// Surface that was measured this close may be the one that should be there: pose error and half the
// way between samples.
constexpr float kPresentReachM = 0.06F;
constexpr float kPresentReachPerMetre = 0.025F;

// Nearer than this a newer surface may be the same one, badly fitted.
constexpr float kReplacedFromM = 0.08F;
constexpr float kReplacedCosine = 0.7F;

// A thing thinner than that was seen from one side, and nobody knows how deep it is.
constexpr double kKnownDepthM = 0.2;

// As near as that to what was seen of a thing may still be within it: its far end shows last.
constexpr double kWithinM = 0.2;

/// Whether surface at a point can stand behind a thing.
bool LeavesRoom(const Cuboid& cuboid, const Eigen::Vector3d& point_world) {
  return cuboid.size_m.head<2>().minCoeff() >= kKnownDepthM &&
         DistanceTo(cuboid, point_world) > kWithinM;
}

}  // namespace

VisibilityTest::VisibilityTest(const JudgedFrame& frame,
                               const std::vector<ObjectInView>& objects,
                               const Association& association,
                               const VisibilityParameters& parameters)
    : frame_(frame),
      objects_(objects),
      association_(association),
      parameters_(parameters),
      T_camera_world_(frame.cloud.T_world_camera().inverse().cast<float>()),
      camera_world_(frame.cloud.T_world_camera().translation().cast<float>()) {}

/// Depth at which the ray through a point meets the plane of a sample; `depth_m` is that of the
/// point. 0 where they hardly meet.
float VisibilityTest::DepthAlong(const Eigen::Vector3f& point_world,
                                 float depth_m,
                                 const SurfaceSample& sample) const {
  const Eigen::Vector3f ray_world = point_world - camera_world_;
  const float along_normal_m = -sample.normal_world.dot(ray_world);
  if (along_normal_m < kMinJudgedCosine * ray_world.norm()) return 0.0F;
  return depth_m * sample.normal_world.dot(camera_world_ - sample.position_world) / along_normal_m;
}

/// The sample around a place of the grid that shows the surface at a point; null if none does: each
/// lies in the plane of the other, lest the side of another thing stands for a front. The one at
/// the place itself comes first, since it was measured along the point's ray.
const SurfaceSample* VisibilityTest::FindPresent(const TrackedObject& object,
                                                 int column,
                                                 int row,
                                                 const Eigen::Vector3f& point_world,
                                                 const Eigen::Vector3f& normal_world,
                                                 float depth_m) const {
  const float reach_m = kPresentReachM + kPresentReachPerMetre * depth_m;
  const auto fit_m = static_cast<float>(FitTolerance(depth_m, parameters_.truncation_m));
  const auto shows_point = [&](const SurfaceSample& sample) {
    if (!sample.is_valid() || sample.label != object.state().class_id.value()) return false;
    const Eigen::Vector3f way = point_world - sample.position_world;
    return way.squaredNorm() < reach_m * reach_m &&
           std::abs(way.dot(sample.normal_world)) < fit_m &&
           std::abs(way.dot(normal_world)) < fit_m;
  };
  if (shows_point(frame_.samples.At(column, row))) return &frame_.samples.At(column, row);
  for (int v = std::max(row - 1, 0); v <= std::min(row + 1, frame_.samples.height() - 1); ++v) {
    for (int u = std::max(column - 1, 0); u <= std::min(column + 1, frame_.samples.width() - 1);
         ++u) {
      if (shows_point(frame_.samples.At(u, v))) return &frame_.samples.At(u, v);
    }
  }
  return nullptr;
}

bool VisibilityTest::IsReplaced(const TrackedObject& object,
                                LeafOrigin leaf,
                                std::size_t sample_index,
                                const Eigen::Vector3f& point_world,
                                const Eigen::Vector3f& normal_world) const {
  const std::uint32_t owner = association_.owner[sample_index];
  if (!Association::IsObject(owner)) return false;
  const ObjectState& newer = objects_[owner - 1].object->state();
  if (newer.id == object.id() || newer.status != ObjectStatus::kPresent ||
      newer.class_id != object.state().class_id) {
    return false;
  }
  const SurfaceSample& sample = frame_.samples[sample_index];
  const float ahead_m = (sample.position_world - point_world).dot(normal_world);
  if (ahead_m < kReplacedFromM || ahead_m > static_cast<float>(parameters_.replaced_within_m) ||
      sample.normal_world.dot(normal_world) < kReplacedCosine) {
    return false;
  }
  if (LeavesRoom(objects_[owner - 1].object->cuboid(), point_world.cast<double>())) return false;
  const Timestamp confirmed = object.state().evidence.ConfirmedAt(leaf);
  return newer.in_place_since > confirmed + kConfirmationGrain;
}

/// Whether any sample was found to be of the object.
bool VisibilityTest::IsMatched(const TrackedObject& object) const {
  return std::any_of(
      association_.owner.begin(), association_.owner.end(), [&](std::uint32_t owner) {
        return Association::IsObject(owner) && objects_[owner - 1].object == &object;
      });
}

/// The verdict on an object that nothing was matched with, as the paper has it: gone, if enough of
/// its points lie in the frustum (Qian et al., RSS 2022).
ObjectVerdict VisibilityTest::JudgeByFrustum(const TrackedObject& object) const {
  ObjectVerdict result;
  std::size_t visible = 0;
  const Eigen::Isometry3f T_camera_object =
      T_camera_world_ * object.state().T_world_object.ToIsometry().cast<float>();
  const std::vector<SurfaceLeaf>& leaves = object.surface().leaves();
  for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
    std::array<bool, kEvidenceCells> is_visible{};
    for (const SurfaceVoxel& point : leaves[leaf].points) {
      const Eigen::Vector3f point_camera = T_camera_object * point.position_object;
      if (point_camera.z() < kMinJudgedDepthM ||
          point_camera.z() > static_cast<float>(parameters_.max_depth_m) ||
          !frame_.samples.FindPlace(frame_.cloud.camera(), point_camera)) {
        continue;
      }
      ++visible;
      is_visible[point.cell] = true;
    }
    for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
      if (!is_visible[cell]) continue;
      result.cells.push_back({leaf, static_cast<std::uint8_t>(cell), Verdict::kSeenThrough});
    }
  }
  const auto points = static_cast<double>(object.surface().point_count());
  if (static_cast<double>(visible) < parameters_.min_visible_share * points) return {};
  result.seen_through = result.cells.size();
  return result;
}

/// Whether the frame looks through a place where surface of an object should be, or past it.
bool VisibilityTest::IsSeenThrough(const TrackedObject& object,
                                   SamplePlace place,
                                   float depth_m) const {
  if (!parameters_.is_by_depth) return false;
  const MinDepthGrid& tiles = frame_.tiles;
  if (tiles.NearestAround(place.column, place.row) > depth_m + SeenThroughMargin(depth_m)) {
    return true;
  }
  return depth_m < static_cast<float>(parameters_.sure_depth_m) && depth_m < tiles.farthest_m() &&
         frame_.far_tiles.ShowOther(object.state().class_id, place.column, place.row);
}

/// The verdict on a point of the surface, none if it is occluded or out of view. Points that
/// are present are added to `sums`.
std::optional<Verdict> VisibilityTest::JudgePoint(const TrackedObject& object,
                                                  LeafOrigin leaf,
                                                  const Eigen::Vector3f& point_world,
                                                  const Eigen::Vector3f& normal_world,
                                                  PresentSums* sums) const {
  const Eigen::Vector3f point_camera = T_camera_world_ * point_world;
  const float depth_m = point_camera.z();
  if (depth_m < kMinJudgedDepthM || depth_m > static_cast<float>(parameters_.max_depth_m)) {
    return std::nullopt;
  }
  const Eigen::Vector3f normal_camera = T_camera_world_.linear() * normal_world;
  if (-normal_camera.dot(point_camera) < kMinJudgedCosine * point_camera.norm())
    return std::nullopt;
  const std::optional<SamplePlace> place =
      frame_.samples.FindPlace(frame_.cloud.camera(), point_camera);
  if (!place.has_value()) return std::nullopt;
  const auto [column, row] = *place;
  if (const SurfaceSample* sample =
          FindPresent(object, column, row, point_world, normal_world, depth_m)) {
    sums->change.AddRay(static_cast<double>(depth_m),
                        static_cast<double>(DepthAlong(point_world, depth_m, *sample)));
    const float offset_m = normal_world.dot(sample->position_world - point_world);
    sums->turn.Add(
        point_world.cast<double>(), normal_world.cast<double>(), static_cast<double>(offset_m));
    return Verdict::kPresent;
  }
  if (IsSeenThrough(object, *place, depth_m)) return Verdict::kSeenThrough;
  if (IsReplaced(object, leaf, frame_.samples.Index(column, row), point_world, normal_world)) {
    return Verdict::kReplaced;
  }
  return std::nullopt;
}

ObjectVerdict VisibilityTest::Judge(const TrackedObject& object) const {
  if (!parameters_.is_by_depth && !IsMatched(object)) return JudgeByFrustum(object);
  ObjectVerdict result;
  PresentSums sums(parameters_.change);
  const Eigen::Isometry3f T_world_object = object.state().T_world_object.ToIsometry().cast<float>();
  const std::vector<SurfaceLeaf>& leaves = object.surface().leaves();
  for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
    // Votes of each cell's points, by verdict.
    std::array<std::array<std::uint8_t, 3>, kEvidenceCells> votes{};
    for (const SurfaceVoxel& point : leaves[leaf].points) {
      const std::optional<Verdict> verdict =
          JudgePoint(object,
                     leaves[leaf].origin,
                     T_world_object * point.position_object,
                     T_world_object.linear() * point.normal_object,
                     &sums);
      if (verdict) ++votes[point.cell][static_cast<std::size_t>(*verdict)];
    }
    for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
      const auto& [present, seen_through, replaced] = votes[cell];
      if (present + seen_through + replaced == 0) continue;
      Verdict verdict = Verdict::kPresent;
      if (present == 0) {
        verdict = seen_through > 0 ? Verdict::kSeenThrough : Verdict::kReplaced;
      }
      result.cells.push_back({leaf, static_cast<std::uint8_t>(cell), verdict});
      result.present += verdict == Verdict::kPresent ? 1U : 0U;
      result.seen_through += verdict == Verdict::kSeenThrough ? 1U : 0U;
      result.replaced += verdict == Verdict::kReplaced ? 1U : 0U;
    }
  }
  if (sums.turn.Exceeds(parameters_.turn)) {
    for (CellVerdict& cell : result.cells) {
      if (cell.verdict == Verdict::kPresent) cell.verdict = Verdict::kTurned;
    }
    std::swap(result.present, result.turned);
  } else {
    result.change_m = sums.change.Change();
  }
  return result;
}

}  // namespace steadymap
