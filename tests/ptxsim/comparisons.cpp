// SPDX-License-Identifier: Apache-2.0
#include <optional>

#include "ptxsim/lanes.hpp"
#include "ptxsim/statement.hpp"

namespace tetune::ptxsim {
namespace {

/// How the result of a comparison is combined with a predicate.
enum Combination : u8 { kAlone, kAnd, kOr, kXor };

bool combined(bool result, bool with, u8 combination) {
  switch (combination) {
    case kAnd:
      return result && with;
    case kOr:
      return result || with;
    case kXor:
      return result != with;
    default:
      return result;
  }
}

/// setp: the comparison to `to`, its negation to `second_to`, both combined with the predicate `c`.
template <class T, class Relation>
struct Compare {
  static void run(Warp& w, const Instruction& i) {
    const u64* const a = w.row(i.a);
    const u64* const b = w.row(i.b);
    const auto compare = [a, b](u32 l) { return Relation::of(value_of<T>(a[l]), value_of<T>(b[l])); };
    if (i.variant == kAlone && i.second_to == kNoRow) {
      map_lanes(w, i.to, [&](u32 l) { return u64{compare(l)}; });
      return;
    }
    const u64* const with = w.row_or_null(i.c);
    u64* const to = w.row(i.to);
    u64* const second = w.row_or_null(i.second_to);
    for_each_lane(w.active, [&](u32 l) {
      const bool result = compare(l);
      const bool other = with != nullptr && ((with[l] & 1U) != 0) != i.negated;
      to[l] = combined(result, other, i.variant) ? 1 : 0;
      if (second != nullptr) second[l] = combined(!result, other, i.variant) ? 1 : 0;
    });
  }
};

// A comparison with NaN is false, but for those called unordered.
template <class T>
bool ordered(T a, T b) {
  return a == a && b == b;
}
struct Equal {
  template <class T>
  static bool of(T a, T b) {
    return a == b;
  }
};
struct Less {
  template <class T>
  static bool of(T a, T b) {
    return a < b;
  }
};
struct LessEqual {
  template <class T>
  static bool of(T a, T b) {
    return a <= b;
  }
};
struct NotEqual {
  template <class T>
  static bool of(T a, T b) {
    return ordered(a, b) && a != b;
  }
};
struct Ordered {
  template <class T>
  static bool of(T a, T b) {
    return ordered(a, b);
  }
};
template <class Relation>
struct Swapped {
  template <class T>
  static bool of(T a, T b) {
    return Relation::of(b, a);
  }
};
template <class Relation>
struct OrUnordered {
  template <class T>
  static bool of(T a, T b) {
    return !ordered(a, b) || Relation::of(a, b);
  }
};
struct Unordered {
  template <class T>
  static bool of(T a, T b) {
    return !ordered(a, b);
  }
};

template <class Relation>
Execute compare_for(Type t) {
  return t.is_float() ? for_float<Compare, Relation>(t.bits) : for_integer<Compare, Relation>(t.bits, t.is_signed());
}

Execute compare_for(std::string_view name, Type t) {
  using Choose = Execute (*)(Type);
  static const std::map<std::string_view, Choose> relations = {{"eq", compare_for<Equal>},
                                                               {"ne", compare_for<NotEqual>},
                                                               {"lt", compare_for<Less>},
                                                               {"lo", compare_for<Less>},
                                                               {"le", compare_for<LessEqual>},
                                                               {"ls", compare_for<LessEqual>},
                                                               {"gt", compare_for<Swapped<Less>>},
                                                               {"hi", compare_for<Swapped<Less>>},
                                                               {"ge", compare_for<Swapped<LessEqual>>},
                                                               {"hs", compare_for<Swapped<LessEqual>>},
                                                               {"equ", compare_for<OrUnordered<Equal>>},
                                                               {"neu", compare_for<OrUnordered<NotEqual>>},
                                                               {"ltu", compare_for<OrUnordered<Less>>},
                                                               {"leu", compare_for<OrUnordered<LessEqual>>},
                                                               {"gtu", compare_for<OrUnordered<Swapped<Less>>>},
                                                               {"geu", compare_for<OrUnordered<Swapped<LessEqual>>>},
                                                               {"num", compare_for<Ordered>},
                                                               {"nan", compare_for<Unordered>}};
  const auto found = relations.find(name);
  return found == relations.end() ? nullptr : found->second(t);
}

bool decode_setp(const Statement& s, Scope&, Instruction& i) {
  const Type t = s.type();
  i.kind = !t.is_float() ? Kind::integer : t.bits == 64 ? Kind::f64 : Kind::f32;
  // "b32" has no sign, and nothing but equality.
  i.execute = compare_for(s.modifiers.front(), t);
  if (s.has("ftz") || !take_rows(s, 3, i)) return false;
  i.second_to = s.operands[0].second_row;
  i.variant = s.has("and") ? kAnd : s.has("or") ? kOr : s.has("xor") ? kXor : kAlone;
  if (i.variant == kAlone) return true;
  i.c = s.operands[3].row;
  i.negated = s.operands[3].negated;
  return true;
}

void execute_select(Warp& w, const Instruction& i) {
  const u64* const a = w.row(i.a);
  const u64* const b = w.row(i.b);
  const u64* const condition = w.row(i.c);
  map_lanes(w, i.to, [a, b, condition](u32 l) {
    const u64 first = 0 - (condition[l] & 1U);
    return (a[l] & first) | (b[l] & ~first);
  });
}

bool decode_select(const Statement& s, Scope&, Instruction& i) {
  i.kind = Kind::move;
  i.execute = execute_select;
  return take_rows(s, 4, i);
}

}  // namespace

void add_comparisons(DecodeTable& table) {
  table["setp"] = decode_setp;
  table["selp"] = decode_select;
}

}  // namespace tetune::ptxsim
