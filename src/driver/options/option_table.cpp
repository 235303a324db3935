// SPDX-License-Identifier: Apache-2.0
#include "tetune/option_table.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <type_traits>

#include "driver/report/targets.hpp"
#include "math/constants.hpp"
#include "phases/tuning.hpp"
#include "system/real_text.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

constexpr int choice_value(auto enumerator) { return static_cast<int>(enumerator); }

constexpr std::array kDevices{
    OptionChoice{"auto", choice_value(Device::automatic),
                 "as cuda for 500000 tetrahedra or more if there is a GPU with enough memory, else as cpu",
                 "automatic"},
    OptionChoice{"cpu", choice_value(Device::cpu), "on CPU threads"},
    OptionChoice{"cuda", choice_value(Device::cuda), "on the current NVIDIA GPU, compute capability 7.5 or newer"}};

constexpr std::array kBoundaries{
    OptionChoice{"preserve", choice_value(Boundary::preserve),
                 "vertices move within planes and along straight lines of the surface, whose shape does not change"},
    OptionChoice{"slide", choice_value(Boundary::slide),
                 "vertices move on the input surface and along its feature lines, and the surface changes a little"},
    OptionChoice{"fixed", choice_value(Boundary::fixed), "no vertex of the boundary moves"}};

constexpr std::array kEnergies{
    OptionChoice{"shape", choice_value(Energy::shape),
                 "(eta / eta_r)^(3/2), scale-free: small elements count as much as large ones"},
    OptionChoice{"harmonic", choice_value(Energy::harmonic),
                 "eta, the energy of the paper, a length: large elements count for more"}};

constexpr std::array kEfforts{
    OptionChoice{"fast", choice_value(Effort::fast),
                 "flips are searched for once, and sweeps end when one lowers the energy by less than 2 %"},
    OptionChoice{"standard", choice_value(Effort::standard),
                 "sweeps end at 0.2 %, then the worst elements and the smallest dihedral angles are improved",
                 "default"},
    OptionChoice{"best", choice_value(Effort::best),
                 "sweeps end at 0.01 %, then there is more of that work, and vertices are inserted and removed"}};

constexpr std::array kRelocations{
    OptionChoice{"newton", choice_value(Relocation::newton), "over-relaxed Newton steps"},
    OptionChoice{"gradient", choice_value(Relocation::gradient),
                 "steepest descent with a line search, as in the paper (Alg. 1); slower"}};

constexpr std::array kTerminations{
    OptionChoice{"relative", choice_value(Termination::relative),
                 "when a sweep lowers the energy by less than the part that effort sets"},
    OptionChoice{"paper", choice_value(Termination::paper), "by the conditions C1 to C3 of the paper (Sect. 4.5)"}};

constexpr std::array kSurfaceVertices{
    OptionChoice{"auto", choice_value(SurfaceVertices::automatic), "as edit with effort=best, else as keep"},
    OptionChoice{"keep", choice_value(SurfaceVertices::keep), "none is inserted or removed"},
    OptionChoice{
        "edit", choice_value(SurfaceVertices::edit),
        "vertices are inserted and removed, inside the mesh too; with boundary=preserve in flat parts of a patch "
        "and along straight feature lines, so that the surface keeps its shape; with boundary=slide on the input "
        "surface and its feature lines, and edges of the surface are flipped"}};

constexpr std::array kDataTransfers{
    OptionChoice{"carry", choice_value(DataTransfer::carry), "those of the vertex of the input, wherever it has moved"},
    OptionChoice{
        "interpolate", choice_value(DataTransfer::interpolate),
        "those of the input at the place of the vertex: floating-point numbers linearly, integers of the nearest "
        "vertex"},
    OptionChoice{
        "conserve", choice_value(DataTransfer::conserve),
        "floating-point data of vertices and of tetrahedra keep their integrals and get no new extremes, by the "
        "overlap of old and new tetrahedra; integers are those of the largest overlap; not for inverted or curved "
        "elements"}};

constexpr const char* kSurface = "Surface and constraints";
constexpr const char* kMethod = "Method";
constexpr const char* kTargets = "Targets";
constexpr const char* kResources = "Resources";
constexpr const char* kOutput = "Output";

constexpr double kMaxInt = std::numeric_limits<int>::max();

constexpr OptionCondition kWithoutSliding{[](const Options& o) { return o.boundary != Boundary::slide; },
                                          "has no effect without boundary=slide"};
constexpr OptionCondition kWithoutSweeps{[](const Options& o) { return o.max_iterations == 0; },
                                         "has no effect with max_iterations=0"};
constexpr OptionCondition kWithoutFlips{[](const Options& o) { return !o.flips; }, "has no effect with flips=false"};

constexpr OptionCondition kWithoutOperations{
    [](const Options& o) { return !o.flips && o.max_iterations == 0 && !o.untangle; },
    "leaves nothing to improve with flips=false"};

constexpr std::array kNeedsSliding{kWithoutSliding};
constexpr std::array kSweeping{kWithoutSweeps};
constexpr std::array kOperating{kWithoutOperations};
constexpr std::array kFlipping{kWithoutFlips};
constexpr std::array kEffortConditions{
    kWithoutSweeps,
    OptionCondition{[](const Options& o) { return o.termination == Termination::paper; },
                    "has little effect with termination=paper"},
    OptionCondition{[](const Options& o) { return o.effort == Effort::best && o.energy == Energy::harmonic; },
                    "inserts no vertices and leaves the worst elements alone with energy=harmonic"}};
constexpr std::array kBoundaryFlipConditions{
    OptionCondition{[](const Options& o) { return o.boundary == Boundary::fixed; },
                    "has no effect with boundary=fixed"},
    kWithoutFlips, OptionCondition{[](const Options& o) { return o.max_ring == 3; }, "has no effect with max_ring=3"},
    kWithoutSweeps};
constexpr OptionCondition kWithHarmonic{[](const Options& o) { return o.energy == Energy::harmonic; },
                                        "has no effect with energy=harmonic"};
constexpr OptionCondition kWithPaper{[](const Options& o) { return o.termination == Termination::paper; },
                                     "has no effect with termination=paper"};
constexpr bool is_edit(const Options& o) { return o.surface_vertices == SurfaceVertices::edit; }
template <const OptionCondition& condition>
constexpr OptionCondition kIfEdit{[](const Options& o) { return is_edit(o) && condition.applies(o); }, condition.text};
constexpr std::array kSurfaceEditConditions{
    OptionCondition{[](const Options& o) { return is_edit(o) && o.keep_vertices; }, "has no effect with keep_vertices"},
    OptionCondition{[](const Options& o) { return is_edit(o) && o.effort == Effort::fast; },
                    "has no effect with effort=fast"},
    kIfEdit<kWithHarmonic>,
    kIfEdit<kWithPaper>,
    kIfEdit<kWithoutSweeps>,
    OptionCondition{[](const Options& o) { return is_edit(o) && o.boundary == Boundary::fixed; },
                    "edits inner vertices only with boundary=fixed"},
    OptionCondition{[](const Options& o) { return is_edit(o) && (!o.boundary_flips || !o.flips || o.max_ring == 3); },
                    "edits inner vertices only where edges of the surface are not flipped"}};
constexpr std::array kGrowthConditions{
    OptionCondition{[](const Options& o) { return o.keep_vertices; }, "has no effect with keep_vertices"},
    // With untangle=true curved elements may be split, whatever the other options are.
    OptionCondition{[](const Options& o) {
                      return !o.untangle && o.effort != Effort::best && o.surface_vertices != SurfaceVertices::edit;
                    },
                    "has no effect without effort=best, surface_vertices=edit or untangle=true"},
    OptionCondition{[](const Options& o) { return !o.untangle && o.effort == Effort::fast; },
                    "has no effect with effort=fast"},
    OptionCondition{[](const Options& o) { return !o.untangle && kWithHarmonic.applies(o); }, kWithHarmonic.text},
    OptionCondition{[](const Options& o) { return !o.untangle && kWithPaper.applies(o); }, kWithPaper.text},
    OptionCondition{[](const Options& o) { return !o.untangle && kWithoutSweeps.applies(o); }, kWithoutSweeps.text}};
constexpr std::array kRestartConditions{
    OptionCondition{[](const Options& o) { return o.effort != Effort::best; }, "has no effect without effort=best"},
    kWithHarmonic, kWithPaper, kWithoutSweeps};
constexpr std::array kUntangling{
    OptionCondition{[](const Options& o) { return !o.untangle; }, "has no effect without untangle=true"}};
constexpr std::array kLimited{
    OptionCondition{[](const Options& o) { return o.only_below.empty(); }, "has no effect without only_below"}};
constexpr std::array kOnGpu{
    OptionCondition{[](const Options& o) { return o.device == Device::cuda; }, "has no effect with device=cuda"}};

const std::array kTable{
    OptionInfo{"boundary", &Options::boundary, kSurface, "How vertices of the boundary may move", kBoundaries},
    OptionInfo{"feature_angle",
               &Options::feature_angle,
               kSurface,
               "With boundary=slide, edges where the surface turns by a larger angle are feature lines, which vertices "
               "do not leave, except for lines that end in the middle of the surface and nowhere turn by more than 4/3 "
               "of the angle; 180: no edge is a feature by its angle",
               {},
               {.min = 0, .max = 180, .excludes_min = true, .unit = "degrees"},
               kNeedsSliding},
    OptionInfo{"max_deviation",
               &Options::max_deviation,
               kSurface,
               "With boundary=slide, maximum distance of the new surface from the old one and of the old one from the "
               "new one; 0: no bound",
               {},
               {.min = 0, .max = kInfinity, .unit = "(a length)"},
               kNeedsSliding},
    OptionInfo{"frozen_regions", &Options::frozen_regions, kSurface,
               "Tags of the regions whose tetrahedra do not change"},
    OptionInfo{"frozen_patches", &Options::frozen_patches, kSurface,
               "Tags of the patches whose listed triangles do not change"},
    OptionInfo{"frozen_vertices", &Options::frozen_vertices, kSurface,
               "One flag per vertex, or none: a vertex with a flag other than 0 does not move"},
    OptionInfo{"open_boundaries", &Options::open_boundaries, kSurface,
               "Tagged triangles with the same region on both sides stay faces of the mesh; otherwise they are "
               "dropped"},
    OptionInfo{
        "boundary_flips",
        &Options::boundary_flips,
        kSurface,
        "Edges between coplanar triangles of one patch of the boundary, or of one interface, may be flipped; with "
        "max_deviation, unless vertices of the surface are inserted and removed, in patches that lie in a plane",
        {},
        {},
        kBoundaryFlipConditions},
    OptionInfo{"effort", &Options::effort, kMethod, "How much is done", kEfforts, {}, kEffortConditions},
    OptionInfo{
        "keep_vertices", &Options::keep_vertices, kMethod,
        "No vertex is inserted or removed, as effort=best and surface_vertices=edit do otherwise, and untangle=true "
        "in curved meshes"},
    OptionInfo{"max_growth",
               &Options::max_growth,
               kMethod,
               "Vertices are inserted while the ratio of the numbers of tetrahedra of result and input is below this. "
               "A larger value allows insertion around more of the worst tetrahedra, at proportional cost. Flips are "
               "not limited: in a mesh of a few dozen tetrahedra they may add one more. With untangle=true it limits "
               "splits of valid curved elements too, whatever the other options are",
               {},
               {1, 100},
               kGrowthConditions},
    OptionInfo{"surface_vertices",
               &Options::surface_vertices,
               kMethod,
               "Whether vertices of the surface and of interfaces are inserted and removed",
               kSurfaceVertices,
               {},
               kSurfaceEditConditions},
    OptionInfo{"restarts",
               &Options::restarts,
               kMethod,
               "With effort=best, the maximum number of rounds of restarts: a round optimizes the neighborhoods of at "
               "most four of the worst elements again, without regard to the angles reached, and keeps a result that "
               "improves the worst element in it. At most as many rounds follow that lower the largest dihedral angle "
               "and leave the smallest; 0: none; -1: 10 of each, of the first kind one per 400 tetrahedra in smaller "
               "meshes",
               {},
               {-1, 10000},
               kRestartConditions},
    OptionInfo{
        "untangle", &Options::untangle, kMethod,
        "Inverted and flat tetrahedra are made positive first, instead of refused. Curved second-order elements that "
        "the surface alone makes invalid are split, and within max_growth those that it makes nearly so"},
    OptionInfo{"straighten",
               &Options::straighten,
               kMethod,
               "Where mid-side nodes of a curved surface make elements invalid, they move toward the middle of their "
               "chord, as little as makes the elements valid, instead of being refused",
               {},
               {},
               kUntangling},
    OptionInfo{"flips", &Options::flips, kMethod,
               "Edges and faces are flipped; otherwise vertices are moved, and with effort=best inserted and removed"},
    OptionInfo{"energy", &Options::energy, kMethod, "Energy per tetrahedron, the sum of which is minimized", kEnergies},
    OptionInfo{"relocation", &Options::relocation, kMethod, "How a vertex is moved", kRelocations, {}, kSweeping},
    OptionInfo{"termination", &Options::termination, kMethod, "When sweeps end", kTerminations, {}, kSweeping},
    OptionInfo{"max_iterations",
               &Options::max_iterations,
               kMethod,
               "Maximum number of relocation sweeps; 0: only flips",
               {},
               {0, kMaxInt},
               kOperating},
    OptionInfo{"max_ring",
               &Options::max_ring,
               kMethod,
               "Maximum number of tetrahedra around an edge that a flip removes or creates; 3: only 3-2 and 2-3 flips, "
               "as in the paper",
               {},
               {3, 7},
               kFlipping},
    OptionInfo{"targets", &Options::targets, kTargets,
               "Quality that every element should have, by measure. It does not change the result: the report lists "
               "the elements that miss it and what constrains them"},
    OptionInfo{"only_below", &Options::only_below, kTargets,
               "Limits of quality, by measure: only tetrahedra that miss one, and those around them, may change; all "
               "others stay bit for bit, and in their order"},
    OptionInfo{
        "rings",
        &Options::rings,
        kTargets,
        "How far around the tetrahedra of only_below others may change: each ring is the tetrahedra that share a "
        "vertex with those before",
        {},
        {0, 100},
        kLimited},
    OptionInfo{"threads",
               &Options::threads,
               kResources,
               "Number of CPU threads; 0: all. The result does not depend on it",
               {},
               {0, 4096},
               kOnGpu},
    OptionInfo{"device", &Options::device, kResources, "Where to compute", kDevices},
    OptionInfo{"data", &Options::data, kOutput, "What data are on the result", kDataTransfers},
    OptionInfo{"trace_angles", &Options::trace_angles, kOutput,
               "The smallest dihedral angle is measured after each sweep and round, for the report; takes a twelfth of "
               "the time"}};

std::string value_text(const Target& target) {
  return std::string(to_string(target.measure)) + ":" + number_text(target.value);
}
std::string value_text(int value) { return std::to_string(value); }

bool is_in(const OptionRange& range, double value) {
  return (range.excludes_min ? value > range.min : value >= range.min) && value <= range.max;
}

void check_range(const OptionInfo& option, const Options& options) {
  const auto refuse = [&](const std::string& allowed) {
    throw OptionError(std::string(option.name) + "=" + option_value(option, options) + " is out of range: it must be " +
                      allowed);
  };
  const auto check = [&]<class T>(T Options::*member) {
    if constexpr (std::is_same_v<T, int> || std::is_same_v<T, double>) {
      if (!is_in(option.range, options.*member)) refuse(to_string(option.range));
    } else if constexpr (std::is_enum_v<T>) {
      const auto& choices = option.choices;
      const bool known = std::any_of(choices.begin(), choices.end(),
                                     [&](const OptionChoice& c) { return c.value == choice_value(options.*member); });
      if (!known) refuse("one of the enumerators");
    }
  };
  std::visit(check, option.member);
}

bool is_default(const OptionInfo& option, const Options& options) {
  static const Options defaults;
  const auto same = [&]<class T>(T Options::*member) {
    if constexpr (std::is_same_v<T, std::vector<Target>>) {
      return (options.*member).empty();
    } else {
      return options.*member == defaults.*member;
    }
  };
  return std::visit(same, option.member);
}

}  // namespace

std::span<const OptionInfo> option_table() { return kTable; }

const OptionInfo* find_option(std::string_view name) {
  const auto found = std::find_if(kTable.begin(), kTable.end(), [name](const OptionInfo& o) { return o.name == name; });
  return found == kTable.end() ? nullptr : &*found;
}

const OptionChoice* find_choice(const OptionInfo& option, std::string_view name) {
  const auto is_it = [name](const OptionChoice& c) {
    return c.name == name || (c.old_name != nullptr && c.old_name == name);
  };
  const auto found = std::find_if(option.choices.begin(), option.choices.end(), is_it);
  return found == option.choices.end() ? nullptr : &*found;
}

std::string option_value(const OptionInfo& option, const Options& options) {
  const auto text = [&]<class T>(T Options::*member) -> std::string {
    const T& value = options.*member;
    if constexpr (std::is_same_v<T, bool>) {
      return value ? "true" : "false";
    } else if constexpr (std::is_same_v<T, int>) {
      return std::to_string(value);
    } else if constexpr (std::is_same_v<T, double>) {
      return number_text(value);
    } else if constexpr (std::is_enum_v<T>) {
      for (const OptionChoice& choice : option.choices) {
        if (choice.value == choice_value(value)) return choice.name;
      }
      return std::to_string(choice_value(value));
    } else {
      std::string list;
      for (const auto& item : value) {
        if (!list.empty()) list += ',';
        list += value_text(item);
      }
      return list;
    }
  };
  return std::visit(text, option.member);
}

std::string to_string(const OptionRange& range) {
  const bool bounded = range.max < kMaxInt;
  std::string text = (range.excludes_min ? "above " : "") + number_text(range.min);
  if (!bounded) {
    text += " or more";
  } else {
    text += (range.excludes_min ? " and at most " : " to ") + number_text(range.max);
  }
  return *range.unit == '\0' ? text : text + " " + range.unit;
}

void check_options(const Options& options) {
  for (const OptionInfo& option : kTable) check_range(option, options);
  for (const Target& target : options.targets) check_target(target, "the target for ");
  for (const Target& limit : options.only_below) check_target(limit, "the limit of only_below for ");
}

const char* why_ineffective(const OptionInfo& option, const Options& options) {
  for (const OptionCondition& condition : option.ineffective) {
    if (condition.applies(options)) return condition.text;
  }
  return nullptr;
}

std::vector<std::string> ineffective_options(const Options& options) {
  std::vector<std::string> warnings;
  for (const OptionInfo& option : kTable) {
    const char* reason = is_default(option, options) ? nullptr : why_ineffective(option, options);
    if (reason == nullptr) continue;
    warnings.push_back(std::string(option.name) + "=" + option_value(option, options) + " " + reason);
  }
  return warnings;
}

}  // namespace tetune
