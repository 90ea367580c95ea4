#include "core/query/vdb_file.h"

#include <array>
#include <exception>
#include <functional>
#include <mutex>
#include <sstream>
#include <utility>

#include <openvdb/io/Stream.h>

#include "core/query/vdb_grid.h"
#include "core/query/vdb_leaves.h"
#include "core/query/vdb_metadata.h"
#include "core/types/error.h"

namespace steadymap {
namespace {

// Position of the random UUID in an OpenVDB file: after the magic number (8 bytes), the format and
// two library versions (4 each) and the offsets flag (1).
constexpr std::size_t kUuidPosition = 8 + 3 * 4 + 1;
constexpr std::size_t kUuidLength = 36;

void InitializeOpenVdb() {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
}

/// Returns the header of the file: all bytes before the first grid.
std::string FileHead(std::size_t grid_count) {
  std::ostringstream bytes(std::ios::binary);
  openvdb::io::Stream(bytes).write(openvdb::GridCPtrVec());
  std::string head = std::move(bytes).str();
  // Equal maps must give equal files, so the random UUID is overwritten.
  std::fill_n(head.begin() + kUuidPosition, kUuidLength, '0');
  for (const std::size_t dash : {8U, 13U, 18U, 23U}) head[kUuidPosition + dash] = '-';
  // The header ends with the number of grids.
  const auto count = static_cast<std::int32_t>(grid_count);
  head.replace(head.size() - sizeof(count),
               sizeof(count),
               reinterpret_cast<const char*>(&count),
               sizeof(count));
  return head;
}

openvdb::Vec3f ToVec3f(std::uint32_t color) {
  const auto channel = [color](int shift) {
    return static_cast<float>((color >> shift) & 0xFFU) / 255.0F;
  };
  return {channel(0), channel(8), channel(16)};
}

/// Writes the grids of one volume in sequence.
class VolumeWriter {
 public:
  VolumeWriter(const MapSnapshot& snapshot, const PlacedVolume& volume, VdbLeaves leaves)
      : snapshot_(snapshot), volume_(volume), leaves_(std::move(leaves)) {}

  /// Writes the next part. Returns false if all grids are complete.
  bool WriteNext(std::ostream* out) {
    while (true) {
      if (grid_ != nullptr && grid_->WriteNext(out)) return true;
      if (next_grid_ == kGrids || (next_grid_ == kColor && leaves_.colored.empty())) return false;
      grid_ = MakeGrid(next_grid_++);
    }
  }

 private:
  static constexpr int kDistance = 0;
  static constexpr int kWeight = 1;
  static constexpr int kColor = 2;
  static constexpr int kGrids = 3;

  std::unique_ptr<VdbGridWriter> MakeGrid(int kind) const {
    switch (kind) {
      case kDistance:
        return MakeDistance();
      case kWeight:
        return MakeWeight();
      default:
        return MakeColor();
    }
  }

  std::unique_ptr<VdbGridWriter> MakeDistance() const {
    auto grid = openvdb::FloatGrid::create(static_cast<float>(snapshot_.scale.truncation_m));
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    DescribeGrid(snapshot_, volume_, "distance", grid.get());
    const float step_m = snapshot_.scale.distance_step_m();
    return MakeFloats(std::move(grid), [step_m](Voxel voxel) { return voxel.distance_m(step_m); });
  }

  std::unique_ptr<VdbGridWriter> MakeWeight() const {
    auto grid = openvdb::FloatGrid::create(0.0F);
    DescribeGrid(snapshot_, volume_, "weight", grid.get());
    return MakeFloats(std::move(grid), &Voxel::weight);
  }

  template <typename ValueOf>
  std::unique_ptr<VdbGridWriter> MakeFloats(openvdb::FloatGrid::Ptr grid, ValueOf value_of) const {
    return MakeVdbGridWriter(
        std::move(grid), leaves_.observed, [this, value_of](const MaskedLeaf& leaf, float* out) {
          const Voxel* const voxels = volume_.voxels->FindLeaf(leaf.origin).voxels;
          for (std::size_t i = 0; i < kLeafVoxels; ++i) {
            if (IsSet(leaf.mask, i)) out[i] = std::invoke(value_of, voxels[i]);
          }
        });
  }

  std::unique_ptr<VdbGridWriter> MakeColor() const {
    auto grid = openvdb::Vec3fGrid::create(openvdb::Vec3f(0.0F));
    DescribeGrid(snapshot_, volume_, "color", grid.get());
    return MakeVdbGridWriter(
        std::move(grid), leaves_.colored, [this](const MaskedLeaf& leaf, openvdb::Vec3f* out) {
          const std::uint32_t* const colors = volume_.voxels->FindLeaf(leaf.origin).color;
          for (std::size_t i = 0; i < kLeafVoxels; ++i) {
            if (IsSet(leaf.mask, i)) out[i] = ToVec3f(colors[i]);
          }
        });
  }

  const MapSnapshot& snapshot_;
  const PlacedVolume volume_;
  const VdbLeaves leaves_;
  int next_grid_ = kDistance;
  std::unique_ptr<VdbGridWriter> grid_;  ///< Refers to `leaves_`; null before the first.
};

/// See `MakeVdbEncoder`.
class VdbEncoder final : public FileEncoder {
 public:
  VdbEncoder(const MapSnapshot& snapshot,
             std::vector<PlacedVolume> volumes,
             const std::optional<Box>& box_world,
             Cancellation cancellation)
      : snapshot_(snapshot),
        volumes_(std::move(volumes)),
        box_world_(box_world),
        cancellation_(std::move(cancellation)) {
    // Without exceptions, a failed allocation would leave a gap in the file unnoticed.
    out_.exceptions(std::ios::badbit | std::ios::failbit);
  }

  absl::StatusOr<bool> Next(std::string* piece) override {
    piece->clear();
    try {
      const absl::Status status = Fill();
      if (!status.ok()) return status;
    } catch (const std::exception& error) {
      return MakeError(absl::StatusCode::kInternal,
                       reason::kInternal,
                       std::string("failed to write the OpenVDB file: ") + error.what());
    }
    *piece = std::move(out_).str();
    out_.str({});
    return !piece->empty();
  }

 private:
  const Box* box() const { return box_world_ ? &*box_world_ : nullptr; }

  /// Writes parts until the next part might exceed the length of a piece.
  absl::Status Fill() {
    if (!head_written_) {
      InitializeOpenVdb();
      const absl::StatusOr<std::size_t> grid_count = CountGrids();
      if (!grid_count.ok()) return grid_count.status();
      out_ << FileHead(*grid_count);
      head_written_ = true;
    }
    while (out_.view().size() + kMaxVdbPartBytes <= kFilePieceBytes) {
      if (cancellation_.IsCancelled()) return CancelledFileError();
      if (writer_ && writer_->WriteNext(&out_)) continue;
      if (next_volume_ == volumes_.size()) break;
      const PlacedVolume& volume = volumes_[next_volume_++];
      absl::StatusOr<VdbLeaves> leaves =
          ChooseVdbLeaves(volume, snapshot_.scale, box(), cancellation_);
      if (!leaves.ok()) return leaves.status();
      writer_.emplace(snapshot_, volume, *std::move(leaves));
    }
    return absl::OkStatus();
  }

  absl::StatusOr<std::size_t> CountGrids() const {
    std::size_t count = 0;
    for (const PlacedVolume& volume : volumes_) {
      const absl::StatusOr<bool> has_color =
          HasVdbColor(volume, snapshot_.scale, box(), cancellation_);
      if (!has_color.ok()) return has_color.status();
      count += *has_color ? 3 : 2;
    }
    return count;
  }

  const MapSnapshot& snapshot_;
  const std::vector<PlacedVolume> volumes_;
  const std::optional<Box> box_world_;
  const Cancellation cancellation_;
  bool head_written_ = false;
  std::size_t next_volume_ = 0;
  std::optional<VolumeWriter> writer_;  ///< Of the volume before `next_volume_`.
  std::ostringstream out_{std::ios::binary};
};

}  // namespace

std::unique_ptr<FileEncoder> MakeVdbEncoder(const MapSnapshot& snapshot,
                                            std::vector<PlacedVolume> volumes,
                                            const std::optional<Box>& box_world,
                                            Cancellation cancellation) {
  return std::make_unique<VdbEncoder>(
      snapshot, std::move(volumes), box_world, std::move(cancellation));
}

absl::StatusOr<std::string> WriteVdb(const MapSnapshot& snapshot,
                                     std::span<const PlacedVolume> volumes,
                                     const Box* box_world) {
  const std::unique_ptr<FileEncoder> encoder =
      MakeVdbEncoder(snapshot,
                     {volumes.begin(), volumes.end()},
                     box_world == nullptr ? std::nullopt : std::optional<Box>(*box_world));
  return EncodeWhole(encoder.get());
}

absl::StatusOr<std::string> WriteVdb(const MapSnapshot& snapshot, const Box* box_world) {
  return WriteVdb(snapshot, ShownVolumes(snapshot), box_world);
}

}  // namespace steadymap
