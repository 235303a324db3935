// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <type_traits>

#include "backend/macros.hpp"

/// Relaxed atomics over the compilers' builtins, because libc++ before 19 has no std::atomic_ref. The only atomic
/// operations in kernels; used only where the order of the operations cannot affect the result.
namespace tetune::backend {

TETUNE_HD inline void atomic_or(std::uint32_t& target, std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  atomicOr(&target, bits);
#else
  __atomic_fetch_or(&target, bits, __ATOMIC_RELAXED);
#endif
}

namespace atomic_detail {

#if defined(__CUDA_ARCH__)
/// CUDA's type for an unsigned integer of 32 or 64 bits.
template <class T>
using Word = std::conditional_t<sizeof(T) == sizeof(unsigned), unsigned, unsigned long long>;
template <class T>
__device__ Word<T>* word(T& target) {
  static_assert(sizeof(Word<T>) == sizeof(T));
  return reinterpret_cast<Word<T>*>(&target);
}
#else
/// Stores `value` if it precedes the target.
template <class T, class Precedes>
void store_if(T& target, T value, const Precedes& precedes) {
  T current = __atomic_load_n(&target, __ATOMIC_RELAXED);
  while (precedes(value, current) &&
         !__atomic_compare_exchange_n(&target, &current, value, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
  }
}
#endif

}  // namespace atomic_detail

/// Returns what the target was before. In these three, T is an unsigned integer of 32 or 64 bits.
template <class T>
TETUNE_HD inline T atomic_add(T& target, std::type_identity_t<T> value) {
#if defined(__CUDA_ARCH__)
  return atomicAdd(atomic_detail::word(target), atomic_detail::Word<T>{value});
#else
  return __atomic_fetch_add(&target, value, __ATOMIC_RELAXED);
#endif
}
template <class T>
TETUNE_HD inline void atomic_max(T& target, std::type_identity_t<T> value) {
#if defined(__CUDA_ARCH__)
  atomicMax(atomic_detail::word(target), atomic_detail::Word<T>{value});
#else
  atomic_detail::store_if(target, value, std::greater<>());
#endif
}
template <class T>
TETUNE_HD inline void atomic_min(T& target, std::type_identity_t<T> value) {
#if defined(__CUDA_ARCH__)
  atomicMin(atomic_detail::word(target), atomic_detail::Word<T>{value});
#else
  atomic_detail::store_if(target, value, std::less<>());
#endif
}

/// Stores to a location to which several threads may store the same value concurrently.
template <class T, class U>
TETUNE_HD inline void store_shared(T& target, U value) {
#if defined(__CUDA_ARCH__)
  *const_cast<volatile T*>(&target) = static_cast<T>(value);
#else
  T stored = static_cast<T>(value);
  __atomic_store(&target, &stored, __ATOMIC_RELAXED);
#endif
}

/// Loads from a location to which other threads may store concurrently.
template <class T>
TETUNE_HD inline T load_shared(const T& target) {
#if defined(__CUDA_ARCH__)
  return *const_cast<const volatile T*>(&target);
#else
  T loaded;
  __atomic_load(&target, &loaded, __ATOMIC_RELAXED);
  return loaded;
#endif
}

}  // namespace tetune::backend
