#include "server/store/store_catalog.h"

#include "server/store/database/corrupt_record.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {

std::string StoreCatalog::Pack() const {
  storage::v1::Catalog proto;
  proto.set_next_key(next_key.value());
  for (const Map& map : maps) {
    storage::v1::Catalog::Map& added = *proto.add_maps();
    added.set_key(map.key.value());
    added.set_tenant(map.name.tenant);
    added.set_map(map.name.map);
  }
  return proto.SerializeAsString();
}

absl::StatusOr<StoreCatalog> StoreCatalog::Unpack(std::string_view bytes) {
  storage::v1::Catalog proto;
  if (!proto.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return CorruptRecord("the catalog of maps cannot be read");
  }
  StoreCatalog catalog;
  catalog.next_key = MapKey(proto.next_key());
  for (const storage::v1::Catalog::Map& map : proto.maps()) {
    catalog.maps.push_back({MapKey(map.key()), {map.tenant(), map.map()}});
  }
  return catalog;
}

}  // namespace steadymap
