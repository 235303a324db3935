// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <map>
#include <string>

#include "arrays.hpp"
#include "bindings.hpp"
#include "tetune/tetune.hpp"

namespace tetune::python {
namespace {

void bind_progress(nb::module_& m) {
  nb::class_<Progress>(m, "Progress", "The state of a run, for the progress callback.")
      .def_prop_ro(
          "phase", [](const Progress& p) { return std::string(p.phase); },
          "The step that was completed: 'load', 'untangling', 'flips', 'sweep', 'worst', 'angles' or 'restarts'.")
      .def_ro("iteration", &Progress::iteration, "Number of relocation sweeps so far.")
      .def_ro("energy", &Progress::energy, "The energy now.")
      .def_ro("energy_before", &Progress::energy_before, "The energy at the start.")
      .def_ro("worst_angle", &Progress::worst_angle, "Smallest dihedral angle, degrees; possibly of some passes ago.")
      .def_ro("fraction", &Progress::fraction, "Estimated fraction of the run that is done, 0 to 1.")
      .def_ro("seconds", &Progress::seconds, "Seconds since the start.")
      .def_ro("seconds_left", &Progress::seconds_left, "Estimated seconds to the end; negative while unknown.");
}

template <class T, class Counts, std::size_t kSize>
void bind_counts(nb::class_<T>& type, const std::array<CountInfo<Counts>, kSize>& kinds) {
  for (const auto& kind : kinds) {
    const auto count = kind.count;
    type.def_prop_ro(
        kind.name, [count](const T& report) { return report.*count; }, kind.text);
  }
}

void bind_passes(nb::module_& m) {
  nb::class_<SweepReport>(m, "SweepReport", "One relocation sweep over all vertices.")
      .def_ro("iteration", &SweepReport::iteration)
      .def_ro("moved", &SweepReport::moved, "Number of vertices that moved.")
      .def_ro("energy_before", &SweepReport::energy_before)
      .def_ro("decrease", &SweepReport::decrease, "Of the energy.")
      .def_ro("gradient_norm2", &SweepReport::gradient_norm2, "Squared 2-norm of the gradient.")
      .def_ro("gradient_norm", &SweepReport::gradient_norm2, "The former name of gradient_norm2, until version 0.3.")
      .def_ro("dihedral_min", &SweepReport::dihedral_min,
              "Smallest dihedral angle afterwards, degrees; 0 without trace_angles.")
      .def_ro("seconds", &SweepReport::seconds);
  nb::class_<FlipReport> flips(m, "FlipReport", "One flip pass.");
  bind_counts(flips, kFlipCounts);
  flips.def_ro("iteration", &FlipReport::iteration, "Number of relocation sweeps before.")
      .def_ro("pass_", &FlipReport::pass)
      .def_ro("active", &FlipReport::active, "Number of tetrahedra examined.")
      .def_ro("evaluated", &FlipReport::evaluated, "Number of candidate flips evaluated.")
      .def_ro("decrease", &FlipReport::decrease, "Of the energy.")
      .def_ro("seconds", &FlipReport::seconds)
      .def_prop_ro(
          "flips", [](const FlipReport& f) { return f.flips(); }, "Number of flips of all kinds.");
  nb::class_<WorstReport>(m, "WorstReport", "One round of work on the worst elements.")
      .def_ro("work", &WorstReport::work, "'mean energy', 'worst', 'angles' or 'restarts'.")
      .def_ro("round", &WorstReport::round)
      .def_ro("worst", &WorstReport::worst, "Number of tetrahedra worked on.")
      .def_ro("inserted", &WorstReport::inserted, "Number of vertices inserted.")
      .def_ro("removed", &WorstReport::removed, "Number of vertices removed.")
      .def_ro("flips", &WorstReport::flips)
      .def_ro("moved", &WorstReport::moved, "Number of vertices that moved.")
      .def_ro("dihedral_min", &WorstReport::dihedral_min, "As in SweepReport.")
      .def_ro("seconds", &WorstReport::seconds);
}

std::map<std::string, std::int64_t> held_by(const TargetReport& report) { return by_constraint(report.held_by); }

void bind_targets(nb::module_& m) {
  const auto constraint = [](const MissedTet& t) { return std::string(to_string(t.held_by)); };
  nb::class_<MissedTet>(m, "MissedTet", "An element that misses a target.")
      .def_ro("tet", &MissedTet::tet)
      .def_ro("value", &MissedTet::value)
      .def_ro("centroid", &MissedTet::centroid)
      .def_prop_ro("held_by", constraint, "Its strongest constraint, in words.")
      .def_prop_ro("pin", constraint, "The former name of held_by, until version 0.3.")
      .def_ro("edge", &MissedTet::edge, "Where the angle of the surface is the constraint: the ends of the edge.")
      .def_ro("surface_angle", &MissedTet::surface_angle, "The angle of the surface at that edge, degrees.");
  nb::class_<TargetReport>(m, "TargetReport", "How many elements miss a target, and why.")
      .def_prop_ro("measure", [](const TargetReport& t) { return std::string(to_string(t.target.measure)); })
      .def_prop_ro("value", [](const TargetReport& t) { return t.target.value; })
      .def_ro("tets", &TargetReport::tets, "Number of elements.")
      .def_ro("missed", &TargetReport::missed, "Number of those that miss the target.")
      .def_prop_ro("held_by", &held_by, "How many of them each constraint holds.")
      .def_prop_ro("pinned", &held_by, "The former name of held_by, until version 0.3.")
      .def_ro("worst", &TargetReport::worst, "The worst of them.")
      .def_prop_ro("met", &TargetReport::met);
}

void bind_straightened(nb::module_& m) {
  nb::class_<StraightenedEdge>(m, "StraightenedEdge",
                               "An edge of a curved surface that keeps a part of its curvature alone.")
      .def_ro("vertices", &StraightenedEdge::vertices)
      .def_ro("kept", &StraightenedEdge::kept, "The part.")
      .def_ro("moved", &StraightenedEdge::moved, "Distance of the mid-side node from the curved surface.");
}

/// A member of all places as a numpy array of four columns.
template <class T>
nb::object columns_of(const std::vector<MeshPlace>& places, std::array<T, 4> MeshPlace::*member) {
  auto* rows = new std::vector<std::array<T, 4>>();
  for (const MeshPlace& place : places) rows->push_back(place.*member);
  return nb::cast(view(*rows, owner_of(rows)));
}

/// The maps from the result to the input.
void bind_maps(nb::class_<Report>& report) {
  report
      .def_prop_ro(
          "vertex2original", [](nb::handle_t<Report> s) { return view(nb::cast<Report&>(s).vertex2original, s); },
          "For each vertex of the result the one of the input, -1 for inserted ones; empty where all were kept.")
      .def_prop_ro(
          "tet2original", [](nb::handle_t<Report> s) { return view(nb::cast<Report&>(s).tet2original, s); },
          "For each tetrahedron of the result its ancestor in the input.")
      .def_prop_ro(
          "triangle2original", [](nb::handle_t<Report> s) { return view(nb::cast<Report&>(s).triangle2original, s); },
          "For each listed triangle of the result its row in the input; empty where all were kept, and where none was.")
      .def_prop_ro(
          "edge2original", [](nb::handle_t<Report> s) { return view(nb::cast<Report&>(s).edge2original, s); },
          "For each listed edge of the result its row in the input; empty where all were kept, and where none was.")
      .def_prop_ro(
          "place_vertices", [](const Report& r) { return columns_of(r.places, &MeshPlace::vertices); },
          "With data='interpolate' or 'conserve': four vertices of the input, in one of whose tetrahedra each vertex "
          "of "
          "the result is.",
          nb::sig("def place_vertices(self) -> NDArray[numpy.int32]"))
      .def_prop_ro(
          "place_weights", [](const Report& r) { return columns_of(r.places, &MeshPlace::weights); },
          "Barycentric coordinates of each vertex of the result in that tetrahedron.",
          nb::sig("def place_weights(self) -> NDArray[numpy.float64]"))
      .def_ro("transfer_stopped", &Report::transfer_stopped,
              "With data='conserve': the run was stopped, and data are those of 'interpolate'.");
}

void bind_motion(nb::module_& m) {
  nb::class_<MoveStep>(m, "MoveStep", "One step of move(): all vertices move at once, then the mesh is improved.")
      .def_ro("target", &MoveStep::target, "Position in the list of targets.")
      .def_ro("fraction", &MoveStep::fraction,
              "Fraction of the straight way to that target that is covered after the step.")
      .def_ro("solver_iterations", &MoveStep::solver_iterations)
      .def_ro("dihedral_moved", &MoveStep::dihedral_moved, "Smallest dihedral angle after the motion, degrees.")
      .def_ro("dihedral_min", &MoveStep::dihedral_min, "Smallest dihedral angle after the improvement, degrees.")
      .def_ro("seconds", &MoveStep::seconds);
  nb::class_<InvertedOthers>(m, "InvertedOthers", "Pyramids, prisms or hexahedra of a block that move() inverted.")
      .def_ro("kind", &InvertedOthers::kind, "'Pyramids', 'Prisms' or 'Hexahedra'.")
      .def_ro("block", &InvertedOthers::block, "Position of the block among those of other elements.")
      .def_prop_ro(
          "elements", [](nb::handle_t<InvertedOthers> s) { return view(nb::cast<InvertedOthers&>(s).elements, s); },
          "Positions in the block, in increasing order.");
  nb::class_<MoveReport> report(m, "MoveReport", "The account of a run of move().");
  bind_state(report);
  report.def_ro("optimization", &MoveReport::optimization, "The account of the work on the mesh, all steps together.")
      .def_ro("prescribed", &MoveReport::prescribed, "Number of vertices with a position in at least one target.")
      .def_ro("steps", &MoveReport::steps)
      .def_ro("targets", &MoveReport::targets, "Number of targets.")
      .def_ro("targets_reached", &MoveReport::targets_reached, "Number of those that were reached in full.")
      .def_ro("fraction", &MoveReport::fraction,
              "Fraction of the straight way to the first target that was not reached; 1 if all were.")
      .def_prop_ro(
          "blocking_tets", [](nb::handle_t<MoveReport> s) { return view(nb::cast<MoveReport&>(s).blocking_tets, s); },
          "Tetrahedra of the result that a further step would invert.")
      .def_prop_ro(
          "blocking_vertices",
          [](nb::handle_t<MoveReport> s) { return view(nb::cast<MoveReport&>(s).blocking_vertices, s); },
          "The prescribed vertices of the result nearest to these.")
      .def_prop_ro("reached", &MoveReport::reached)
      .def_ro("frozen_moved", &MoveReport::frozen_moved,
              "Number of vertices that targets move although the options freeze them.")
      .def_ro("inverted_others", &MoveReport::inverted_others,
              "Pyramids, prisms and hexahedra that the motion inverted, by blocks.")
      .def("__repr__", [](const MoveReport& r) {
        return "<tetune.MoveReport: " + std::to_string(r.targets_reached) + " of " + std::to_string(r.targets) +
               " targets in " + std::to_string(r.steps.size()) + " steps>";
      });
}

nb::dict phase_seconds(const Report& r) {
  nb::dict phases;
  for (const PhaseTime& p : r.phases) phases[p.phase.c_str()] = p.seconds;
  return phases;
}

}  // namespace

std::map<std::string, std::int64_t> by_constraint(const std::array<std::int64_t, kLimitingConstraints>& held_by) {
  std::map<std::string, std::int64_t> named;
  for (std::size_t k = 0; k < kLimitingConstraints; ++k) {
    if (held_by[k] > 0) named.emplace(to_string(static_cast<LimitingConstraint>(k)), held_by[k]);
  }
  return named;
}

void bind_report(nb::module_& m) {
  bind_progress(m);
  bind_passes(m);
  bind_targets(m);
  bind_straightened(m);
  nb::class_<Report> report(m, "Report", "The account of a run of optimize().");
  bind_counts(report, kOperationCounts);
  bind_maps(report);
  bind_state(report);
  report.def_ro("device", &Report::device)
      .def_ro("device_reason", &Report::device_reason, "The reason for the device with device='auto'.")
      .def_ro("threads", &Report::threads)
      .def_ro("vertices", &Report::vertices, "Number of vertices of the input.")
      .def_ro("tets_before", &Report::tets_before)
      .def_ro("tets_after", &Report::tets_after)
      .def_ro("tets_untangled", &Report::tets_untangled,
              "With untangle: number of inverted or flat tetrahedra of the input.")
      .def_ro("deviation", &Report::deviation,
              "With max_deviation on a curved second-order surface: a bound on its distance from that of the input.")
      .def_ro("straightened", &Report::straightened,
              "With straighten: the edges of the surface with less curvature than in the input.")
      .def_ro("tets_bad", &Report::tets_bad, "With only_below: number of tetrahedra of the input that miss a limit.")
      .def_ro("tets_active", &Report::tets_active, "With only_below: number of tetrahedra that might change.")
      .def_ro("free_vertices", &Report::free_vertices)
      .def_ro("plane_vertices", &Report::plane_vertices)
      .def_ro("line_vertices", &Report::line_vertices)
      .def_ro("fixed_vertices", &Report::fixed_vertices)
      .def_ro("uncovered", &Report::uncovered,
              "With data='conserve': fraction of the volume of the input that no tetrahedron of the result covers.")
      .def_ro("surface_vertices", &Report::surface_vertices, "Where the boundary slides.")
      .def_ro("curve_vertices", &Report::curve_vertices, "Where the boundary slides.")
      .def_ro("thin_vertices", &Report::thin_vertices, "On thin curved sheets, which do not slide.")
      .def_ro("periodic_vertices", &Report::periodic_vertices, "That move together with their images.")
      .def_ro("corners_not_held", &Report::corners_not_held)
      .def_ro("edges_not_held", &Report::edges_not_held)
      .def_ro("line_ends_not_held", &Report::line_ends_not_held)
      .def_ro("triangles_dropped", &Report::triangles_dropped)
      .def_ro("edges_dropped", &Report::edges_dropped)
      .def_ro("colors", &Report::colors)
      .def_ro("energy_before", &Report::energy_before)
      .def_ro("energy_after", &Report::energy_after)
      .def_ro("sweeps", &Report::sweeps)
      .def_ro("flip_passes", &Report::flip_passes)
      .def_ro("worst_rounds", &Report::worst_rounds)
      .def_ro("restarts", &Report::restarts,
              "Number of neighborhoods that were optimized again: the option of this name.")
      .def_ro("restarts_kept", &Report::restarts_kept, "Number of those whose result was taken.")
      .def_prop_ro("phases", &phase_seconds, nb::sig("def phases(self) -> dict[str, float]"), "Seconds of each phase.")
      .def_ro("targets", &Report::targets, "One for each target, in order.")
      .def_ro("warnings", &Report::warnings, "Of options without effect; optimize() issues them as UserWarning.")
      .def_ro("seconds", &Report::seconds)
      .def_prop_ro(
          "stop", [](const Report& r) { return std::string(to_string(r.stop)); },
          "Why it stopped, in words: 'converged', 'iteration limit', 'cancelled', ...")
      .def("__repr__", [](const Report& r) {
        return "<tetune.Report: " + std::to_string(r.tets_before) + " -> " + std::to_string(r.tets_after) +
               " tetrahedra, " + to_string(r.stop) + ">";
      });
  bind_motion(m);
}

}  // namespace tetune::python
