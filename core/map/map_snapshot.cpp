#include "core/map/map_snapshot.h"

namespace steadymap {

LeafView FindLeaf(const MapSnapshot& map, const LeafKey& key) {
  if (key.object == kBackgroundId) return map.background.FindLeaf(key.origin);
  const auto object = map.objects.find(key.object);
  return object == map.objects.end() ? LeafView{} : object->second->volume->FindLeaf(key.origin);
}

}  // namespace steadymap
