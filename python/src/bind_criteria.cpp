// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>

#include "bindings.hpp"
#include "criteria_file.hpp"
#include "tetune/tetune.hpp"

namespace tetune::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

/// From {"mean_ratio": {"warn": 0.2, "fail": 0.05, "allowed_percent": 0.1}}.
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

AcceptanceReport check_mesh(const TetMesh& mesh, const nb::object& criteria, int threads) {
  const AcceptanceCriteria parsed = nb::isinstance<nb::dict>(criteria)
                                        ? parse_criteria(nb::borrow<nb::dict>(criteria))
                                        : cli::read_criteria(nb::cast<std::string>(nb::str(criteria)));
  const nb::gil_scoped_release release;
  return check(mesh, parsed, threads);
}

}  // namespace

void bind_criteria(nb::module_& m) {
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
  m.def("check", &check_mesh, "mesh"_a, "criteria"_a, nb::kw_only(), "threads"_a = 0,
        nb::sig("def check(mesh: TetMesh, criteria: Any, *, threads: int = 0) -> AcceptanceReport"));
}

}  // namespace tetune::python
