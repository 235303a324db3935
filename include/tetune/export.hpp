// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Marks what a shared library of tetune exports: the functions and classes of the public headers. All else is hidden.
/// Exception classes are marked, too, so that they can be caught outside the library.
#if defined(__GNUC__)
#define TETUNE_API __attribute__((visibility("default")))
#else
#define TETUNE_API
#endif
