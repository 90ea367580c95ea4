#include "core/integration/tsdf_integrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <span>
#include <utility>

#include "core/integration/cell_runs.h"
#include "core/integration/frame_work.h"
#include "core/integration/seen_through_leaves.h"
#include "core/integration/semantic_cloud.h"
#include "core/integration/tsdf_kernel.h"
#include "core/types/parallel.h"
#include "core/volume/leaf_set.h"

namespace steadymap {
namespace {

// Spacing of the traversed rays at the surface, limited to every fourth cell.
constexpr double kRaySpacingLeaves = 0.26;
constexpr int kMaxRayStrideCells = 4;

// Number of leaves per batch: enough for all cores, and few enough for the new leaves to fit in a
// cache.
constexpr std::size_t kBatchLeaves = 256;

// Minimum number of leaves per core and task: about 50 us of work.
constexpr std::size_t kMinRangeLeaves = 32;

/// A frame from the viewpoint of one volume.
struct VolumeView {
  const SemanticCloud& cloud;
  Eigen::Isometry3d T_volume_camera;
  std::uint32_t owner;
  std::span<const CellRun> cells;  ///< Of the owner.
  bool clears;                     ///< See `LeafKernelFrame`.
};

/// Finds the leaves that intersect the truncation band around the surface of a frame. Works in
/// units of leaves relative to the camera's leaf, so that single precision suffices anywhere in the
/// map.
class BandTraversal {
 public:
  BandTraversal(const VolumeView& view, const VoxelScale& scale)
      : focal_x_(static_cast<float>(view.cloud.camera().fx)),
        focal_y_(static_cast<float>(view.cloud.camera().fy)),
        centre_x_(static_cast<float>(view.cloud.camera().cx)),
        centre_y_(static_cast<float>(view.cloud.camera().cy)),
        truncation_m_(static_cast<float>(scale.truncation_m)),
        leaf_size_m_(static_cast<float>(scale.leaf_size_m())),
        to_leaves_((view.T_volume_camera.linear() / scale.leaf_size_m()).cast<float>()) {
    // A leaf extends by half a voxel below the centre of its lowest voxel.
    const Eigen::Vector3d camera_leaves =
        (view.T_volume_camera.translation().array() / scale.voxel_size_m + 0.5) / kLeafSide;
    const Eigen::Vector3d base = camera_leaves.array().floor();
    base_leaf_ = base.cast<std::int32_t>();
    camera_leaves_ = (camera_leaves - base).cast<float>();
  }

  LeafSet::LeafIndex base_leaf() const { return {base_leaf_.x(), base_leaf_.y(), base_leaf_.z()}; }

  /// Adds the leaves around the surface of one cell.
  void Collect(const SurfaceCell& cell, int column, int row, LeafSet* leaves) const {
    const Eigen::Vector3f ray_camera((static_cast<float>(column) - centre_x_) / focal_x_,
                                     (static_cast<float>(row) - centre_y_) / focal_y_,
                                     1.0F);
    // Change of the signed distance per metre of depth along the ray.
    const float slant = cell.offset_m / cell.depth_m;
    const float band_m = std::min(truncation_m_ / slant, kMaxRayBand * truncation_m_);
    const float from_m = std::max(cell.depth_m - band_m, kNearM);
    const Eigen::Vector3f ray = to_leaves_ * ray_camera;
    leaves->InsertSegment(camera_leaves_ + from_m * ray,
                          camera_leaves_ + (cell.depth_m + band_m) * ray);
  }

 private:
  float focal_x_;
  float focal_y_;
  float centre_x_;
  float centre_y_;
  float truncation_m_;
  float leaf_size_m_;
  Eigen::Matrix3f to_leaves_;
  Eigen::Vector3i base_leaf_;
  Eigen::Vector3f camera_leaves_;
};

}  // namespace

struct TsdfIntegrator::Scratch {
  /// A leaf with its storage location, and the result of the frame for it.
  struct LeafWork {
    LeafVoxels new_leaf;  ///< The result if the leaf does not exist yet.
    LeafPlace place;
    LeafEdit edit;         ///< Of the existing leaf; null if it does not exist yet.
    bool changed = false;  ///< True if any bit of the leaf changed.

    LeafKernelLeaf ArraysFor(const Eigen::Vector3d& lowest_camera, bool with_color) {
      LeafKernelLeaf arrays{};
      for (int axis = 0; axis < 3; ++axis) {
        arrays.origin[axis] = static_cast<float>(lowest_camera[axis]);
      }
      arrays.voxels = &(edit ? edit.voxels : new_leaf.voxels.data())->bits;
      if (with_color) arrays.color = edit ? edit.color : new_leaf.color.data();
      arrays.observed = edit ? edit.observed.data() : new_leaf.observed.data();
      return arrays;
    }
  };

  explicit Scratch(const MapConfig& config)
      : scale{config.voxel_size_m, config.truncation_m},
        max_depth_m(static_cast<float>(config.max_depth_m)) {}

  /// Returns the current frame from the viewpoint of a volume.
  VolumeView View(std::uint32_t owner, const Eigen::Isometry3d& T_volume_world, bool clears) const {
    return {*cloud, T_volume_world * cloud->T_world_camera(), owner, runs.Of(owner), clears};
  }

  template <typename PlaceOf>
  void Update(const VolumeView& view,
              std::span<const LeafOrigin> origins,
              const PlaceOf& place_of,
              std::vector<LeafOrigin>* changed_leaves);
  const std::vector<LeafOrigin>& CollectLeaves(const VolumeView& view);
  LeafKernelFrame MakeKernelFrame(const VolumeView& view) const;
  void PrepareLeaf(LeafPlace place, bool with_color, LeafWork* work);
  static void StoreResult(const LeafWork& work);

  const TsdfKernels& kernels = SelectKernels();
  VoxelScale scale;
  float max_depth_m;
  const SemanticCloud* cloud = nullptr;  ///< The current frame.
  CellRuns runs;                         ///< Of `cloud`.
  std::size_t leaves_left = 0;           ///< Leaf budget left to the frame.
  LeafSet leaves;
  std::vector<LeafWork> batch;
};

/// Traverses the truncation band along a grid of rays and returns the intersected leaves, sorted.
/// Valid until the next call.
const std::vector<LeafOrigin>& TsdfIntegrator::Scratch::CollectLeaves(const VolumeView& view) {
  const BandTraversal walk(view, scale);
  leaves.Reset(walk.base_leaf());
  // Number of cells between two rays at a depth of one metre.
  const auto cells_at_1m =
      static_cast<float>(kRaySpacingLeaves * view.cloud.camera().fx * scale.leaf_size_m());
  const auto stride_at = [&](float depth_m) {
    return std::clamp(static_cast<int>(cells_at_1m / depth_m), 1, kMaxRayStrideCells);
  };
  const int stride = stride_at(max_depth_m);
  int last_row = -1;
  int column = 0;
  for (const CellRun& run : view.cells) {
    if (run.row % stride != 0) continue;
    if (run.row != last_row) {
      leaves.StartRow();
      // Alternate rows are shifted by half a stride: a thin upright object between the rays of one
      // row intersects the rays of the next.
      column = (run.row / stride) % 2 == 0 ? 0 : stride / 2;
      last_row = run.row;
    }
    column = std::max(column, run.begin);
    while (column < run.end) {
      const SurfaceCell& cell = view.cloud.At(column, run.row);
      walk.Collect(cell, column, run.row, &leaves);
      column += stride_at(cell.depth_m);
    }
  }
  return leaves.Sorted();
}

LeafKernelFrame TsdfIntegrator::Scratch::MakeKernelFrame(const VolumeView& view) const {
  const PinholeCamera& cell_camera = view.cloud.camera();
  LeafKernelFrame kernel_frame{};
  kernel_frame.cells = view.cloud.cells().data();
  kernel_frame.clearance = view.cloud.clearance().data();
  kernel_frame.cells_wide = view.cloud.cells_wide();
  kernel_frame.cells_high = view.cloud.cells_high();
  kernel_frame.fx = static_cast<float>(cell_camera.fx);
  kernel_frame.fy = static_cast<float>(cell_camera.fy);
  kernel_frame.cx = static_cast<float>(cell_camera.cx);
  kernel_frame.cy = static_cast<float>(cell_camera.cy);
  const Eigen::Matrix3f steps =
      (view.T_volume_camera.linear().transpose() * scale.voxel_size_m).cast<float>();
  for (int axis = 0; axis < 3; ++axis) {
    kernel_frame.step_x[axis] = steps(axis, 0);
    kernel_frame.step_y[axis] = steps(axis, 1);
    kernel_frame.step_z[axis] = steps(axis, 2);
  }
  kernel_frame.voxel_size_m = static_cast<float>(scale.voxel_size_m);
  kernel_frame.truncation_m = static_cast<float>(scale.truncation_m);
  kernel_frame.distance_step_m = scale.distance_step_m();
  kernel_frame.noise = ForKernel(view.cloud.depth_noise());
  kernel_frame.owner = view.owner;
  kernel_frame.fuse_color = view.cloud.has_color();
  kernel_frame.clears = view.clears;
  return kernel_frame;
}

void TsdfIntegrator::Scratch::PrepareLeaf(LeafPlace place, bool with_color, LeafWork* work) {
  work->place = place;
  work->edit = place.grid->EditLeaf(place.origin, with_color);
  if (work->edit) return;
  work->new_leaf = LeafVoxels{};
  work->new_leaf.has_color = with_color;
}

void TsdfIntegrator::Scratch::StoreResult(const LeafWork& work) {
  if (work.edit) {
    work.place.grid->SetObserved(work.place.origin, work.edit.observed);
  } else {
    work.place.grid->StoreLeaf(work.place.origin, work.new_leaf);
  }
}

/// Updates leaves, each given once. `place_of(origin)` returns the storage location of a leaf. Only
/// the calling thread accesses the grids; all threads access the voxels.
template <typename PlaceOf>
void TsdfIntegrator::Scratch::Update(const VolumeView& view,
                                     std::span<const LeafOrigin> origins,
                                     const PlaceOf& place_of,
                                     std::vector<LeafOrigin>* changed_leaves) {
  const LeafKernelFrame kernel_frame = MakeKernelFrame(view);
  const Eigen::Isometry3d T_camera_volume = view.T_volume_camera.inverse();
  origins = origins.first(std::min(origins.size(), leaves_left));
  leaves_left -= origins.size();
  for (std::size_t first = 0; first < origins.size(); first += kBatchLeaves) {
    const auto batch_origins =
        origins.subspan(first, std::min(kBatchLeaves, origins.size() - first));
    if (batch.size() < batch_origins.size()) batch.resize(batch_origins.size());
    for (std::size_t i = 0; i < batch_origins.size(); ++i) {
      PrepareLeaf(place_of(batch_origins[i]), kernel_frame.fuse_color, &batch[i]);
    }
    ParallelFor(batch_origins.size(), kMinRangeLeaves, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const LeafOrigin& origin = batch_origins[i];
        const Eigen::Vector3d lowest_camera =
            T_camera_volume * (Eigen::Vector3d(origin.x, origin.y, origin.z) * scale.voxel_size_m);
        batch[i].changed = kernels.update_leaf(
            kernel_frame, batch[i].ArraysFor(lowest_camera, kernel_frame.fuse_color));
      }
    });
    for (std::size_t i = 0; i < batch_origins.size(); ++i) {
      if (!batch[i].changed) continue;
      StoreResult(batch[i]);
      changed_leaves->push_back(batch_origins[i]);
    }
  }
}

TsdfIntegrator::TsdfIntegrator(const MapConfig& config)
    : scratch_(std::make_unique<Scratch>(config)) {}

TsdfIntegrator::~TsdfIntegrator() = default;
TsdfIntegrator::TsdfIntegrator(TsdfIntegrator&&) noexcept = default;
TsdfIntegrator& TsdfIntegrator::operator=(TsdfIntegrator&&) noexcept = default;

void TsdfIntegrator::SetFrame(const SemanticCloud& cloud) {
  scratch_->cloud = &cloud;
  scratch_->leaves_left = kMaxFusedLeaves;
  scratch_->runs.Compute(cloud);
}

void TsdfIntegrator::Integrate(Background* background, std::vector<LeafOrigin>* changed_leaves) {
  const VolumeView view = scratch_->View(kBackgroundOwner, Eigen::Isometry3d::Identity(), true);
  const auto place_of = [background](LeafOrigin origin) {
    return LeafPlace{&background->MutableTile(origin), origin};
  };
  const std::vector<LeafOrigin>& band = scratch_->CollectLeaves(view);
  const std::vector<LeafOrigin> in_front = FindSeenThroughLeaves(
      view.cloud, *background, scratch_->scale, static_cast<double>(scratch_->max_depth_m));
  std::vector<LeafOrigin> origins;
  origins.reserve(band.size() + in_front.size());
  std::set_union(
      band.begin(), band.end(), in_front.begin(), in_front.end(), std::back_inserter(origins));
  scratch_->Update(view, origins, place_of, changed_leaves);
}

void TsdfIntegrator::IntegrateWorld(const std::function<LeafPlace(LeafOrigin)>& place_of,
                                    std::vector<LeafOrigin>* changed_leaves) {
  const VolumeView view = scratch_->View(kBackgroundOwner, Eigen::Isometry3d::Identity(), false);
  scratch_->Update(view, scratch_->CollectLeaves(view), place_of, changed_leaves);
}

void TsdfIntegrator::Integrate(std::uint32_t owner,
                               const Eigen::Isometry3d& T_world_object,
                               TsdfGrid* grid,
                               std::vector<LeafOrigin>* changed_leaves) {
  const VolumeView view = scratch_->View(owner, T_world_object.inverse(), false);
  scratch_->Update(
      view,
      scratch_->CollectLeaves(view),
      [grid](LeafOrigin origin) {
        return LeafPlace{grid, origin};
      },
      changed_leaves);
}

}  // namespace steadymap
