#include "core/vdb_file.h"

#include <algorithm>
#include <mutex>
#include <sstream>

#include <openvdb/io/Stream.h>

#include "core/error.h"
#include "core/tsdf_trees.h"

namespace steadymap {
namespace {

// Where an OpenVDB file keeps the UUID that it draws at random: behind the magic number (8 bytes),
// the format and two library versions (4 each) and the offsets flag (1).
constexpr std::size_t kUuidPosition = 8 + 3 * 4 + 1;
constexpr std::size_t kUuidLength = 36;

void InitializeOpenVdb() {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
}

/// The grids of one volume, as stock types in world metres.
struct VolumeGrids {
  openvdb::FloatGrid::Ptr distance;
  openvdb::FloatGrid::Ptr weight;
  openvdb::Vec3fGrid::Ptr color = openvdb::Vec3fGrid::create(openvdb::Vec3f(0.0F));
  bool has_color = false;

  explicit VolumeGrids(const VoxelScale& scale)
      : distance(openvdb::FloatGrid::create(static_cast<float>(scale.truncation_m))),
        weight(openvdb::FloatGrid::create(0.0F)) {}
};

openvdb::Vec3f ToVec3f(std::uint32_t color) {
  const auto channel = [color](int shift) {
    return static_cast<float>((color >> shift) & 0xFFU) / 255.0F;
  };
  return {channel(0), channel(8), channel(16)};
}

/// What of a volume goes into its grids.
struct VolumeSelection {
  PlacedVolume volume;
  VoxelScale scale;
  const Box* box_world = nullptr;

  bool Holds(const openvdb::Coord& voxel) const {
    if (box_world == nullptr) return true;
    const Eigen::Vector3d center = Eigen::Vector3d(voxel.x(), voxel.y(), voxel.z());
    return box_world->contains(
        Eigen::Vector3d(volume.T_world_volume * (center * scale.voxel_size_m)));
  }
};

void AddLeaf(LeafOrigin origin,
             const LeafView& leaf,
             const VolumeSelection& selection,
             VolumeGrids* grids) {
  openvdb::FloatGrid::TreeType::LeafNodeType* distance = nullptr;
  openvdb::FloatGrid::TreeType::LeafNodeType* weight = nullptr;
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    if (!IsSet(leaf.observed, offset)) continue;
    const openvdb::Coord voxel = ToCoord(origin).offsetBy(static_cast<int>(offset >> 6),
                                                          static_cast<int>((offset >> 3) & 7),
                                                          static_cast<int>(offset & 7));
    if (!selection.Holds(voxel)) continue;
    if (distance == nullptr) {
      distance = grids->distance->tree().touchLeaf(voxel);
      weight = grids->weight->tree().touchLeaf(voxel);
    }
    const auto index = static_cast<openvdb::Index>(offset);
    distance->setValueOn(index, leaf.distance_m[offset]);
    weight->setValueOn(index, leaf.weight[offset]);
    if (leaf.color == nullptr || (leaf.color[offset] >> 24) == 0) continue;
    grids->has_color = true;
    grids->color->tree().setValueOn(voxel, ToVec3f(leaf.color[offset]));
  }
}

/// From voxel indices to the world. OpenVDB multiplies row vectors from the left.
openvdb::math::Transform::Ptr MakeTransform(const Eigen::Isometry3d& T_world_volume,
                                            double voxel_size_m) {
  openvdb::math::Mat4d matrix = openvdb::math::Mat4d::identity();
  for (int from = 0; from < 3; ++from) {
    for (int to = 0; to < 3; ++to) {
      matrix(from, to) = voxel_size_m * T_world_volume.linear()(to, from);
    }
    matrix(3, from) = T_world_volume.translation()[from];
  }
  return openvdb::math::Transform::createLinearTransform(matrix);
}

const char* StandingText(ObjectStanding standing) {
  switch (standing) {
    case ObjectStanding::kTentative:
      return "tentative";
    case ObjectStanding::kPresent:
      return "present";
    case ObjectStanding::kArchived:
      return "archived";
  }
  return "unknown";
}

openvdb::Int64Metadata Count(std::uint64_t value) {
  return openvdb::Int64Metadata(static_cast<std::int64_t>(value));
}

void DescribeObject(const MapObject& object, openvdb::GridBase* grid) {
  grid->insertMeta("standing", openvdb::StringMetadata(StandingText(object.standing)));
  const Belief& belief = object.belief;
  grid->insertMeta("stationarity", openvdb::DoubleMetadata(belief.stationarity()));
  grid->insertMeta("alpha", openvdb::DoubleMetadata(belief.alpha));
  grid->insertMeta("beta", openvdb::DoubleMetadata(belief.beta));
  grid->insertMeta("change_mean_m", openvdb::DoubleMetadata(belief.change_mean_m));
  grid->insertMeta("change_std_m", openvdb::DoubleMetadata(belief.change_std_m));
  grid->insertMeta("first_seen_s", openvdb::DoubleMetadata(object.first_seen.seconds()));
  grid->insertMeta("last_seen_s", openvdb::DoubleMetadata(object.last_seen.seconds()));
  grid->insertMeta("views", Count(object.views));
  grid->insertMeta("absences", Count(object.absences));
}

void Describe(const MapSnapshot& snapshot,
              const PlacedVolume& volume,
              const char* kind,
              openvdb::GridBase* grid) {
  const std::string name = volume.object == nullptr
                               ? std::string("background")
                               : "object-" + std::to_string(volume.id().value());
  const double voxel_size_m = snapshot.scale.voxel_size_m;
  grid->setName(name + "/" + kind);
  grid->setTransform(volume.object == nullptr
                         ? openvdb::math::Transform::createLinearTransform(voxel_size_m)
                         : MakeTransform(volume.T_world_volume, voxel_size_m));
  grid->insertMeta("object_id", Count(volume.id().value()));
  grid->insertMeta("class_id", openvdb::Int32Metadata(volume.class_id().value()));
  grid->insertMeta("revision", Count(snapshot.revision.value()));
  grid->insertMeta("voxel_size_m", openvdb::DoubleMetadata(voxel_size_m));
  grid->insertMeta("truncation_m", openvdb::DoubleMetadata(snapshot.scale.truncation_m));
  if (volume.object != nullptr) DescribeObject(*volume.object, grid);
}

void AddGrids(const MapSnapshot& snapshot,
              const VolumeSelection& selection,
              openvdb::GridPtrVec* grids) {
  VolumeGrids volume(snapshot.scale);
  selection.volume.voxels->ForEachLeaf(
      [&](LeafOrigin origin, const LeafView& leaf) { AddLeaf(origin, leaf, selection, &volume); });
  volume.distance->setGridClass(openvdb::GRID_LEVEL_SET);
  Describe(snapshot, selection.volume, "distance", volume.distance.get());
  Describe(snapshot, selection.volume, "weight", volume.weight.get());
  grids->insert(grids->end(), {volume.distance, volume.weight});
  if (!volume.has_color) return;
  Describe(snapshot, selection.volume, "color", volume.color.get());
  grids->push_back(volume.color);
}

std::string Serialize(const openvdb::GridPtrVec& grids) {
  std::ostringstream bytes(std::ios::binary);
  openvdb::io::Stream stream(bytes);
  stream.setCompression(openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
  stream.write(grids);
  std::string file = std::move(bytes).str();
  // Equal maps must give equal files.
  std::fill_n(file.begin() + kUuidPosition, kUuidLength, '0');
  for (const std::size_t dash : {8U, 13U, 18U, 23U}) file[kUuidPosition + dash] = '-';
  return file;
}

}  // namespace

absl::StatusOr<std::string> WriteVdb(const MapSnapshot& snapshot,
                                     std::span<const PlacedVolume> volumes,
                                     const Box* box_world) {
  try {
    InitializeOpenVdb();
    openvdb::GridPtrVec grids;
    for (const PlacedVolume& volume : volumes) {
      AddGrids(snapshot, {volume, snapshot.scale, box_world}, &grids);
    }
    return Serialize(grids);
  } catch (const std::exception& error) {
    return MakeError(absl::StatusCode::kInternal,
                     reason::kInternal,
                     std::string("OpenVDB could not write the map: ") + error.what());
  }
}

absl::StatusOr<std::string> WriteVdb(const MapSnapshot& snapshot, const Box* box_world) {
  return WriteVdb(snapshot, ShownVolumes(snapshot), box_world);
}

}  // namespace steadymap
