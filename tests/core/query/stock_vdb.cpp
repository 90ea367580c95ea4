#include "tests/core/query/stock_vdb.h"

#include <sstream>

#include <openvdb/io/Stream.h>

namespace steadymap::testing {
namespace {

using openvdb::Coord;

std::string StandingName(ObjectStatus standing) {
  if (standing == ObjectStatus::kTentative) return "tentative";
  return standing == ObjectStatus::kPresent ? "present" : "archived";
}

void Describe(const MapSnapshot& map,
              const PlacedVolume& volume,
              const std::string& kind,
              openvdb::GridBase* grid) {
  const auto real = [grid](const char* name, double value) {
    grid->insertMeta(name, openvdb::DoubleMetadata(value));
  };
  const auto count = [grid](const char* name, std::uint64_t value) {
    grid->insertMeta(name, openvdb::Int64Metadata(static_cast<std::int64_t>(value)));
  };
  const MapObject* const object = volume.object;
  grid->setName(
      (object == nullptr ? "background" : "object-" + std::to_string(object->id.value())) + "/" +
      kind);
  count("object_id", object == nullptr ? 0 : object->id.value());
  grid->insertMeta("class_id",
                   openvdb::Int32Metadata(object == nullptr ? 0 : object->class_id.value()));
  count("revision", map.revision.value());
  real("voxel_size_m", map.scale.voxel_size_m);
  real("truncation_m", map.scale.truncation_m);
  openvdb::math::Mat4d matrix = openvdb::math::Mat4d::identity();
  const Eigen::Matrix4d T_world_volume = volume.T_world_volume.matrix();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      matrix(column, row) =
          (column < 3 ? map.scale.voxel_size_m : 1.0) * T_world_volume(row, column);
    }
  }
  grid->setTransform(object == nullptr
                         ? openvdb::math::Transform::createLinearTransform(map.scale.voxel_size_m)
                         : openvdb::math::Transform::createLinearTransform(matrix));
  if (object == nullptr) return;
  grid->insertMeta("standing", openvdb::StringMetadata(StandingName(object->status)));
  real("stationarity", object->belief.stationarity());
  real("alpha", object->belief.alpha);
  real("beta", object->belief.beta);
  real("change_mean_m", object->belief.change_mean_m);
  real("change_std_m", object->belief.change_std_m);
  real("first_seen_s", object->first_seen.seconds());
  real("last_seen_s", object->last_seen.seconds());
  count("views", object->supporting_frames);
  count("absences", object->contradicted_updates);
}

openvdb::Vec3f RgbOf(std::uint32_t color) {
  return {static_cast<float>(color & 0xFFU) / 255.0F,
          static_cast<float>((color >> 8) & 0xFFU) / 255.0F,
          static_cast<float>((color >> 16) & 0xFFU) / 255.0F};
}

void AddVolume(const MapSnapshot& map,
               const PlacedVolume& volume,
               const Box* box_world,
               openvdb::GridPtrVec* grids) {
  const auto distance = openvdb::FloatGrid::create(static_cast<float>(map.scale.truncation_m));
  const auto weight = openvdb::FloatGrid::create(0.0F);
  const auto color = openvdb::Vec3fGrid::create(openvdb::Vec3f(0.0F));
  volume.voxels->ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    for (int i = 0; i < 512; ++i) {
      const auto offset = static_cast<std::size_t>(i);
      if (!IsSet(leaf.observed, offset)) continue;
      const Coord voxel(origin.x + i / 64, origin.y + i / 8 % 8, origin.z + i % 8);
      const Eigen::Vector3d center = Eigen::Vector3d(voxel.x(), voxel.y(), voxel.z());
      const Eigen::Vector3d world = volume.T_world_volume * (center * map.scale.voxel_size_m);
      if (box_world != nullptr && !box_world->contains(world)) continue;
      distance->tree().setValueOn(voxel, map.scale.distance_m(leaf.voxels[i]));
      weight->tree().setValueOn(voxel, leaf.voxels[i].weight());
      if (leaf.color != nullptr && (leaf.color[i] >> 24) != 0) {
        color->tree().setValueOn(voxel, RgbOf(leaf.color[i]));
      }
    }
  });
  distance->setGridClass(openvdb::GRID_LEVEL_SET);
  Describe(map, volume, "distance", distance.get());
  Describe(map, volume, "weight", weight.get());
  grids->insert(grids->end(), {distance, weight});
  if (color->activeVoxelCount() == 0) return;
  Describe(map, volume, "color", color.get());
  grids->push_back(color);
}

}  // namespace

std::string WriteStockVdb(const MapSnapshot& snapshot,
                          const std::vector<PlacedVolume>& volumes,
                          const Box* box_world) {
  openvdb::initialize();
  openvdb::GridPtrVec grids;
  for (const PlacedVolume& volume : volumes) AddVolume(snapshot, volume, box_world, &grids);
  return WriteStockVdb(grids);
}

std::string WriteStockVdb(const openvdb::GridPtrVec& grids) {
  std::ostringstream bytes(std::ios::binary);
  openvdb::io::Stream stream(bytes);
  stream.setCompression(openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
  stream.write(grids);
  constexpr std::size_t kUuidPosition = 21;
  const std::string uuid = "00000000-0000-0000-0000-000000000000";
  return bytes.str().replace(kUuidPosition, uuid.size(), uuid);
}

}  // namespace steadymap::testing
