// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tetune {

/// A number in a notation of other programs, which std::from_chars refuses: with a plus sign, with the exponent of
/// Fortran (1.0D-3), or beyond the range of double, where the value is zero or infinity. Nothing, if the text is no
/// number.
std::optional<double> parse_real_field(std::string text);

/// A real number as Fortran writes it, that fills the field: 1.5, .5, 1.5E3, 1.5D3, 1.5+3 (times a thousand), or an
/// integer; nothing for other fields. Zero or infinity beyond the range of double.
std::optional<double> parse_fortran_real(std::string_view field);

}  // namespace tetune
