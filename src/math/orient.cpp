// SPDX-License-Identifier: Apache-2.0
#include "math/orient.hpp"

#include <array>
#include <cmath>
#include <cstdint>

#include "backend/span.hpp"

namespace tetune {
namespace {

__extension__ typedef unsigned __int128 Wide;

std::uint64_t low_word(Wide x) { return static_cast<std::uint64_t>(x); }

/// x = sign * mantissa * 2^exponent, exactly.
struct Scaled {
  std::uint64_t mantissa;
  int exponent;
  bool negative;
  explicit Scaled(double x) : negative(x < 0) {
    constexpr int kDigits = 53;
    mantissa = static_cast<std::uint64_t>(std::ldexp(std::frexp(std::fabs(x), &exponent), kDigits));
    exponent -= kDigits;
  }
};

/// An exact sum of products of three doubles of any magnitude: a fixed-point number in two's complement that covers the
/// whole range of such products (Kulisch, "Computer Arithmetic and Validity", 2008).
class ExactSum {
 public:
  /// Adds a * b * c, or subtracts it if `negative`.
  void add_product(bool negative, const Scaled& a, const Scaled& b, const Scaled& c) {
    const Wide ab = Wide{a.mantissa} * b.mantissa;
    const Wide low = Wide{low_word(ab)} * c.mantissa;
    const Wide high = (ab >> 64) * c.mantissa + (low >> 64);
    const std::uint64_t words[3] = {low_word(low), low_word(high), low_word(high >> 64)};
    const int bit = a.exponent + b.exponent + c.exponent - kLowestExponent;
    const int shift = bit % 64;
    std::uint64_t shifted[4];
    for (int k = 0; k < 4; ++k) {
      const std::uint64_t upper = k < 3 ? words[k] << shift : 0;
      shifted[k] = upper | (k > 0 && shift > 0 ? words[k - 1] >> (64 - shift) : 0);
    }
    add(to_size_t(bit / 64), shifted, negative != (a.negative != (b.negative != c.negative)));
  }

  int sign() const {
    if (words_.back() >> 63 != 0) return -1;
    for (const std::uint64_t word : words_) {
      if (word != 0) return 1;
    }
    return 0;
  }

 private:
  void add(std::size_t first, const std::uint64_t addend[4], bool negative) {
    std::uint64_t carry = 0;
    for (std::size_t k = first; k < words_.size(); ++k) {
      if (k >= first + 4 && carry == 0) return;
      const Wide word = Wide{k < first + 4 ? addend[k - first] : 0} + carry;
      const Wide sum = negative ? words_[k] - word : words_[k] + word;
      words_[k] = low_word(sum);
      carry = sum >> 64 != 0 ? 1 : 0;
    }
  }

  static constexpr int kLowestExponent = -3 * (1074 + 53);  ///< of the last bit, with a margin
  static constexpr std::size_t kWords = (3 * (1024 + 1074 + 53) + 64) / 64 + 1;
  std::array<std::uint64_t, kWords> words_{};
};

}  // namespace

int orient_sign(const Point3& p0, const Point3& p1, const Point3& p2, const Point3& p3) {
  const auto scaled = [](const Point3& p) { return std::array<Scaled, 3>{Scaled(p[0]), Scaled(p[1]), Scaled(p[2])}; };
  const std::array<Scaled, 3> x[4] = {scaled(p0), scaled(p1), scaled(p2), scaled(p3)};
  // det(p1-p0, p2-p0, p3-p0) is the alternating sum of the four determinants of three of the points.
  static constexpr int kTriples[4][3] = {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
  ExactSum sum;
  for (int i = 0; i < 4; ++i) {
    const bool odd = i % 2 != 0;
    const auto& a = x[kTriples[i][0]];
    const auto& b = x[kTriples[i][1]];
    const auto& c = x[kTriples[i][2]];
    for (std::size_t k = 0; k < 3; ++k) {
      sum.add_product(odd, a[k], b[(k + 1) % 3], c[(k + 2) % 3]);
      sum.add_product(!odd, a[k], b[(k + 2) % 3], c[(k + 1) % 3]);
    }
  }
  return sum.sign();
}

}  // namespace tetune
