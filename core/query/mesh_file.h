#pragma once

#include <memory>
#include <string>

#include "core/query/file_encoder.h"
#include "core/volume/mesh.h"

/// Mesh files in a standard format. A mesh must have one normal per vertex, one colour per vertex
/// or none at all, and indices below the number of vertices (asserted).
///
/// An encoder owns the mesh and produces the file in pieces, in one pass.
namespace steadymap {

/// Returns the encoder of a PLY file: binary little-endian; vertices with x y z nx ny nz as float
/// and, if the mesh has colours, red green blue as uchar (sRGB); faces as
/// `list uchar int vertex_indices`. Metres, world frame, z up. An empty mesh gives a valid file
/// without vertices.
std::unique_ptr<FileEncoder> MakePlyEncoder(Mesh mesh);

/// Returns the whole PLY file.
std::string EncodePly(Mesh mesh);

}  // namespace steadymap
