// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "distribute.hpp"
#include "driver/distributed_interface.hpp"

namespace tetune::mpi {

/// The piece of the input's surface that the vertices of a part slide on in all rounds, with a margin. No vertex slides
/// across its boundary. Vertices are named by their ids in the input.
class InputSurface {
 public:
  /// The surface for some vertices of a part.
  struct Piece {
    SlideSurface surface;
    std::vector<Id> id;  ///< of its vertices
  };

  InputSurface() = default;
  /// `found`: the surface of `halo`, which is halo_of() a part whose vertices have not moved yet.
  InputSurface(const Part& part, const Part& halo, const std::vector<int>& frozen_regions, const SlideSurface& found);

  std::size_t triangles() const { return faces_.size(); }

  /// Returns the surface under a part. Vertices of the surface that the part lacks are appended to its mesh only. They
  /// are frozen, and so is each vertex whose moves depend on more of the surface, or with `bounded` of the mesh, than
  /// is here.
  Piece under(Part& part, bool bounded, Marks& frozen) const;
  /// Stores the places that the vertices of the piece have on the surface after the optimization.
  void write_back(const Piece& piece);

  /// Sends the surface under the tetrahedra that leave. Collective.
  void send(MPI_Comm comm, const Addressed& leaving);
  /// Erases all that is not under the vertices of a part.
  void keep(const Part& part);

 private:
  struct SurfaceVertex {
    Id id;
    Point3 x;
    std::array<Id, 2> line;  ///< the next vertices on the feature line, or -1
    int triangles;           ///< of the whole surface
    VertexDof dof;
  };
  struct Face {
    std::array<Id, 3> v;  ///< increasing
    int feature_edges;    ///< as of SlideSurface
  };
  /// The point of the surface on which a vertex of the mesh is, and its place in the checked surface of a bound on the
  /// deviation (SlideSurface). Each is given by the vertices of a triangle, edge or vertex of the surface; unused ones
  /// are -1.
  struct SurfacePoint {
    Id vertex;
    std::array<Id, 3> on;
    std::array<Id, 3> checked_on;
    Point3 checked;
  };

  std::vector<Index> append_vertices(const Marks& near, Piece& piece, TetMesh& mesh) const;
  Index position_of(Id id, const std::vector<Index>& position) const;
  void set_vertices(const Marks& near, const std::vector<Index>& position, const std::vector<int>& triangles_here,
                    SlideSurface& surface) const;
  void index();
  bool marked(std::size_t face, const Marks& vertex) const;
  void mark(const SurfacePoint& point, Marks& vertex) const;
  void widen(Marks& vertex) const;

  std::vector<SurfaceVertex> vertices_;
  std::vector<Face> faces_;
  std::vector<SurfacePoint> surface_points_;  ///< in increasing order, as are the lists above
  IdMap vertex_at_, point_at_;
  std::vector<std::array<Index, 3>> face_at_;  ///< the faces as positions in vertices_
};

}  // namespace tetune::mpi
