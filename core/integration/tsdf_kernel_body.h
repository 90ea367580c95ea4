// The body of tsdf_kernel_baseline.cpp and tsdf_kernel_avx2.cpp, compiled once for each instruction
// set. It calls no inline function of other headers: one compiled for AVX2 could be the copy that
// the linker keeps for everybody. Arithmetic is written on GCC's vector types, eight lanes at a
// time; on a processor without AVX the compiler splits them in two, and the results stay the same.

#include "core/integration/leaf_kernel_body.h"
#include "core/integration/surface_kernel_body.h"
#include "core/integration/tsdf_kernel.h"

namespace steadymap {

const TsdfKernels& STEADYMAP_KERNEL_FUNCTION() {
  static constexpr TsdfKernels kKernels = {STEADYMAP_KERNEL_NAME, ComputeSurface, UpdateLeaf};
  return kKernels;
}

}  // namespace steadymap
