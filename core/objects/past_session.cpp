#include "core/objects/past_session.h"

#include <algorithm>

#include "core/objects/session_parts.h"
#include "core/objects/surface_relations.h"

namespace steadymap {

bool IsOfPast(const SessionObjects& objects, Timestamp end, double max_pause_s) {
  return std::any_of(objects.known.begin(), objects.known.end(), [&](const KnownObject& known) {
    return (known.object->state().last_seen - end).seconds() > max_pause_s;
  });
}

void FindRemovedSince(const WorkingMap& map, SessionObjects* objects) {
  const FreeSpaceSince free_space(map.free_space(), map.now());
  for (SeenObject& seen : objects->seen) {
    seen.removed_share = FreeShareOf(*seen.object, free_space);
  }
}

void CutRemovedSince(const SeenObject& seen, WorkingMap* map) {
  if (!(seen.removed_share > 0.0)) return;
  {
    ObjectEdit edit = map->Edit(seen.object);
    DoubtFreeCells(
        *seen.object, FreeSpaceSince(map->free_space(), map->now()), &edit.state().evidence);
  }
  CutGoneCells(seen.object, map);
}

}  // namespace steadymap
