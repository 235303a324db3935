// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tetune::par {

class Cuda;

/// Whether a backend's kernels run beside the host: it should then seldom wait for one, and give each much to do.
template <class Backend>
inline constexpr bool kBesideHost = false;
template <>
inline constexpr bool kBesideHost<Cuda> = true;

}  // namespace tetune::par
