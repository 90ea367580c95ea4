#pragma once

#include <array>
#include <cstddef>
#include <string_view>

/// Reports the current stage of a mapper to an observer with a clock, for timing. Core has no
/// clock.
namespace steadymap {

/// The stages of a frame, in order of execution.
enum class MapperStage {
  kCloud,         ///< Computation of the semantic cloud.
  kGuard,         ///< Dynamic mask, samples, localization monitor.
  kRegistration,  ///< Registration of the frame to the map.
  kAssociation,   ///< Objects in view.
  kLooks,         ///< Looks at the surface of the objects in view.
  kSegments,      ///< Segments of the image and their objects.
  kIntegration,   ///< Fusion into background and objects.
  kFreeSpace,     ///< Free-space carving.
  kPolicy,        ///< All stages between cloud and frame end, for policies that do not report them.
  kFrameEnd,      ///< Deletion of forgotten objects.
  kSessionEnd,    ///< Decisions at the end of a session.
  kCommit,        ///< Packing of the changes since the last commit.
};

/// Names of the stages in tables.
inline constexpr std::array<std::string_view, 12> kMapperStageNames = {"cloud",
                                                                       "guard",
                                                                       "registration",
                                                                       "association",
                                                                       "looks",
                                                                       "segments",
                                                                       "integration",
                                                                       "free space",
                                                                       "policy",
                                                                       "frame end",
                                                                       "session end",
                                                                       "commit"};

inline constexpr std::size_t kMapperStageCount = kMapperStageNames.size();

/// An observer of the stages of a mapper, called on the mapper's thread. Must not change the
/// mapper.
class StageObserver {
 public:
  virtual ~StageObserver() = default;

  /// Reports the start of a stage, and with it the end of the previous stage.
  virtual void Enter(MapperStage stage) = 0;

  /// Reports the end of the last stage. Subsequent time is outside of the mapper.
  virtual void Leave() = 0;
};

/// Forwards stages to an observer, if there is one.
class StageTimer {
 public:
  /// `observer` outlives this object; null: no observer.
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
