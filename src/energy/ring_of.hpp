// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/pack.hpp"
#include "energy/ring.hpp"
#if !defined(__CUDACC__)
#include "energy/simd_ring.hpp"
#endif

namespace tetune {

/// The ring that sweeps evaluate, chosen by the pack of the backend: SimdRing where a pack is a vector.
template <class Pack>
struct RingOf;
template <>
struct RingOf<double> {
  using type = PlainRing<>;
};
#if !defined(__CUDACC__)
template <>
struct RingOf<backend::Pack4> {
  using type = SimdRing;
};
#endif

}  // namespace tetune
