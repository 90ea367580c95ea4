#include "core/association/new_object.h"

namespace steadymap {

TrackedObject& AddObjectOf(const Observation& observation,
                           const SampleGrid& samples,
                           WorkingMap* map) {
  Eigen::Vector3d mean_world = Eigen::Vector3d::Zero();
  for (const std::size_t index : observation.samples) {
    mean_world += samples[index].position_world.cast<double>();
  }
  mean_world /= static_cast<double>(observation.samples.size());
  TrackedObject& object = map->AddObject(mean_world);
  ObjectEdit edit = map->Edit(&object);
  edit.state().class_id = ClassId(observation.label);
  return object;
}

}  // namespace steadymap
