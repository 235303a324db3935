// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "boundary/classify.hpp"
#include "phases/motion/harmonic_extension.hpp"
#include "phases/motion/sliding_motion.hpp"
#include "phases/optimizer.hpp"
#include "tetune/move.hpp"

namespace tetune {
namespace follow_targets_detail {

/// The positions of all vertices after a step along their displacements.
struct DisplacedPoints {
  Span<const Point> points;
  Span<const Vec3> displacement;
  Span<const Vec3> target;
  Span<const std::uint8_t> prescribed;
  double step;
  Span<const VertexDof> dof;
  Span<const Vec3> slid;  ///< meaningful where a vertex slides; may be empty if none does
  /// At the end of the way, a prescribed vertex is at its target to the last bit.
  TETUNE_HD Vec3 operator()(Size v) const {
    if (slid.size() > 0 && slides(dof[v])) return slid[v];
    return step == 1 && prescribed[v] != 0 ? target[v] : vec(points[v]) + step * displacement[v];
  }
};

/// Whether a step must not be made because of a tetrahedron: its volume would not be certified positive after the
/// step, or not positive along the way, or its energy would grow by too much.
struct RefusesStep {
  MeshView mesh;
  DisplacedPoints displaced;
  Objective objective;  ///< the shape energy
  double safe_energy;
  double max_growth;
  TETUNE_HD bool operator()(Size t) const {
    if (!mesh.alive(t)) return false;
    const Tet tet = mesh.tet2vertex[t];
    Vec3 from[4];
    Vec3 to[4];
    bool moves = false;
    for (int k = 0; k < 4; ++k) {
      from[k] = vec(mesh.points[tet[k]]);
      to[k] = displaced(tet[k]);
      moves = moves || from[k].x != to[k].x || from[k].y != to[k].y || from[k].z != to[k].z;
    }
    if (!moves) return false;
    if (!orient(to[0], to[1], to[2], to[3]).certified() || !is_positive_between(from, to)) return true;
    const double energy = tet_energy(objective, to[0], to[1], to[2], to[3]).energy;
    return energy > safe_energy &&
           energy > max_growth * tet_energy(objective, from[0], from[1], from[2], from[3]).energy;
  }

 private:
  /// The volume is a cubic polynomial of the part of the step; it is positive if its Bernstein coefficients are, of
  /// which the first and the last are the volumes before and after the step.
  TETUNE_HD static bool is_positive_between(const Vec3* from, const Vec3* to) {
    Vec3 a[3];
    Vec3 b[3];
    for (int k = 0; k < 3; ++k) {
      a[k] = from[k + 1] - from[0];
      b[k] = to[k + 1] - to[0];
    }
    double second = 0;
    double third = 0;
    for (int k = 0; k < 3; ++k) {
      second += dot(cross(a[(k + 1) % 3], a[(k + 2) % 3]), b[k]);
      third += dot(cross(b[(k + 1) % 3], b[(k + 2) % 3]), a[k]);
    }
    return second > 0 && third > 0;
  }
};

struct CountRefusing {
  RefusesStep refuses;
  TETUNE_HD Sum<Size> operator()(Size t) const { return {refuses(t) ? 1 : 0}; }
};

struct MovePoints {
  DisplacedPoints displaced;
  Span<Point> points;
  Span<DisplacementBound> bounds;  ///< may be empty
  TETUNE_HD void operator()(Size v) const {
    // The bound limits what improvement moves a vertex: its center follows the motion.
    const Vec3 end = displaced(v);
    if (bounds.size() > 0) {
      const Vec3 move = slides(displaced.dof[v]) ? end - vec(points[v]) : displaced.step * displaced.displacement[v];
      bounds[v].center = bounds[v].center + move;
    }
    points[v] = point(end);
  }
};

/// Sets the displacements of prescribed vertices to the rest of their way, and those of other fixed vertices to 0. The
/// other vertices keep `rest` of their last displacement, as an initial guess.
struct StartDisplacement {
  Span<const Point> points;
  Span<const Vec3> target;
  Span<const std::uint8_t> prescribed;
  Span<const VertexDof> dof;
  double rest;
  Span<Vec3> displacement;
  TETUNE_HD void operator()(Size v) const {
    if (prescribed[v] != 0) {
      displacement[v] = target[v] - vec(points[v]);
    } else {
      displacement[v] = dof[v] == VertexDof::fixed ? Vec3{0, 0, 0} : rest * displacement[v];
    }
  }
};

/// Fixes the vertices of planes and lines that have a triangle of the surface in common with a prescribed vertex that
/// leaves the plane of the triangle: the shape of the surface there would follow from how they move.
struct FixBesideMovedPlanes {
  MeshView mesh;
  Span<const Vec3> target;
  Span<const std::uint8_t> prescribed;
  Span<VertexDof> dof;
  TETUNE_HD void operator()(Size t) const {
    if (!mesh.alive(t)) return;
    const Tet tet = mesh.tet2vertex[t];
    for (int f = 0; f < 4; ++f) {
      if (!is_locked(mesh.tet2tet[t][f])) continue;
      const Index v[3] = {tet[face_vertex(f, 0)], tet[face_vertex(f, 1)], tet[face_vertex(f, 2)]};
      if (!leaves_plane(v)) continue;
      for (const Index vertex : v) {
        const VertexDof now = backend::load_shared(dof[vertex]);
        if (now == VertexDof::plane || now == VertexDof::line) backend::store_shared(dof[vertex], VertexDof::fixed);
      }
    }
  }

 private:
  TETUNE_HD bool leaves_plane(const Index* v) const {
    const Vec3 x = vec(mesh.points[v[0]]);
    const Vec3 e1 = vec(mesh.points[v[1]]) - x;
    const Vec3 e2 = vec(mesh.points[v[2]]) - x;
    const Vec3 normal = cross(e1, e2);
    for (int k = 0; k < 3; ++k) {
      if (prescribed[v[k]] == 0) continue;
      const Vec3 d = target[v[k]] - vec(mesh.points[v[k]]);
      if (std::fabs(dot(normal, d)) > kFlat * norm(normal) * (norm(e1) + norm(d))) return true;
    }
    return false;
  }
};

}  // namespace follow_targets_detail

/// Moves a mesh to targets in steps of positive volumes, each followed by an improvement.
template <class Backend>
class TargetFollower {
 public:
  /// `improve` is called after each step; it returns false when the caller cancels.
  TargetFollower(Optimizer<Backend>& optimizer, std::function<bool(Optimizer<Backend>&)> improve, std::size_t targets,
                 std::vector<MoveStep>& steps)
      : optimizer_(optimizer), improve_(std::move(improve)), targets_(static_cast<double>(targets)), steps_(steps) {}

  /// Moves to the target number `index`: a position per vertex of the mesh, that counts where `prescribed` is 1.
  /// Requires that prescribed vertices are fixed. Returns the fraction of the way that was possible: 1 if the target
  /// was reached.
  double follow(std::size_t index, const std::vector<Vec3>& target, const std::vector<std::uint8_t>& prescribed) {
    target_.upload(optimizer_.backend, target);
    prescribed_.upload(optimizer_.backend, prescribed);
    displacement_.resize(optimizer_.backend, 0);
    double rest = 1;  // of the way
    double last = 1;  // the fraction that the last step made
    double part = 0;  // of the rest of the way that the last step made
    for (int stalls = 0; rest > 0 && stalls < parameters().max_stalls;) {
      const auto start = PhaseTimer::SteadyClock::now();
      MoveStep step;
      step.target = index;
      prepare();
      optimizer_.timer.measure(Phase::motion, [&] {
        step.solver_iterations = extend(1 - part);
        part = optimizer_.backend.stop_requested() ? 0 : find_step(rest, last * parameters().step_increase);
        if (part > 0) apply(part);
      });
      last = part * rest;
      rest = part == 1 ? 0 : rest * (1 - part);
      stalls = last < parameters().min_fraction && rest > 0 ? stalls + 1 : 0;
      step.fraction = 1 - rest;
      step.dihedral_moved = smallest_angle();
      optimizer_.progress.set_done((static_cast<double>(index) + step.fraction) / targets_);
      const bool proceeds = improve_(optimizer_);
      step.dihedral_min = smallest_angle();
      step.seconds = PhaseTimer::seconds_since(start);
      steps_.push_back(step);
      last = std::max(last, parameters().min_fraction);
      if (!proceeds) break;
    }
    return 1 - rest;
  }

  /// The tetrahedra that a further step would invert, or else distort too much. `rest` is the fraction of the way that
  /// is not done.
  std::vector<Index> blocking_slots(double rest) {
    prepare();
    extend(0);
    const auto next = displaced(std::min(1.0, parameters().min_fraction / rest));
    for (const StepRule rule : {StepRule::volumes, StepRule::volumes_and_energies}) {
      const auto slots = find_tets(optimizer_.backend, optimizer_.work.mesh, refuses(next, rule));
      if (slots.size() > 0) return slots.download();
    }
    return {};
  }

  /// The prescribed vertices that are not at their target.
  std::vector<std::uint8_t> unfinished() const {
    std::vector<std::uint8_t> flags = prescribed_.download();
    auto flag = flags.begin();
    for (const Vec3& d : displacement_.download()) {
      if (d.x == 0 && d.y == 0 && d.z == 0) *flag = 0;
      ++flag;
    }
    return flags;
  }

 private:
  /// The requirements on a step: positive volumes alone, or energies that do not grow by too much as well.
  enum class StepRule { volumes, volumes_and_energies };

  const MotionParameters& parameters() const { return optimizer_.tuning.motion; }

  double smallest_angle() const {
    return ProgressReporter::degrees(find_max_cot(optimizer_.backend, optimizer_.work.mesh));
  }

  /// Extends the targets to inserted vertices, and builds the rings. Measures its own time.
  void prepare() {
    optimizer_.timer.measure(Phase::motion, [&] {
      add_inserted_vertices();
      WorkMesh<Backend>& mesh = optimizer_.work.mesh;
      optimizer_.backend.for_each(mesh.slots(), follow_targets_detail::FixBesideMovedPlanes{
                                                    mesh.view(), std::as_const(target_).span(),
                                                    std::as_const(prescribed_).span(), optimizer_.work.dofs.dof});
    });
    optimizer_.invalidate_rings();
    optimizer_.refresh_rings();
  }

  /// Computes the displacements of the rest of the way, after prepare(). `kept_fraction` of the last displacement is
  /// the initial guess. Returns the number of iterations of the solver.
  int extend(double kept_fraction) {
    using namespace follow_targets_detail;
    const Backend& backend = optimizer_.backend;
    WorkingSet<Backend>& work = optimizer_.work;
    backend.for_each(work.mesh.vertices(),
                     StartDisplacement{work.mesh.points, std::as_const(target_).span(),
                                       std::as_const(prescribed_).span(), work.dofs.dof, kept_fraction, displacement_});
    if (backend.stop_requested()) return 0;
    assemble_stiffness(backend, work.mesh, work.rings.view(), stiffness_);
    return extend_harmonically(backend, stiffness_, sliding_.find_spaces(backend, work), parameters().solver_tolerance,
                               parameters().max_solver_iterations, displacement_);
  }

  /// Vertices inserted since the last step are not prescribed, and start without a displacement.
  void add_inserted_vertices() {
    const Size vertices = optimizer_.work.mesh.vertices();
    grow_filled(optimizer_.backend, target_, vertices, Vec3{0, 0, 0});
    grow_filled(optimizer_.backend, prescribed_, vertices, std::uint8_t{0});
    grow_filled(optimizer_.backend, displacement_, vertices, Vec3{0, 0, 0});
  }

  /// Valid until the next call.
  follow_targets_detail::DisplacedPoints displaced(double part) {
    WorkingSet<Backend>& work = optimizer_.work;
    const Span<const Vec3> displacement = std::as_const(displacement_).span();
    return {work.mesh.points.span(),
            displacement,
            std::as_const(target_).span(),
            std::as_const(prescribed_).span(),
            part,
            work.dofs.dof.span(),
            sliding_.find_ends(optimizer_.backend, work, displacement, part)};
  }

  follow_targets_detail::RefusesStep refuses(const follow_targets_detail::DisplacedPoints& displaced, StepRule rule) {
    const double safe_energy = rule == StepRule::volumes ? kInfeasible : parameters().safe_energy;
    return {optimizer_.work.mesh.view(), displaced, kShapeObjective, safe_energy, parameters().max_energy_growth};
  }

  /// Returns the part of the displacements that can be made in one step, 0 if none; `longest` is the fraction of the
  /// way that it may be at most, and `rest` that of the displacements.
  double find_step(double rest, double longest) {
    using namespace follow_targets_detail;
    const double least = parameters().min_fraction / rest;
    double part = std::min(1.0, longest / rest);
    for (const StepRule rule : {StepRule::volumes_and_energies, StepRule::volumes}) {
      // Where only volumes count, a much shorter step is better than none.
      constexpr double kShorter = 0.01;
      for (; part >= (rule == StepRule::volumes ? kShorter : 1) * least; part *= parameters().step_decrease) {
        const CountRefusing refusing{refuses(displaced(part), rule)};
        if (optimizer_.backend.template reduce<Sum<Size>>(optimizer_.work.mesh.slots(), refusing).value == 0)
          return part;
      }
    }
    return 0;
  }

  void apply(double part) {
    using namespace follow_targets_detail;
    const Backend& backend = optimizer_.backend;
    WorkingSet<Backend>& work = optimizer_.work;
    backend.for_each(work.mesh.vertices(), MovePoints{displaced(part), work.mesh.points, work.dofs.displacement_bound});
    sliding_.set_surface_points(backend, work);
    backend.fill(work.dofs.active.span(), std::uint8_t{1});
  }

  Optimizer<Backend>& optimizer_;
  const std::function<bool(Optimizer<Backend>&)> improve_;
  const double targets_;
  std::vector<MoveStep>& steps_;
  BufferOf<Backend, Vec3> target_;
  BufferOf<Backend, std::uint8_t> prescribed_;
  BufferOf<Backend, Vec3> displacement_;
  SlidingMotion<Backend> sliding_;
  Stiffness<Backend> stiffness_;
};

}  // namespace tetune
