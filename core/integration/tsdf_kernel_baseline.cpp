#define STEADYMAP_KERNEL_FUNCTION BaselineKernels
#define STEADYMAP_KERNEL_NAME "baseline"
#include "core/integration/tsdf_kernel_body.h"
