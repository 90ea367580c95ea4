#pragma once

#include <array>
#include <cstddef>
#include <string_view>

/// Lets somebody with a clock see what a mapper spends its time on; core has none.
namespace steadymap {

/// The stages of a frame, in the order of the flow.
enum class MapperStage {
  kCloud,         ///< The semantic cloud.
  kGuard,         ///< The samples, and whether the robot is where it says.
  kAssociation,   ///< Objects in view, and what belongs to them.
  kGround,        ///< The ground and its labels.
  kVisibility,    ///< What stands, what is gone, and how far what stands has changed.
  kBelief,        ///< Evidence, the state update, and the removal of what is gone.
  kObservations,  ///< Clusters of what is unknown, and whom they are of.
  kIntegration,   ///< Fusing.
  kObjects,       ///< Merging, confirming, recognising, moves.
  kFreeSpace,     ///< What was looked through.
  kPolicy,        ///< All from guard to free space of the policies that do not tell them apart.
  kFrameEnd,      ///< Forgetting.
  kCommit,        ///< Packing what changed since the last commit.
};

/// Names of the stages, as tables show them.
inline constexpr std::array<std::string_view, 13> kMapperStageNames = {"cloud",
                                                                       "guard",
                                                                       "association",
                                                                       "ground",
                                                                       "visibility",
                                                                       "belief",
                                                                       "observations",
                                                                       "integration",
                                                                       "objects",
                                                                       "free space",
                                                                       "policy",
                                                                       "frame end",
                                                                       "commit"};

inline constexpr std::size_t kMapperStageCount = kMapperStageNames.size();

/// Hears when a mapper goes from stage to stage, on the mapper's thread. Must change nothing.
class StageObserver {
 public:
  virtual ~StageObserver() = default;

  /// A stage begins, and with it the one before ends.
  virtual void Enter(MapperStage stage) = 0;

  /// The last stage ends; what follows is not the mapper's.
  virtual void Leave() = 0;
};

/// Tells an observer, if there is one.
class StageTimer {
 public:
  /// `observer` outlives this; null: nobody listens.
  explicit StageTimer(StageObserver* observer) : observer_(observer) {}

  void Enter(MapperStage stage) const {
    if (observer_ != nullptr) observer_->Enter(stage);
  }

  void Leave() const {
    if (observer_ != nullptr) observer_->Leave();
  }

 private:
  StageObserver* observer_;
};

}  // namespace steadymap
