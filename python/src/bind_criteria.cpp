// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <utility>

#include "bindings.hpp"
#include "criteria_file.hpp"
#include "options.hpp"
#include "tetune/tetune.hpp"

namespace tetune::python {
namespace {

/// The criteria of a dict {"mean_ratio": {"warn": 0.2, "fail": 0.05, "allowed_percent": 0.1}}.
AcceptanceCriteria parse_criteria(const nb::dict& given) {
  AcceptanceCriteria criteria{"criteria", {}};
  for (const auto& [key, value] : given) {
    const auto name = nb::cast<std::string>(nb::str(key));
    const CheckMeasureInfo* measure = find_check_measure(name);
    if (measure == nullptr) throw OptionError("there is no measure '" + name + "'" + cli::measure_suggestion(name));
    if (!nb::isinstance<nb::dict>(value)) throw OptionError("the criterion for " + name + " must be a dict of limits");
    AcceptanceCriterion criterion;
    criterion.measure = measure->measure;
    for (const auto& [limit, number] : nb::borrow<nb::dict>(value)) {
      const auto which = nb::cast<std::string>(nb::str(limit));
      double parsed = 0;
      if (!nb::try_cast(number, parsed)) throw OptionError(which + " of " + name + " must be a number");
      if (which == "warn") {
        criterion.warn = parsed;
      } else if (which == "fail") {
        criterion.fail = parsed;
      } else if (which == "allowed_percent") {
        criterion.allowed_percent = parsed;
      } else {
        throw OptionError("there is no '" + which + "' of a criterion; there are warn, fail and allowed_percent");
      }
    }
    criteria.criteria.push_back(criterion);
  }
  return criteria;
}

/// The criteria of a dict, or of the name of a preset or a file.
AcceptanceCriteria criteria_of(const nb::object& given) {
  if (nb::isinstance<nb::dict>(given)) return parse_criteria(nb::borrow<nb::dict>(given));
  return cli::read_criteria(nb::cast<std::string>(nb::str(given)));
}

AcceptanceReport check_mesh(const TetMesh& mesh, const nb::object& criteria, int threads) {
  const AcceptanceCriteria parsed = criteria_of(criteria);
  const nb::gil_scoped_release release;
  return check(mesh, parsed, threads);
}

CriteriaReport improve_towards(TetMesh& mesh, const nb::object& criteria, const nb::dict& options,
                               nb::object progress) {
  const AcceptanceCriteria parsed = criteria_of(criteria);
  const Options parsed_options = parse_options(options);
  const Context context = context_of(std::move(progress));
  CriteriaReport report = without_gil([&] { return optimize_towards(mesh, parsed, parsed_options, context); });
  warn(report.optimization.warnings);
  return report;
}

void bind_verdicts(nb::module_& m) {
  nb::class_<CriterionResult>(m, "CriterionResult", "The verdict of one criterion.")
      .def_prop_ro("measure", [](const CriterionResult& r) { return std::string(info_of(r.criterion.measure).name); })
      .def_prop_ro("verdict", [](const CriterionResult& r) { return std::string(to_string(r.verdict)); })
      .def_prop_ro("warn", [](const CriterionResult& r) { return r.criterion.warn; })
      .def_prop_ro("fail", [](const CriterionResult& r) { return r.criterion.fail; })
      .def_prop_ro("allowed_percent", [](const CriterionResult& r) { return r.criterion.allowed_percent; })
      .def_prop_ro(
          "source", [](const CriterionResult& r) { return r.criterion.source; }, "Of the limits.")
      .def_ro("count", &CriterionResult::count, "Number of tetrahedra, or faces, that were measured.")
      .def_ro("warned", &CriterionResult::warned, "Number of those that miss the limit to warn, but not that to fail.")
      .def_ro("failed", &CriterionResult::failed, "Number of those that miss the limit to fail.")
      .def_ro("worst", &CriterionResult::worst, "The worst value.")
      .def_ro("worst_tet", &CriterionResult::worst_tet, "The tetrahedron that has it.")
      .def_ro("centroid", &CriterionResult::centroid, "Of that tetrahedron.")
      .def("__repr__", [](const CriterionResult& r) {
        return "<tetune.CriterionResult: " + std::string(info_of(r.criterion.measure).name) + " " +
               to_string(r.verdict) + ">";
      });
  nb::class_<AcceptanceReport>(m, "AcceptanceReport", "The verdict of all criteria on a mesh.")
      .def_ro("name", &AcceptanceReport::name, "Of the criteria.")
      .def_prop_ro(
          "verdict", [](const AcceptanceReport& r) { return std::string(to_string(r.verdict)); },
          "'pass', 'warn' or 'fail': the worst of all criteria.")
      .def_ro("results", &AcceptanceReport::results)
      .def("__repr__", [](const AcceptanceReport& r) {
        return "<tetune.AcceptanceReport: " + r.name + " " + to_string(r.verdict) + ">";
      });
}

void bind_rounds(nb::module_& m) {
  nb::class_<CriteriaRound>(m, "CriteriaRound", "One round of optimize() on the tetrahedra that fail the criteria.")
      .def_ro("rings", &CriteriaRound::rings, "Around those that fail.")
      .def_ro("active", &CriteriaRound::active, "Number of tetrahedra that might change.")
      .def_ro("failed_before", &CriteriaRound::failed_before,
              "Number of tetrahedra, or faces, that miss the limit of a criterion that fails, or warns.")
      .def_ro("failed_after", &CriteriaRound::failed_after)
      .def_ro("kept", &CriteriaRound::kept, "Whether the result was taken.")
      .def_ro("seconds", &CriteriaRound::seconds);
  nb::class_<CriterionLimits>(m, "CriterionLimits",
                              "The constraints of the tetrahedra that miss the limit of a criterion that fails.")
      .def_prop_ro("measure", [](const CriterionLimits& l) { return std::string(info_of(l.criterion.measure).name); })
      .def_prop_ro("fail", [](const CriterionLimits& l) { return l.criterion.fail; })
      .def_prop_ro(
          "held_by", [](const CriterionLimits& l) { return by_constraint(l.held_by); },
          "How many of them each constraint holds.")
      .def_ro("worst", &CriterionLimits::worst, "The worst of them.");
  nb::class_<CriteriaReport>(m, "CriteriaReport", "The account of a run of optimize() towards criteria.")
      .def_ro("optimization", &CriteriaReport::optimization, "The account of the whole run.")
      .def_ro("before", &CriteriaReport::before, "The verdict on the input.")
      .def_ro("after", &CriteriaReport::after, "The verdict on the result.")
      .def_ro("rounds", &CriteriaReport::rounds)
      .def_ro(
          "undone", &CriteriaReport::undone,
          "What criteria would lose by the optimization of the whole mesh, which was undone for that: rounds are on "
          "the input then; else empty.")
      .def_ro("no_rounds", &CriteriaReport::no_rounds,
              "The reason why no rounds are made with these options; else empty.")
      .def_ro("limits", &CriteriaReport::limits,
              "One per criterion that fails on the result; none for curved meshes, with only_below, and after a stop.")
      .def("__repr__", [](const CriteriaReport& r) {
        return "<tetune.CriteriaReport: " + r.after.name + " " + to_string(r.before.verdict) + " -> " +
               to_string(r.after.verdict) + ">";
      });
}

}  // namespace

void bind_criteria(nb::module_& m) {
  bind_verdicts(m);
  bind_rounds(m);
  m.def("improve_towards", &improve_towards, "mesh"_a, "criteria"_a, "options"_a, "progress"_a = nb::none(),
        nb::sig("def improve_towards(mesh: TetMesh, criteria: Any, options: dict[str, Any], progress: "
                "Callable[[Progress], object] | None = None) -> CriteriaReport"),
        "Improves a mesh in place towards criteria, which invalidates views of its arrays.");
  m.def("check", &check_mesh, "mesh"_a, "criteria"_a, nb::kw_only(), "threads"_a = 0,
        nb::sig("def check(mesh: TetMesh, criteria: Any, *, threads: int = 0) -> AcceptanceReport"));
}

}  // namespace tetune::python
