#include "core/tsdf_integrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/leaf_set.h"
#include "core/tsdf_kernel.h"

namespace steadymap {
namespace {

// Rays are walked this far apart where they meet the surface, but no further than every fourth
// cell.
constexpr double kRaySpacingLeaves = 0.26;
constexpr int kMaxRayStrideCells = 4;

/// Finds the leaves that the truncation band around a frame's surface meets. Works in leaves,
/// relative to the one that holds the camera, so that single precision suffices at any place of the
/// map.
class BandWalk {
 public:
  BandWalk(const Frame& frame, const PinholeCamera& cell_camera, const VoxelScale& scale)
      : focal_x_(static_cast<float>(cell_camera.fx)),
        focal_y_(static_cast<float>(cell_camera.fy)),
        centre_x_(static_cast<float>(cell_camera.cx)),
        centre_y_(static_cast<float>(cell_camera.cy)),
        truncation_m_(static_cast<float>(scale.truncation_m)),
        leaf_size_m_(static_cast<float>(scale.leaf_size_m())),
        to_leaves_((frame.T_world_camera.linear() / scale.leaf_size_m()).cast<float>()) {
    // A leaf reaches half a voxel below the centre of its lowest voxel.
    const Eigen::Vector3d camera_leaves =
        (frame.T_world_camera.translation().array() / scale.voxel_size_m + 0.5) / kLeafSide;
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
    // The signed distance that a metre of depth makes at the surface's slant.
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
  explicit Scratch(const MapConfig& config);

  void ComputeSurface(const Frame& frame);
  void DropDynamicClasses(const Frame& frame);
  void AddColors(const Frame& frame);
  void CollectLeaves(const Frame& frame);
  LeafKernelFrame MakeKernelFrame(const Frame& frame) const;
  bool UpdateLeaf(const LeafKernelFrame& kernel_frame,
                  LeafKernelLeaf leaf,
                  TsdfGrid* tile,
                  LeafOrigin origin);

  const TsdfKernels& kernels = SelectKernels();
  VoxelScale scale;
  float max_depth_m;
  std::vector<std::uint8_t> is_dynamic;  ///< By class.
  bool any_dynamic = false;

  // The surface cells of the frame at hand.
  int cells_wide = 0;
  int cells_high = 0;
  PinholeCamera cell_camera;
  std::vector<float> inverse_depth;
  std::vector<float> support;
  std::vector<SurfaceCell> cells;

  LeafSet leaves;
  LeafVoxels new_leaf;
};

TsdfIntegrator::Scratch::Scratch(const MapConfig& config)
    : scale{config.voxel_size_m, config.truncation_m},
      max_depth_m(static_cast<float>(config.max_depth_m)),
      is_dynamic(config.label_limit(), 0) {
  for (const SemanticClass& row : config.classes) {
    if (row.motion != ClassMotion::kDynamic) continue;
    is_dynamic[row.id.value()] = 1;
    any_dynamic = true;
  }
}

void TsdfIntegrator::Scratch::ComputeSurface(const Frame& frame) {
  const int width_px = frame.depth.units.width_px();
  const int height_px = frame.depth.units.height_px();
  if (cells_wide != width_px / 2 || cells_high != height_px / 2) {
    cells_wide = width_px / 2;
    cells_high = height_px / 2;
    const std::size_t padded = static_cast<std::size_t>(SurfaceStride(cells_wide)) *
                               static_cast<std::size_t>(cells_high + 2 * kSurfaceMarginRows);
    inverse_depth.assign(padded, 0.0F);
    support.assign(padded, 0.0F);
    cells.assign(static_cast<std::size_t>(cells_wide) * static_cast<std::size_t>(cells_high), {});
  }
  // A cell's centre lies between its four pixels, half a pixel from the first.
  cell_camera = {cells_wide,
                 cells_high,
                 frame.camera.fx / 2.0,
                 frame.camera.fy / 2.0,
                 (frame.camera.cx - 0.5) / 2.0,
                 (frame.camera.cy - 0.5) / 2.0};
  kernels.compute_surface({frame.depth.units.data(),
                           width_px,
                           height_px,
                           static_cast<float>(frame.depth.metres_per_unit),
                           max_depth_m,
                           static_cast<float>(cell_camera.fx),
                           static_cast<float>(cell_camera.fy),
                           static_cast<float>(cell_camera.cx),
                           static_cast<float>(cell_camera.cy)},
                          {inverse_depth.data(), support.data(), cells.data()});
}

void TsdfIntegrator::Scratch::DropDynamicClasses(const Frame& frame) {
  if (frame.labels.empty() || !any_dynamic) return;
  for (int row = 0; row < cells_high; ++row) {
    const std::uint16_t* upper = &frame.labels.At(0, 2 * row);
    const std::uint16_t* lower = &frame.labels.At(0, 2 * row + 1);
    SurfaceCell* row_cells =
        &cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(cells_wide)];
    for (int column = 0; column < cells_wide; ++column) {
      const int u = 2 * column;
      if ((is_dynamic[upper[u]] | is_dynamic[upper[u + 1]] | is_dynamic[lower[u]] |
           is_dynamic[lower[u + 1]]) != 0) {
        row_cells[column].weight = 0.0F;
      }
    }
  }
}

void TsdfIntegrator::Scratch::AddColors(const Frame& frame) {
  if (frame.color.empty()) return;
  for (int row = 0; row < cells_high; ++row) {
    const Rgb* pixels = &frame.color.At(0, 2 * row);
    SurfaceCell* row_cells =
        &cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(cells_wide)];
    for (int column = 0; column < cells_wide; ++column) {
      const Rgb& rgb = pixels[2 * static_cast<std::size_t>(column)];
      row_cells[column].color = static_cast<std::uint32_t>(rgb[0]) |
                                static_cast<std::uint32_t>(rgb[1]) << 8 |
                                static_cast<std::uint32_t>(rgb[2]) << 16 | 0xFF000000U;
    }
  }
}

/// Walks the truncation band along a grid of rays and collects the leaves it meets.
void TsdfIntegrator::Scratch::CollectLeaves(const Frame& frame) {
  const BandWalk walk(frame, cell_camera, scale);
  leaves.Reset(walk.base_leaf());
  // Cells that fit between two rays at a depth of one metre.
  const auto cells_at_1m =
      static_cast<float>(kRaySpacingLeaves * cell_camera.fx * scale.leaf_size_m());
  const auto stride_at = [&](float depth_m) {
    return std::clamp(static_cast<int>(cells_at_1m / depth_m), 1, kMaxRayStrideCells);
  };
  const int stride = stride_at(max_depth_m);
  for (int row = 0; row < cells_high; row += stride) {
    const SurfaceCell* row_cells =
        &cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(cells_wide)];
    leaves.StartRow();
    // Every other row is shifted by half a stride: a thin upright thing that falls between the rays
    // of one row is met by those of the next.
    const int first = (row / stride) % 2 == 0 ? 0 : stride / 2;
    int column = first;
    while (column < cells_wide) {
      const SurfaceCell& cell = row_cells[column];
      if (cell.weight > 0.0F) {
        walk.Collect(cell, column, row, &leaves);
        column += stride_at(cell.depth_m);
      } else {
        ++column;
      }
    }
  }
}

LeafKernelFrame TsdfIntegrator::Scratch::MakeKernelFrame(const Frame& frame) const {
  LeafKernelFrame kernel_frame{};
  kernel_frame.cells = cells.data();
  kernel_frame.cells_wide = cells_wide;
  kernel_frame.cells_high = cells_high;
  kernel_frame.fx = static_cast<float>(cell_camera.fx);
  kernel_frame.fy = static_cast<float>(cell_camera.fy);
  kernel_frame.cx = static_cast<float>(cell_camera.cx);
  kernel_frame.cy = static_cast<float>(cell_camera.cy);
  const Eigen::Matrix3f steps =
      (frame.T_world_camera.linear().transpose() * scale.voxel_size_m).cast<float>();
  for (int axis = 0; axis < 3; ++axis) {
    kernel_frame.step_x[axis] = steps(axis, 0);
    kernel_frame.step_y[axis] = steps(axis, 1);
    kernel_frame.step_z[axis] = steps(axis, 2);
  }
  kernel_frame.voxel_size_m = static_cast<float>(scale.voxel_size_m);
  kernel_frame.truncation_m = static_cast<float>(scale.truncation_m);
  kernel_frame.distance_step_m = scale.distance_step_m();
  kernel_frame.fuse_color = !frame.color.empty();
  return kernel_frame;
}

/// Updates one leaf in place, or makes it if the frame says anything about it.
bool TsdfIntegrator::Scratch::UpdateLeaf(const LeafKernelFrame& kernel_frame,
                                         LeafKernelLeaf leaf,
                                         TsdfGrid* tile,
                                         LeafOrigin origin) {
  LeafEdit edit = tile->EditLeaf(origin, kernel_frame.fuse_color);
  if (edit) {
    leaf.distance_m = edit.distance_m;
    leaf.weight = edit.weight;
    leaf.color = kernel_frame.fuse_color ? edit.color : nullptr;
    leaf.observed = edit.observed.data();
    if (!kernels.update_leaf(kernel_frame, leaf)) return false;
    tile->SetObserved(origin, edit.observed);
    return true;
  }
  new_leaf = LeafVoxels{};
  leaf.distance_m = new_leaf.distance_m.data();
  leaf.weight = new_leaf.weight.data();
  leaf.color = kernel_frame.fuse_color ? new_leaf.color.data() : nullptr;
  leaf.observed = new_leaf.observed.data();
  new_leaf.has_color = kernel_frame.fuse_color;
  if (!kernels.update_leaf(kernel_frame, leaf)) return false;
  tile->StoreLeaf(origin, new_leaf);
  return true;
}

TsdfIntegrator::TsdfIntegrator(const MapConfig& config)
    : scratch_(std::make_unique<Scratch>(config)) {}

TsdfIntegrator::~TsdfIntegrator() = default;
TsdfIntegrator::TsdfIntegrator(TsdfIntegrator&&) noexcept = default;
TsdfIntegrator& TsdfIntegrator::operator=(TsdfIntegrator&&) noexcept = default;

void TsdfIntegrator::Integrate(const Frame& frame,
                               Background* background,
                               std::vector<LeafOrigin>* changed_leaves) {
  Scratch& scratch = *scratch_;
  scratch.ComputeSurface(frame);
  scratch.DropDynamicClasses(frame);
  scratch.AddColors(frame);
  scratch.CollectLeaves(frame);
  const LeafKernelFrame kernel_frame = scratch.MakeKernelFrame(frame);
  const Eigen::Isometry3d T_camera_world = frame.T_world_camera.inverse();
  for (const LeafOrigin& origin : scratch.leaves.Sorted()) {
    const Eigen::Vector3d lowest_camera =
        T_camera_world *
        (Eigen::Vector3d(origin.x, origin.y, origin.z) * scratch.scale.voxel_size_m);
    LeafKernelLeaf leaf{};
    for (int axis = 0; axis < 3; ++axis) {
      leaf.origin[axis] = static_cast<float>(lowest_camera[axis]);
    }
    if (scratch.UpdateLeaf(kernel_frame, leaf, &background->MutableTile(origin), origin)) {
      changed_leaves->push_back(origin);
    }
  }
}

}  // namespace steadymap
