// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tetune::par {

/// As many doubles as kernels take at a time: a vector register of the CPU; one on the GPU, which has its lanes
/// elsewhere.
#if defined(__CUDACC__)
using Pack = double;
#else
typedef double Pack __attribute__((vector_size(4 * sizeof(double))));
#endif

}  // namespace tetune::par
