#pragma once

#include <memory>
#include <vector>

#include "core/background.h"
#include "core/frame.h"
#include "core/map_config.h"
#include "core/voxel_leaf.h"

namespace steadymap {

/// Fuses frames into a volume: the block-projective update of platform.md. Keeps its scratch memory
/// from frame to frame. One thread at a time.
class TsdfIntegrator {
 public:
  explicit TsdfIntegrator(const MapConfig& config);
  ~TsdfIntegrator();
  TsdfIntegrator(TsdfIntegrator&&) noexcept;
  TsdfIntegrator& operator=(TsdfIntegrator&&) noexcept;

  /// Fuses `frame` into `background` and appends the leaves that changed to `changed_leaves`, each
  /// once, sorted.
  void Integrate(const Frame& frame,
                 Background* background,
                 std::vector<LeafOrigin>* changed_leaves);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace steadymap
