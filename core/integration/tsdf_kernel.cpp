#include "core/integration/tsdf_kernel.h"

namespace steadymap {

const TsdfKernels& SelectKernels() {
  static const TsdfKernels& selected =
      __builtin_cpu_supports("avx2") != 0 ? Avx2Kernels() : BaselineKernels();
  return selected;
}

}  // namespace steadymap
