// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>

#include <cstdint>
#include <cstring>
#include <new>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "bindings.hpp"
#include "io/mesh_stream.hpp"
#include "tetune/tetune.hpp"

// Reports in the encoding of meshes. Each member is listed here: a pickle lacks the others.
namespace tetune {

template <class Archive, class Enum>
requires std::is_enum_v<Enum>
void transfer(Archive& archive, Enum& value) {
  auto number = std::int32_t(value);
  archive(number);
  if constexpr (!std::is_const_v<Enum>) value = Enum(number);
}

/// The items one after another: their type has padding, which raw bytes would contain.
template <class Archive, class Items>
void transfer_each(Archive& archive, Items& items) {
  std::uint64_t count = items.size();
  archive(count);
  if constexpr (!std::is_const_v<Items>) items.resize(count);
  for (auto& item : items) archive(item);
}

template <class Archive, MaybeConst<SweepReport> Sweep>
void transfer(Archive& archive, Sweep& s) {
  archive(s.iteration, s.moved, s.energy_before, s.decrease, s.gradient_norm2, s.dihedral_min, s.seconds);
}
template <class Archive, MaybeConst<FlipReport> Flips>
void transfer(Archive& archive, Flips& f) {
  for (const auto& kind : kFlipCounts) archive(f.*kind.count);
  archive(f.iteration, f.pass, f.active, f.evaluated, f.decrease, f.seconds);
}
template <class Archive, MaybeConst<WorstReport> Worst>
void transfer(Archive& archive, Worst& w) {
  archive(w.work, w.round, w.worst, w.inserted, w.removed, w.flips, w.moved, w.dihedral_min, w.seconds);
}
template <class Archive, MaybeConst<PhaseTime> Phase>
void transfer(Archive& archive, Phase& p) {
  archive(p.phase, p.seconds);
}
template <class Archive, MaybeConst<MissedTet> Missed>
void transfer(Archive& archive, Missed& m) {
  archive(m.tet, m.value, m.centroid[0], m.centroid[1], m.centroid[2], m.held_by, m.edge[0], m.edge[1],
          m.surface_angle);
}
template <class Archive, MaybeConst<TargetReport> Target>
void transfer(Archive& archive, Target& t) {
  archive(t.target.measure, t.target.value, t.tets, t.missed);
  for (auto& count : t.held_by) archive(count);
  transfer_each(archive, t.worst);
}
template <class Archive, MaybeConst<Report> AnyReport>
void transfer(Archive& archive, AnyReport& r) {
  for (const auto& kind : kOperationCounts) archive(r.*kind.count);
  archive(r.device, r.device_reason, r.threads, r.vertices, r.tets_before, r.tets_after, r.tets_untangled);
  archive(r.deviation, r.straightened, r.tets_bad, r.tets_active);
  archive(r.free_vertices, r.plane_vertices, r.line_vertices, r.fixed_vertices);
  archive(r.surface_vertices, r.curve_vertices, r.thin_vertices, r.periodic_vertices, r.corners_not_held,
          r.edges_not_held, r.line_ends_not_held);
  archive(r.triangles_dropped, r.edges_dropped, r.colors, r.energy_before, r.energy_after);
  archive(r.vertex2original, r.places, r.uncovered, r.transfer_stopped, r.tet2original, r.triangle2original,
          r.edge2original);
  transfer_each(archive, r.sweeps);
  transfer_each(archive, r.flip_passes);
  transfer_each(archive, r.worst_rounds);
  archive(r.restarts, r.restarts_kept, r.phases, r.targets);
  archive(r.moved_fields, r.repeated_numbers, r.unchanged, r.curved_warnings, r.warnings, r.seconds, r.stop);
}
template <class Archive, MaybeConst<MoveStep> Step>
void transfer(Archive& archive, Step& s) {
  archive(s.target, s.fraction, s.solver_iterations, s.dihedral_moved, s.dihedral_min, s.seconds);
}
template <class Archive, MaybeConst<InvertedOthers> Inverted>
void transfer(Archive& archive, Inverted& i) {
  archive(i.kind, i.block, i.elements);
}
template <class Archive, MaybeConst<MoveReport> AnyReport>
void transfer(Archive& archive, AnyReport& r) {
  archive(r.optimization, r.prescribed);
  transfer_each(archive, r.steps);
  archive(r.targets, r.targets_reached, r.fraction, r.blocking_tets, r.blocking_vertices, r.frozen_moved);
  transfer_each(archive, r.inverted_others);
}

}  // namespace tetune

namespace tetune::python {

namespace nb = nanobind;
namespace {

/// The beginning of a state, which is for the version that made it.
constexpr const char* kMadeBy = "tetune " TETUNE_VERSION;

template <class T>
nb::bytes state_of(const T& object) {
  if constexpr (std::is_same_v<T, TetMesh>) {
    if (object.deck != nullptr) {
      throw nb::type_error(
          "this mesh has the text of a deck (.inp), which a pickle cannot hold; write the mesh to a file");
    }
  }
  std::string bytes;
  MeshWriter writer([&bytes](const void* data, std::size_t size) {
    const std::size_t before = bytes.size();
    bytes.resize(before + size);
    std::memcpy(bytes.data() + before, data, size);
  });
  writer(std::string(kMadeBy), kStreamVersion, object);
  if constexpr (std::is_same_v<T, TetMesh>) writer(object.deck_nodes);  // which plugins have no use for
  return nb::bytes(bytes.data(), bytes.size());
}

template <class T>
void restore(T* place, const nb::bytes& state) {
  T object;
  try {
    MeshReader reader(std::string_view(state.c_str(), state.size()));
    std::string made_by;
    std::uint64_t version = 0;
    reader(made_by, version);
    if (made_by != kMadeBy || version != kStreamVersion) {
      throw nb::value_error((std::string("this pickle is not one of ") + kMadeBy).c_str());
    }
    reader(object);
    if constexpr (std::is_same_v<T, TetMesh>) reader(object.deck_nodes);
  } catch (const FileError&) {
    throw nb::value_error("this pickle ends early");
  }
  new (place) T(std::move(object));
}

template <class T>
void add_state(nb::class_<T>& type) {
  type.def("__getstate__", &state_of<T>).def("__setstate__", &restore<T>);
}

}  // namespace

void bind_state(nb::class_<TetMesh>& type) { add_state(type); }
void bind_state(nb::class_<Report>& type) { add_state(type); }
void bind_state(nb::class_<MoveReport>& type) { add_state(type); }

}  // namespace tetune::python
