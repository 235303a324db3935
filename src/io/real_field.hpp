// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tetune {

/// A number in a notation of other programs, which std::from_chars refuses: with a plus sign, with the exponent of
/// Fortran (1.0D-3), or beyond the range of double, where the value is zero or infinity. Nothing is returned for a text
/// that is no number.
std::optional<double> parse_real_field(std::string text);

/// The real number in a field as Fortran writes it: 1.5, .5, 1.5E3, 1.5D3, 1.5+3 (1500), or an integer. Nothing is
/// returned for other fields, and zero or infinity beyond the range of double.
std::optional<double> parse_fortran_real(std::string_view field);

}  // namespace tetune
