#include "core/association/segmentation.h"

#include <optional>

#include "core/association/ground.h"

namespace steadymap {

std::vector<Observation> FindSegments(const SampleGrid& samples,
                                      const MapConfig& config,
                                      const Eigen::Vector3d& camera_world,
                                      Association* association) {
  association->owner.assign(samples.size(), Association::kNone);
  std::vector<std::uint8_t> is_in_background(config.label_limit(), 0);
  for (std::size_t label = 0; label < is_in_background.size(); ++label) {
    const ClassId id(static_cast<std::uint16_t>(label));
    is_in_background[label] = config.IsInBackground(id) ? 1 : 0;
  }
  for (std::size_t index = 0; index < samples.size(); ++index) {
    const SurfaceSample& sample = samples[index];
    if (sample.is_valid() && sample.instance == 0 && is_in_background[sample.label] != 0) {
      association->owner[index] = kBackgroundOwner;
    }
  }
  if (const std::optional<double> ground = FindGroundHeight(samples, camera_world.z())) {
    AssignGround(samples, *ground, association);
  }
  return FindObservations(samples, *association);
}

}  // namespace steadymap
