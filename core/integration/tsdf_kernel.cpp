#include "core/integration/tsdf_kernel.h"

namespace steadymap {

const TsdfKernels* FindAvx2Kernels() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2") != 0) return &Avx2Kernels();
#endif
  return nullptr;
}

const TsdfKernels& SelectKernels() {
  static const TsdfKernels* const avx2 = FindAvx2Kernels();
  return avx2 != nullptr ? *avx2 : BaselineKernels();
}

}  // namespace steadymap
