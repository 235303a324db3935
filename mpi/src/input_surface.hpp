// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "distribute.hpp"
#include "surface/slide_surface.hpp"

namespace tetune::mpi {

/// The piece of the input's surface that the vertices of a part are on, and a margin around them: what they slide on in
/// all rounds. Its rim is a wall. In the numbers of the input's vertices.
class InputSurface {
 public:
  /// What some vertices of a part slide on.
  struct Piece {
    SlideSurface surface;
    std::vector<Id> id;  ///< of its vertices
  };

  InputSurface() = default;
  /// `found`: the surface of `shell`, which is the shell_of() a part whose vertices have not moved yet.
  InputSurface(const Part& part, const Part& shell, const std::vector<int>& frozen_regions, const SlideSurface& found);

  std::size_t triangles() const { return faces_.size(); }

  /// What is needed under a part. Vertices that the part has not are appended to its mesh alone. They are frozen, and
  /// so is each vertex for whose moves more of the surface, or with `bounded` of the mesh, would have to be here.
  Piece under(Part& part, bool bounded, std::vector<std::uint8_t>& frozen) const;
  /// Takes up where the vertices of the piece are afterwards.
  void settle(const Piece& piece);

  /// Hands on what is needed where tetrahedra go. Collective.
  void send(MPI_Comm comm, const Addressed& leaving);
  /// Drops what the vertices of a part do not need.
  void keep(const Part& part);

 private:
  struct SurfaceVertex {
    Id id;
    Point3 x;
    std::array<Id, 2> line;  ///< the next ones on the feature line, or -1
    int triangles;           ///< of the whole surface
    Mobility kind;
  };
  struct Face {
    std::array<Id, 3> v;  ///< increasing
    int walls;            ///< as of SlideSurface
  };
  /// Where a vertex of the mesh is: vertices of the surface, or -1.
  struct Seat {
    Id vertex;
    std::array<Id, 3> on;
  };

  void index();
  bool marked(std::size_t face, const std::vector<std::uint8_t>& vertex) const;
  void mark(const Seat& seat, std::vector<std::uint8_t>& vertex) const;
  void widen(std::vector<std::uint8_t>& vertex) const;

  std::vector<SurfaceVertex> vertices_;
  std::vector<Face> faces_;
  std::vector<Seat> seats_;  ///< all of these in increasing order
  IdMap vertex_at_, seat_at_;
  std::vector<std::array<Index, 3>> face_at_;  ///< the faces in places of vertices
};

}  // namespace tetune::mpi
