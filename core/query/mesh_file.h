#pragma once

#include <memory>
#include <string>

#include "core/query/file_encoder.h"
#include "core/volume/mesh.h"

/// Meshes as files that other tools open. Every mesh must be whole: one normal a vertex, one colour
/// a vertex or none at all, indices below the number of vertices (asserted).
///
/// An encoder keeps the mesh and makes the file from it piece by piece, at the cost of one pass.
namespace steadymap {

/// A PLY file: binary little-endian; vertices with x y z nx ny nz as float and, where the mesh has
/// colours, red green blue as uchar (sRGB); faces as `list uchar int vertex_indices`. Metres, world
/// frame, z up. An empty mesh gives a valid file without vertices.
std::unique_ptr<FileEncoder> MakePlyEncoder(Mesh mesh);

/// The whole file.
std::string EncodePly(Mesh mesh);

}  // namespace steadymap
