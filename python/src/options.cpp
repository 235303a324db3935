// SPDX-License-Identifier: Apache-2.0
#include "options.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <functional>
#include <utility>

#include "arrays.hpp"

namespace tetune::python {
namespace {

template <class E>
using Names = std::vector<std::pair<const char*, E>>;

std::string shown(nb::handle value) { return nb::cast<std::string>(nb::repr(value)); }

template <class E>
E choice(const std::string& option, nb::handle value, const Names<E>& names) {
  std::string list;
  for (const auto& [name, e] : names) {
    if (nb::isinstance<nb::str>(value) && nb::cast<std::string>(value) == name) return e;
    list += (list.empty() ? "'" : ", '") + std::string(name) + "'";
  }
  throw OptionError(option + " is " + shown(value) + "; it must be one of " + list);
}

template <class T>
T number(const std::string& option, nb::handle value) {
  T out{};
  if (nb::try_cast(value, out)) return out;
  throw OptionError(option + " is " + shown(value) + "; it must be a" +
                    (std::is_same_v<T, bool> ? " bool"
                     : std::is_integral_v<T> ? "n integer"
                                             : " number"));
}

Measure measure(const std::string& name) {
  std::string list;
  for (std::size_t k = 0; k < kMeasures; ++k) {
    const auto m = static_cast<Measure>(k);
    if (name == to_string(m)) return m;
    list += (list.empty() ? "" : ", ") + std::string(to_string(m));
  }
  throw OptionError("there is no measure '" + name + "'; the measures are " + list);
}

std::vector<Target> targets(nb::handle value) {
  if (!nb::isinstance<nb::dict>(value)) {
    throw OptionError("targets is " + shown(value) + "; it must be a dict, for example {'min_dihedral_deg': 15}");
  }
  std::vector<Target> list;
  for (const auto& [name, bound] : nb::borrow<nb::dict>(value)) {
    list.push_back({measure(nb::cast<std::string>(nb::str(name))), number<double>("a target", bound)});
  }
  return list;
}

using Set = std::function<void(Options&, const std::string&, nb::handle)>;

const std::vector<std::pair<std::string, Set>>& setters() {
  static const std::vector<std::pair<std::string, Set>> all{
      {"device",
       [](Options& o, const std::string& n, nb::handle v) {
         o.device =
             choice<Device>(n, v, {{"automatic", Device::automatic}, {"cpu", Device::cpu}, {"cuda", Device::cuda}});
       }},
      {"boundary",
       [](Options& o, const std::string& n, nb::handle v) {
         o.boundary = choice<Boundary>(
             n, v, {{"preserve", Boundary::preserve}, {"slide", Boundary::slide}, {"fixed", Boundary::fixed}});
       }},
      {"energy",
       [](Options& o, const std::string& n, nb::handle v) {
         o.energy = choice<Energy>(n, v, {{"shape", Energy::shape}, {"harmonic", Energy::harmonic}});
       }},
      {"effort",
       [](Options& o, const std::string& n, nb::handle v) {
         o.effort =
             choice<Effort>(n, v, {{"fast", Effort::fast}, {"standard", Effort::standard}, {"best", Effort::best}});
       }},
      {"keep_vertices", [](Options& o, const std::string& n, nb::handle v) { o.keep_vertices = number<bool>(n, v); }},
      {"relocation",
       [](Options& o, const std::string& n, nb::handle v) {
         o.relocation = choice<Relocation>(n, v, {{"newton", Relocation::newton}, {"gradient", Relocation::gradient}});
       }},
      {"termination",
       [](Options& o, const std::string& n, nb::handle v) {
         o.termination =
             choice<Termination>(n, v, {{"relative", Termination::relative}, {"paper", Termination::paper}});
       }},
      {"untangle", [](Options& o, const std::string& n, nb::handle v) { o.untangle = number<bool>(n, v); }},
      {"feature_angle", [](Options& o, const std::string& n, nb::handle v) { o.feature_angle = number<double>(n, v); }},
      {"max_deviation", [](Options& o, const std::string& n, nb::handle v) { o.max_deviation = number<double>(n, v); }},
      {"open_boundaries",
       [](Options& o, const std::string& n, nb::handle v) { o.open_boundaries = number<bool>(n, v); }},
      {"frozen_regions",
       [](Options& o, const std::string& n, nb::handle v) { assign(n.c_str(), v, o.frozen_regions); }},
      {"frozen_patches",
       [](Options& o, const std::string& n, nb::handle v) { assign(n.c_str(), v, o.frozen_patches); }},
      {"frozen_vertices",
       [](Options& o, const std::string& n, nb::handle v) {
         assign(n.c_str(), nb::module_::import_("numpy").attr("asarray")(v, "dtype"_a = "uint8"), o.frozen_vertices);
       }},
      {"max_iterations", [](Options& o, const std::string& n, nb::handle v) { o.max_iterations = number<int>(n, v); }},
      {"threads", [](Options& o, const std::string& n, nb::handle v) { o.threads = number<int>(n, v); }},
      {"max_ring", [](Options& o, const std::string& n, nb::handle v) { o.max_ring = number<int>(n, v); }},
      {"flips", [](Options& o, const std::string& n, nb::handle v) { o.flips = number<bool>(n, v); }},
      {"boundary_flips", [](Options& o, const std::string& n, nb::handle v) { o.boundary_flips = number<bool>(n, v); }},
      {"trace_angles", [](Options& o, const std::string& n, nb::handle v) { o.trace_angles = number<bool>(n, v); }},
      {"targets", [](Options& o, const std::string&, nb::handle v) { o.targets = targets(v); }}};
  return all;
}

}  // namespace

Options parse_options(const nb::dict& given) {
  Options options;
  for (const auto& [key, value] : given) {
    const std::string name = nb::cast<std::string>(nb::str(key));
    const Set* set = nullptr;
    std::string list;
    for (const auto& [known, setter] : setters()) {
      if (known == name) set = &setter;
      list += (list.empty() ? "" : ", ") + known;
    }
    if (set == nullptr) {
      throw nb::type_error(("optimize() has no option '" + name + "'; the options are " + list).c_str());
    }
    (*set)(options, name, value);
  }
  return options;
}

}  // namespace tetune::python
