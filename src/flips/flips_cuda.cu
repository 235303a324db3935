// SPDX-License-Identifier: Apache-2.0
#include "par/cuda.cuh"

namespace tetune {
using Instance = par::Cuda;
}

#include "flips/instantiate.inl"
