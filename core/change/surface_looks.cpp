#include "core/change/surface_looks.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace steadymap {
namespace {

enum class LookResult { kPresent, kAbsent };

/// The looks of one frame at one object.
class ObjectLook {
 public:
  ObjectLook(const LookedAtFrame& frame,
             const LookParameters& parameters,
             const VoxelScale& scale,
             const TrackedObject& object)
      : frame_(frame),
        parameters_(parameters),
        scale_(scale),
        spacing_per_m_(static_cast<float>(SampleGrid::SpacingPerM(frame.cloud.camera()))),
        label_(object.state().class_id.value()),
        T_world_object_(object.state().T_world_object.ToIsometry().cast<float>()),
        T_camera_world_(frame.cloud.T_world_camera().inverse().cast<float>()),
        camera_world_(frame.cloud.T_world_camera().translation().cast<float>()) {}

  /// Returns what the frame says about a surface point; none if the point is occluded, out of view
  /// or not measured.
  std::optional<LookResult> At(const SurfaceVoxel& point) const {
    const Eigen::Vector3f point_world = T_world_object_ * point.position_object;
    const Eigen::Vector3f normal_world = T_world_object_.linear() * point.normal_object;
    const Eigen::Vector3f to_camera = (camera_world_ - point_world).normalized();
    const float facing = normal_world.dot(to_camera);
    if (static_cast<double>(facing) < parameters_.min_facing_cosine) return std::nullopt;
    const Eigen::Vector3f point_camera = T_camera_world_ * point_world;
    if (point_camera.z() < MinDepthGrid::kNearestLookM) return std::nullopt;
    const std::optional<SamplePlace> place =
        frame_.samples.FindPlace(frame_.cloud.camera(), point_camera);
    if (!place) return std::nullopt;
    const auto margin_m =
        static_cast<float>(LookLimitM(parameters_, frame_.cloud, scale_, point_camera.z()));
    const SurfaceSample& sample = frame_.samples.At(place->column, place->row);
    if (sample.is_valid()) {
      const float off_plane_m = (point_world - sample.position_world).dot(sample.normal_world);
      if (std::abs(off_plane_m) <= margin_m &&
          static_cast<double>(sample.normal_world.dot(normal_world)) >=
              parameters_.min_normal_cosine &&
          (point_world - sample.position_world).norm() <
              margin_m + spacing_per_m_ * point_camera.z() / facing) {
        return HasItsClass(*place) ? LookResult::kPresent : LookResult::kAbsent;
      }
    }
    const float nearest_m = frame_.tiles.NearestAround(place->column, place->row);
    if (nearest_m > point_camera.z() + margin_m) return LookResult::kAbsent;
    return std::nullopt;
  }

 private:
  /// True if a sample around has the object's class; also true without labels.
  bool HasItsClass(const SamplePlace& place) const {
    if (!parameters_.labels_decide) return true;
    for (int v = std::max(place.row - 1, 0);
         v <= std::min(place.row + 1, frame_.samples.height() - 1);
         ++v) {
      for (int u = std::max(place.column - 1, 0);
           u <= std::min(place.column + 1, frame_.samples.width() - 1);
           ++u) {
        const SurfaceSample& sample = frame_.samples.At(u, v);
        if (sample.is_valid() && sample.label == label_) return true;
      }
    }
    return false;
  }

  const LookedAtFrame& frame_;
  const LookParameters& parameters_;
  const VoxelScale& scale_;
  float spacing_per_m_;  ///< Of samples, at a depth of one metre.
  std::uint16_t label_;
  Eigen::Isometry3f T_world_object_;
  Eigen::Isometry3f T_camera_world_;
  Eigen::Vector3f camera_world_;
};

/// Returns the evidence cells of a leaf that have surface, one bit each.
std::uint64_t CellsOf(const SurfaceLeaf& leaf) {
  std::uint64_t cells = 0;
  for (const SurfaceVoxel& point : leaf.points) cells |= std::uint64_t{1} << point.cell();
  return cells;
}

std::size_t CountCells(const TrackedObject& object) {
  std::size_t count = 0;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    count += static_cast<std::size_t>(std::popcount(CellsOf(leaf)));
  }
  return count;
}

/// True if looks show that a whole object is gone. `gone`: the number of gone cells that may decide
/// on the whole object.
bool IsWholeGone(const LookParameters& parameters,
                 const LookCount& looks,
                 std::size_t gone,
                 const TrackedObject& object) {
  return gone >= parameters.min_gone_cells &&
         static_cast<double>(looks.gone) >=
             parameters.whole_gone_share * static_cast<double>(looks.looked_at()) &&
         static_cast<double>(gone) >=
             parameters.negligible_share * static_cast<double>(CountCells(object));
}

/// The evidence cells of a leaf that a frame shows, one bit each.
struct ShownCells {
  LeafOrigin origin;
  std::uint64_t cells = 0;
};

/// Lowers the positive scores of the cells that a frame does not show by one: a thing moves as a
/// whole.
void DoubtOtherCells(const std::vector<ShownCells>& shown,
                     double min_interval_s,
                     Timestamp now,
                     ObjectEvidence* evidence) {
  for (LeafEvidence& leaf : evidence->leaves) {
    const auto found = std::find_if(shown.begin(), shown.end(), [&](const ShownCells& entry) {
      return entry.origin == leaf.origin;
    });
    if (found == shown.end() && (now - leaf.last_look).seconds() < min_interval_s) continue;
    leaf.last_look = now;
    const std::uint64_t cells = found == shown.end() ? 0 : found->cells;
    for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
      if ((cells >> cell & 1) == 0 && leaf.score[cell] > 0) --leaf.score[cell];
    }
  }
}

}  // namespace

double LookLimitM(const LookParameters& parameters,
                  const SemanticCloud& cloud,
                  const VoxelScale& scale,
                  float depth_m) {
  const double sigma_m =
      std::hypot(cloud.depth_noise().SigmaM(static_cast<double>(depth_m)), parameters.pose_sigma_m);
  return parameters.max_sigmas * sigma_m + 0.5 * scale.voxel_size_m;
}

bool AddLook(const LookedAtFrame& frame,
             const LookParameters& parameters,
             const VoxelScale& scale,
             Timestamp now,
             const TrackedObject& object,
             ObjectEvidence* evidence) {
  const ObjectLook look(frame, parameters, scale, object);
  // Poses of one session agree well enough to tell that a whole object is gone.
  const bool is_of_session = object.state().status == ObjectStatus::kTentative;
  bool has_looked = false;
  LookCount looks;
  std::size_t vanished = 0;  // Cells that earlier looks have found.
  std::vector<ShownCells> shown;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    const LeafEvidence* const known = evidence->FindLeaf(leaf.origin);
    if (known != nullptr && (now - known->last_look).seconds() < parameters.min_interval_s)
      continue;
    std::array<int, kEvidenceCells> balance{};
    bool is_leaf_looked_at = false;
    for (const SurfaceVoxel& point : leaf.points) {
      const std::optional<LookResult> result = look.At(point);
      if (!result) continue;
      balance[point.cell()] += *result == LookResult::kPresent ? 1 : -1;
      is_leaf_looked_at = true;
    }
    if (!is_leaf_looked_at) continue;
    has_looked = true;
    LeafEvidence& scores = evidence->MutableLeaf(leaf.origin);
    std::uint64_t shown_cells = 0;
    scores.last_look = now;
    for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
      if (balance[cell] == 0) continue;
      ++(balance[cell] > 0 ? looks.found : looks.gone);
      if (balance[cell] < 0 && scores.score[cell] > 0) ++vanished;
      shown_cells |= std::uint64_t{1} << cell;
      const int score = scores.score[cell] + (balance[cell] > 0 ? 1 : -1);
      scores.score[cell] = static_cast<std::int8_t>(
          std::clamp(score, -parameters.confirming_looks, parameters.confirming_looks));
    }
    shown.push_back({leaf.origin, shown_cells});
  }
  if (IsWholeGone(parameters, looks, is_of_session ? looks.gone : vanished, object)) {
    DoubtOtherCells(shown, parameters.min_interval_s, now, evidence);
  }
  return has_looked;
}

bool HasLeft(const LookParameters& parameters, double pause_s, const TrackedObject& object) {
  if (std::cmp_less(object.state().supporting_frames, parameters.confirming_looks)) return false;
  const Timestamp since = object.state().last_seen + Duration::FromSeconds(pause_s);
  const LookCount looks = CountLooks(object, since);
  return IsWholeGone(parameters, looks, looks.gone, object);
}

LookCount CountLooks(const TrackedObject& object, Timestamp since) {
  LookCount count;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    const LeafEvidence* evidence = object.state().evidence.FindLeaf(leaf.origin);
    const std::uint64_t cells = CellsOf(leaf);
    for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
      if ((cells >> cell & 1) == 0) continue;
      ++count.cells;
      if (evidence == nullptr || evidence->last_look <= since) continue;
      if (evidence->score[cell] > 0) ++count.found;
      if (evidence->score[cell] < 0) ++count.gone;
    }
  }
  return count;
}

}  // namespace steadymap
