#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "core/association/association.h"
#include "core/association/frame_segments.h"
#include "core/association/gaps.h"
#include "core/association/sample_grid.h"
#include "core/integration/semantic_cloud.h"
#include "core/objects/session_identity.h"
#include "core/types/map_config.h"
#include "core/working/working_map.h"

namespace steadymap {

/// A sample on the surface of an object in view.
struct SampleOnObject {
  std::size_t sample = 0;
  std::size_t place = 0;  ///< Of the object in the list of objects in view.
  /// True between observed voxels; false for at most a voxel beyond the observed surface.
  bool is_observed = false;
};

/// One frame, for the assignment of its segments.
struct SegmentedFrame {
  const SensorName& source;
  const SemanticCloud& cloud;
  const SampleGrid& samples;
  const std::vector<FrameSegment>& segments;
  const std::vector<SampleOnObject>& on_objects;  ///< Of the session, and structures.
  const std::vector<SampleUse>& uses;             ///< By sample.
};

/// The constants of `SegmentAssignment`.
struct SegmentAssignmentParameters {
  /// Segments with less surface do not start an object, square metres.
  double min_new_area_m2 = 0.004;
  /// A narrower segment does not start an object: its shape cannot be told from noise.
  double min_width_samples = 2.5;
  /// Gaps between two objects that could be parts of one.
  GapParameters gaps;

  friend bool operator==(const SegmentAssignmentParameters&,
                         const SegmentAssignmentParameters&) = default;
};

/// Gives the segments of one frame to objects of the session: each to one object, and one segment
/// to an object. If two segments show an object apart, it is divided; votes of all frames decide at
/// the end of the session whether the parts are one object (`core/objects/part_votes.h`). Surface
/// of no segment waits for the end of the session (`core/objects/unsegmented_surface.h`).
class SegmentAssignment {
 public:
  /// New objects are appended to `in_view`. All arguments must outlive the assignment.
  SegmentAssignment(const MapConfig& config,
                    const SegmentAssignmentParameters& parameters,
                    const SessionIdentityParameters& identity,
                    const SegmentedFrame& frame,
                    std::vector<ObjectInView>* in_view,
                    WorkingMap* map)
      : config_(config),
        parameters_(parameters),
        identity_(identity),
        frame_(frame),
        in_view_(in_view),
        map_(map) {}

  /// Assigns the segments of a frame with labels or instances.
  void AssignSegments();

  /// Assigns the only segment, if there is one, of a frame without labels: the scene, which
  /// `DivideScene` divides at the end of the session. Samples on structures belong to these, all
  /// others to the background.
  void AssignScene();

  /// Returns the owner of each sample: of an object, its place in `in_view` plus one.
  const Association& association() const { return association_; }

  /// Returns the segment of each sample plus one; 0: none, or of the background.
  const std::vector<std::size_t>& segment_of() const { return segment_of_; }

 private:
  /// The surface that a segment and an object in view have in common.
  struct Claim {
    std::size_t segment = 0;
    std::size_t place = 0;  ///< In `in_view_`.
    double area_m2 = 0.0;
    double share = 0.0;  ///< Of the smaller one of both.
  };

  /// Rows and columns of the image on which two objects are beside each other.
  struct BorderCount {
    std::size_t apart = 0;     ///< With a gap in between, or between two instances.
    std::size_t occluded = 0;  ///< With nothing seen in between.
  };

  /// Of pairs of objects, by place in `in_view_`, the lower one first.
  using BorderCounts = std::map<std::pair<std::size_t, std::size_t>, BorderCount>;

  /// A row or column of the grid of samples.
  struct SampleLine {
    std::size_t first = 0;
    std::size_t step = 1;
    std::size_t count = 0;
  };

  void SeparateBackground();
  std::vector<Claim> FindClaims(std::span<const char> is_excluded) const;
  std::vector<char> FindSamplesOnOwner() const;
  bool IsOfObject(const Claim& claim) const;
  void ChooseObjects();
  void SeparateContested(std::size_t index);
  std::vector<std::pair<std::size_t, std::size_t>> FindSeeds(std::size_t index) const;
  void AddSegmentAsObject(std::size_t index);
  void AddInView(TrackedObject* object, std::size_t segment);
  void ExcludeContactsOfInstances();
  void Vote();
  BorderCounts CountBorders() const;
  void CountBordersOn(const SampleLine& line, BorderCounts* borders) const;
  bool IsBorder(const SurfaceSample& a, const SurfaceSample& b, float nearest_between_m) const;
  void SetOwners();
  bool IsOfOtherInstance(const SampleOnObject& found) const;
  void GiveToConnected(const SampleOnObject& found);
  void SetAside();
  std::size_t PlaceOfUnsegmented(ClassId class_id, const SurfaceSample& sample);

  const MapConfig& config_;
  const SegmentAssignmentParameters& parameters_;
  const SessionIdentityParameters& identity_;
  SegmentedFrame frame_;
  std::vector<ObjectInView>* in_view_;
  WorkingMap* map_;

  Association association_;
  std::vector<std::size_t> segment_of_;  ///< By sample, plus one; 0: none.
  std::vector<Claim> claims_;            ///< The largest first.
  std::vector<std::size_t> owner_of_;    ///< By segment, the place in `in_view_` plus one; 0: none.
  /// By segment without owner: the place plus one of an object that another segment owns.
  std::vector<std::size_t> contested_;
  std::map<ClassId, std::size_t> unsegmented_;  ///< Places in `in_view_`.
  std::vector<std::size_t> segment_on_;  ///< By place in `in_view_`: its segment plus one; 0: none.
};

}  // namespace steadymap
