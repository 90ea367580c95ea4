// The body of tsdf_kernel_baseline.cpp and tsdf_kernel_avx2.cpp, compiled once for each instruction
// set. It calls no inline functions of other headers: the linker keeps one copy of such a function
// for all callers, which might be the AVX2 copy. The arithmetic uses GCC's vector types of eight
// lanes. For processors without AVX the compiler splits them in two, with equal results.

#include "core/integration/leaf_kernel_body.h"
#include "core/integration/surface_kernel_body.h"
#include "core/integration/tsdf_kernel.h"

namespace steadymap {

const TsdfKernels& STEADYMAP_KERNEL_FUNCTION() {
  static constexpr TsdfKernels kKernels = {STEADYMAP_KERNEL_NAME, ComputeSurface, UpdateLeaf};
  return kKernels;
}

}  // namespace steadymap
