#define STEADYMAP_KERNEL_FUNCTION Avx2Kernels
#define STEADYMAP_KERNEL_NAME "avx2"
#include "core/integration/tsdf_kernel_body.h"
