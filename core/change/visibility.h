#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/association/association.h"
#include "core/association/sample_grid.h"
#include "core/change/change_estimate.h"
#include "core/change/min_depth_grid.h"
#include "core/change/no_return_labels.h"
#include "core/change/yaw_change.h"
#include "core/integration/semantic_cloud.h"
#include "core/working/tracked_object.h"

namespace steadymap {

/// What a frame is asked about lies at this depth at least, metres.
inline constexpr float kMinJudgedDepthM = 0.3F;

/// How far behind a surface at `depth_m` the measured depth must lie to have seen through it,
/// metres. Grows as the sensor's noise does: noise and pose error stay below it, shifts of a
/// decimetre do not.
inline float SeenThroughMargin(float depth_m) { return 0.05F + 0.007F * depth_m * depth_m; }

/// What a frame says about one evidence cell of an object.
enum class Verdict : std::uint8_t {
  kPresent,      ///< Surface was measured where it should be.
  kSeenThrough,  ///< Depth was measured behind it, or the label tells that one looks past it.
  kReplaced,     ///< Newer surface stands closer in front of it than anything fits between.
  kTurned,       ///< Surface was measured close by, but faces another way.
};

/// The verdict on one evidence cell.
struct CellVerdict {
  std::size_t leaf = 0;   ///< Place among the leaves of the object's surface.
  std::uint8_t cell = 0;  ///< In that leaf.
  Verdict verdict = Verdict::kPresent;
};

/// What a frame says about one object.
struct ObjectVerdict {
  std::vector<CellVerdict> cells;  ///< Judged cells only: what is occluded or out of view is not.
  std::size_t present = 0;
  std::size_t seen_through = 0;
  std::size_t replaced = 0;
  std::size_t turned = 0;
  /// How far the surface found present lies in front of where it should be, as `ChangeSum` has it,
  /// metres; none if nothing was found present.
  std::optional<double> change_m;

  std::size_t absent() const { return seen_through + replaced + turned; }

  std::size_t judged() const { return present + absent(); }
};

/// How objects are judged.
struct VisibilityParameters {
  /// Objects are judged up to this depth, metres.
  double max_depth_m = 5.0;
  /// Of the map, metres.
  double truncation_m = 0.15;
  /// What stands nearer than this, metres, and nearer than something that gives depth, would give
  /// depth, too, or at least its own label; where there is neither, it is gone. 0: no depth never
  /// says anything.
  double sure_depth_m = 3.0;
  /// False: the paper, where an object that nothing was matched with is gone if enough of its
  /// points lie in the frustum, occluded or not, ...
  bool is_by_depth = true;
  /// ... which is this share (theta_vis).
  double min_visible_share = 0.20;
  /// Surface this far behind a newer surface of its class is taken as replaced, metres, unless the
  /// newer thing was seen to end before it; 0: never.
  double replaced_within_m = 0.45;
  /// An object of which what was found present is turned stands otherwise than known.
  YawChangeParameters turn;
  /// How the change of the surface found present is measured.
  ChangeParameters change;
};

/// What the points of a surface that are found present say together.
struct PresentSums {
  explicit PresentSums(const ChangeParameters& parameters) : change(parameters) {}

  ChangeSum change;
  YawChangeSum turn;
};

/// One frame as what objects are judged against. All of them of that frame.
struct JudgedFrame {
  const SemanticCloud& cloud;
  const SampleGrid& samples;
  const MinDepthGrid& tiles;
  const NoReturnLabels& far_tiles;
};

/// Judges the surface of each object in view against a frame: by depth, not by frustum, unless
/// told otherwise (core/README.md#evidence).
class VisibilityTest {
 public:
  VisibilityTest(const JudgedFrame& frame,
                 const std::vector<ObjectInView>& objects,
                 const Association& association,
                 const VisibilityParameters& parameters);

  ObjectVerdict Judge(const TrackedObject& object) const;

 private:
  ObjectVerdict JudgeByFrustum(const TrackedObject& object) const;
  bool IsMatched(const TrackedObject& object) const;
  bool IsSeenThrough(const TrackedObject& object, SamplePlace place, float depth_m) const;
  std::optional<Verdict> JudgePoint(const TrackedObject& object,
                                    LeafOrigin leaf,
                                    const Eigen::Vector3f& point_world,
                                    const Eigen::Vector3f& normal_world,
                                    PresentSums* sums) const;
  const SurfaceSample* FindPresent(const TrackedObject& object,
                                   int column,
                                   int row,
                                   const Eigen::Vector3f& point_world,
                                   const Eigen::Vector3f& normal_world,
                                   float depth_m) const;
  float DepthAlong(const Eigen::Vector3f& point_world,
                   float depth_m,
                   const SurfaceSample& sample) const;
  bool IsReplaced(const TrackedObject& object,
                  LeafOrigin leaf,
                  std::size_t sample_index,
                  const Eigen::Vector3f& point_world,
                  const Eigen::Vector3f& normal_world) const;

  JudgedFrame frame_;
  const std::vector<ObjectInView>& objects_;
  const Association& association_;
  VisibilityParameters parameters_;
  Eigen::Isometry3f T_camera_world_;
  Eigen::Vector3f camera_world_;
};

}  // namespace steadymap
