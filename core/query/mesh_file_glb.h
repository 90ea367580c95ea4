#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <absl/status/statusor.h>

#include "core/query/file_encoder.h"
#include "core/volume/mesh.h"

namespace steadymap {

/// Returns the encoder of a binary glTF 2.0 file. It has one mesh node with a rotation from the
/// world's z axis to glTF's y axis; the positions are in the world frame, metres. It has one
/// double-sided matt material. Colours are stored as COLOR_0, RGBA in normalized unsigned bytes,
/// linear as required by glTF. A mesh without triangles gives a valid file with an empty scene.
/// Errors: `OutOfRange` with reason `BAD_VALUE` beyond 4 GiB, the limit of the format.
absl::StatusOr<std::unique_ptr<FileEncoder>> MakeGlbEncoder(Mesh mesh);

/// Returns the whole GLB file. Errors: of `MakeGlbEncoder`.
absl::StatusOr<std::string> EncodeGlb(Mesh mesh);

/// Returns the length of the binary chunk of a GLB file, bytes.
std::uint64_t GlbBufferBytes(std::uint64_t vertices, std::uint64_t triangles, bool with_colors);

}  // namespace steadymap
