// SPDX-License-Identifier: Apache-2.0
#include "backend/cuda.cuh"

namespace tetune {
using Instance = backend::Cuda;
}

#include "operators/instantiate.inl"
