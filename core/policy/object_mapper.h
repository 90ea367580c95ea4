#pragma once

#include <optional>
#include <vector>

#include "core/association/association.h"
#include "core/association/frame_clusters.h"
#include "core/association/observation.h"
#include "core/association/sample_grid.h"
#include "core/change/belief_update.h"
#include "core/change/visibility.h"
#include "core/frame/frame.h"
#include "core/integration/semantic_cloud.h"
#include "core/integration/tsdf_integrator.h"
#include "core/objects/object_lifecycle.h"
#include "core/objects/object_merge.h"
#include "core/objects/relocation.h"
#include "core/policy/map_updater.h"
#include "core/policy/stage_observer.h"
#include "core/robot/dynamic_mask.h"
#include "core/robot/localization_monitor.h"
#include "core/types/map_config.h"
#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

namespace steadymap {

/// How objects come, are judged and go. Defaults: TorWIC (Qian et al., RSS 2022), and what was
/// measured on simulated routes.
struct ObjectMapperParameters {
  LocalizationMonitorParameters guard;
  DynamicMaskParameters moving;
  ClusterParameters clusters;
  BeliefUpdateParameters judgement;
  VisibilityParameters visibility;
  MergeParameters merging;
  ObjectLifecycleParameters confirmation;
  RelocationParameters moves;
  /// Objects below this E[v] leave the map (theta_stat).
  double min_stationarity = 0.40;
  /// Smallest surface that a frame must show of a new object, square metres. Thin things show
  /// little at a time.
  double min_seen_area_m2 = 0.02;
  /// Surface with a label of the background that borders on things alone is of a thing, unless it
  /// is larger than this, square metres: a wall whose dependencies were not mapped yet.
  double max_mislabelled_area_m2 = 0.5;
  ContradictionParameters contradiction;
  /// A part of an object is cut off when its cells were found gone in so many more frames than not.
  int gone_score = 5;
  /// With it go cells beside them that were in so many more: they may not come into view again.
  int beside_gone_score = 3;
  /// Fewest cells that are cut off, ...
  std::size_t min_gone_cells = 8;
  /// ... but that any are which were found gone in so many more frames than not: edges of what
  /// stood close by.
  int sliver_gone_score = 20;
  /// Fewest connected cells that are taken for a thing that went; fewer were none, and are
  /// forgotten.
  std::size_t min_part_cells = 25;
  /// Whether that is done at all.
  bool cuts_gone_parts = true;
  /// Whether removed objects are kept as history; else they are forgotten.
  bool keeps_removed = true;
  /// Whether new objects are compared with what left another place.
  bool finds_moves = true;
  /// Whether what was looked through is remembered.
  bool remembers_free_space = true;
};

/// Keeps the objects of a map true: the `pocd` policy.
class ObjectMapper final : public MapUpdater {
 public:
  /// `stages` outlives this; null: nobody watches.
  ObjectMapper(const MapConfig& config,
               const ObjectMapperParameters& parameters,
               StageObserver* stages = nullptr);

  /// Gives each of the cloud's cells to its owner, and fuses objects and background; nothing of a
  /// frame whose robot is not where it says.
  void Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) override;

 private:
  void FindOwners();
  void JudgeObjects();
  void DecideOn(const ObjectVerdict& verdict, TrackedObject* object);
  std::optional<int> FindGoneScore(const TrackedObject& object) const;
  void RemoveGoneParts(TrackedObject* object);
  void PlaceObservations();
  bool IsInFreeSpace(const Observation& observation) const;
  bool IsMislabelled(const Observation& observation) const;
  std::uint32_t ChooseOwner(const Observation& observation);
  std::uint32_t AddObject(const Observation& observation);
  bool IsRecent(const ObjectState& state) const;
  void CountViews();
  void Integrate();
  void Archive(TrackedObject* object, EventReason reason, const Belief& before);
  void BecomeHistory(TrackedObject* object);

  MapConfig config_;
  ObjectMapperParameters parameters_;
  StageTimer stages_;
  LocalizationMonitor guard_;
  DynamicMask moving_;
  FrameClusters clusters_;
  ObjectLifecycle confirmation_;
  TsdfIntegrator integrator_;

  // The frame at hand.
  WorkingMap* map_ = nullptr;
  SemanticCloud* cloud_ = nullptr;
  SampleGrid samples_;
  MinDepthGrid tiles_;
  NoReturnLabels far_tiles_;
  Association association_;
  std::vector<ObjectInView> in_view_;
  std::vector<Observation> observations_;
  std::vector<std::size_t> fitting_samples_;  ///< By place in view.
};

}  // namespace steadymap
