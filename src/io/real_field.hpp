// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace tetune {

/// A number in a notation of other programs, which std::from_chars refuses: with a plus sign, with the exponent of
/// Fortran (1.0D-3), or beyond the range of double, where the value is zero or infinity. Nothing, if the text is no
/// number.
std::optional<double> parse_real_field(std::string text);

}  // namespace tetune
