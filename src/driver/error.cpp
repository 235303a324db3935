// SPDX-License-Identifier: Apache-2.0
#include "tetune/error.hpp"

#include <string>

#include "mesh/messages.hpp"

namespace tetune {
namespace {

/// Names the elements with a folded face, if there are any: no position of inner nodes helps these.
std::string curved_message(std::int64_t tangled, const std::vector<Index>& left, const std::vector<Index>& folded,
                           const Point3& place, const std::string& remedy, bool one_based) {
  std::string text = "of " + std::to_string(tangled) + " second-order tetrahedra that are not proved valid, " +
                     std::to_string(left.size()) + " could not be made so";
  if (!folded.empty()) {
    text += ", and " + std::to_string(folded.size()) +
            " of these have a face on the surface that its own mid-side nodes fold";
  }
  return text + first_ids(folded.empty() ? left : folded, one_based) + ", the first " + place_text(place) +
         (folded.empty() ? "\n  nodes that stay leave them no room: "
                         : "\n  no position of inner nodes makes them valid: ") +
         remedy + ".";
}

std::string untangle_message(std::int64_t tangled, const std::vector<Index>& left, UntangleError::Reason reason,
                             bool of_curved, bool one_based) {
  if (reason == UntangleError::Reason::stopped) {
    return "stopped before all of " + std::to_string(tangled) +
           (of_curved ? " second-order tetrahedra that are not proved valid were made so: "
                      : " inverted or flat tetrahedra were made positive: ") +
           std::to_string(left.size()) + " are left" + first_ids(left, one_based);
  }
  if (reason == UntangleError::Reason::surface_at_fault) {
    return "of " + std::to_string(tangled) +
           " inverted or flat tetrahedra some could not be made positive: the surface of the mesh crosses itself or is "
           "folded onto itself at " +
           std::to_string(left.size()) + " tetrahedra" + first_ids(left, one_based) + "\n  repair the surface there.";
  }
  const bool slides = reason == UntangleError::Reason::no_room_though_sliding;
  return "of " + std::to_string(tangled) +
         " inverted or flat tetrahedra some could not be made positive, or not without folding the surface: " +
         std::to_string(left.size()) + " tetrahedra there" + first_ids(left, one_based) +
         "\n  their vertices have no room: " + (slides ? "" : "let the boundary slide (boundary=slide), ") +
         "free what is frozen there, or repair the surface.";
}

std::string invalid_message(const std::vector<Index>& tets, const Point3& place, bool one_based) {
  return "the Jacobian determinant of " + std::to_string(tets.size()) +
         " second-order tetrahedra is not proved positive" + first_ids(tets, one_based) + ", the first " +
         place_text(place) + "\n  make them valid (untangle=true).";
}

std::string overlap_message(const std::vector<Index>& tets, bool one_based) {
  return "the mesh overlaps itself: flips would make faces that three or more tetrahedra share, near tetrahedra" +
         first_ids(tets, one_based) +
         "\n  repair it in the program that made it, or leave its connectivity as it is (flips=false, "
         "keep_vertices=true).";
}

}  // namespace

UntangleError::UntangleError(std::int64_t all, std::vector<Index> rest, Reason why, bool are_curved)
    : MeshError(untangle_message(all, rest, why, are_curved, false)),
      tangled(all),
      left(std::move(rest)),
      reason(why),
      of_curved(are_curved) {}

UntangleError::UntangleError(std::int64_t all, std::vector<Index> rest, std::vector<Index> with_fold,
                             const Point3& first, std::string what_helps)
    : MeshError(curved_message(all, rest, with_fold, first, what_helps, false)),
      tangled(all),
      left(std::move(rest)),
      reason(Reason::curved_surface),
      of_curved(true),
      folded(std::move(with_fold)),
      place(first),
      remedy(std::move(what_helps)) {}

std::string UntangleError::message(bool one_based) const {
  return reason == Reason::curved_surface ? curved_message(tangled, left, folded, place, remedy, one_based)
                                          : untangle_message(tangled, left, reason, of_curved, one_based);
}

CurvedError::CurvedError(std::vector<Index> invalid, const Point3& first)
    : MeshError(invalid_message(invalid, first, false) + " measure_curved() measures them."),
      tets(std::move(invalid)),
      place(first) {}

std::string CurvedError::message(bool one_based) const { return invalid_message(tets, place, one_based); }

OverlapError::OverlapError(std::vector<Index> overlapping)
    : MeshError(overlap_message(overlapping, false)), tets(std::move(overlapping)) {}

std::string OverlapError::message(bool one_based) const { return overlap_message(tets, one_based); }

}  // namespace tetune
