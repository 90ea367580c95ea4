#pragma once

#include "core/geometry/geometry.h"
#include "core/types/timestamp.h"

#include "steadymap/v1/frame.pb.h"

/// Fills the metadata of a frame message. The frame sources add the encoded images.
namespace steadymap {

/// Sets `capture_time`, `intrinsics` and `world_from_camera` of `message`.
void FillFrameMessage(Timestamp capture_time,
                      const PinholeCamera& camera,
                      const Eigen::Isometry3d& T_world_camera,
                      v1::Frame* message);

}  // namespace steadymap
