#include "core/query/vdb_metadata.h"

#include <string>

namespace steadymap {
namespace {

/// Returns the transform from voxel indices to the world frame. OpenVDB multiplies row vectors from
/// the left.
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

const char* StatusText(ObjectStatus standing) {
  switch (standing) {
    case ObjectStatus::kTentative:
      return "tentative";
    case ObjectStatus::kPresent:
      return "present";
    case ObjectStatus::kArchived:
      return "archived";
  }
  return "unknown";
}

openvdb::Int64Metadata Count(std::uint64_t value) {
  return openvdb::Int64Metadata(static_cast<std::int64_t>(value));
}

void DescribeObject(const MapObject& object, openvdb::GridBase* grid) {
  grid->insertMeta("standing", openvdb::StringMetadata(StatusText(object.status)));
  const Belief& belief = object.belief;
  grid->insertMeta("stationarity", openvdb::DoubleMetadata(belief.stationarity()));
  grid->insertMeta("alpha", openvdb::DoubleMetadata(belief.alpha));
  grid->insertMeta("beta", openvdb::DoubleMetadata(belief.beta));
  grid->insertMeta("change_mean_m", openvdb::DoubleMetadata(belief.change_mean_m));
  grid->insertMeta("change_std_m", openvdb::DoubleMetadata(belief.change_std_m));
  grid->insertMeta("first_seen_s", openvdb::DoubleMetadata(object.first_seen.seconds()));
  grid->insertMeta("last_seen_s", openvdb::DoubleMetadata(object.last_seen.seconds()));
  grid->insertMeta("views", Count(object.supporting_frames));
  grid->insertMeta("absences", Count(object.contradicted_updates));
}

}  // namespace

void DescribeGrid(const MapSnapshot& snapshot,
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

}  // namespace steadymap
