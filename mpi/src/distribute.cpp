// SPDX-License-Identifier: Apache-2.0
#include "distribute.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "tetune/error.hpp"

namespace tetune::mpi {
namespace {

/// Recursive bisection: for each point the rank, such that all ranks get about as many.
class Bisection {
 public:
  Bisection(MPI_Comm comm, const std::vector<Point3>& points)
      : comm_(comm), points_(points), group_(points.size(), 0), groups_{{0, size_of(comm)}} {}

  std::vector<int> run() {
    while (std::any_of(groups_.begin(), groups_.end(), [](const Ranks& r) { return r.end - r.begin > 1; })) split();
    for (int& g : group_) g = groups_[static_cast<std::size_t>(g)].begin;
    return std::move(group_);
  }

 private:
  static constexpr int kBins = 256;
  static constexpr int kRefinements = 4;
  struct Ranks {
    int begin, end;
  };
  struct Cut {
    std::size_t axis = 0;
    double low = 0, high = 0;
    std::int64_t wanted = 0, below = 0;
  };

  void split() {
    const std::size_t n = groups_.size();
    std::vector<double> box(6 * n, std::numeric_limits<double>::infinity());
    std::vector<std::int64_t> sizes(n, 0);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto g = static_cast<std::size_t>(group_[i]);
      ++sizes[g];
      for (std::size_t k = 0; k < 3; ++k) {
        box[6 * g + k] = std::min(box[6 * g + k], points_[i][k]);
        box[6 * g + 3 + k] = std::min(box[6 * g + 3 + k], -points_[i][k]);
      }
    }
    box = all_reduce(comm_, std::move(box), MPI_MIN);
    sizes = all_reduce(comm_, std::move(sizes), MPI_SUM);
    cuts_.assign(n, {});
    for (std::size_t g = 0; g < n; ++g) {
      if (sizes[g] == 0) continue;
      Cut& cut = cuts_[g];
      const auto length = [&](std::size_t k) { return -box[6 * g + 3 + k] - box[6 * g + k]; };
      for (std::size_t k = 1; k < 3; ++k) {
        if (length(k) > length(cut.axis)) cut.axis = k;
      }
      cut.low = box[6 * g + cut.axis];
      cut.high = -box[6 * g + 3 + cut.axis];
      const Ranks r = groups_[g];
      cut.wanted = sizes[g] * ((r.end - r.begin) / 2) / (r.end - r.begin);
    }
    for (int i = 0; i < kRefinements; ++i) refine();

    std::vector<Ranks> halves;
    std::vector<int> first(n);
    for (std::size_t g = 0; g < n; ++g) {
      first[g] = static_cast<int>(halves.size());
      const Ranks r = groups_[g];
      if (r.end - r.begin == 1) {
        halves.push_back(r);
        continue;
      }
      const int middle = r.begin + (r.end - r.begin) / 2;
      halves.push_back({r.begin, middle});
      halves.push_back({middle, r.end});
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto g = static_cast<std::size_t>(group_[i]);
      const bool splits = groups_[g].end - groups_[g].begin > 1;
      group_[i] = first[g] + (splits && points_[i][cuts_[g].axis] >= cuts_[g].high ? 1 : 0);
    }
    groups_ = std::move(halves);
  }

  static int bin(const Cut& cut, double x) {
    return std::clamp(static_cast<int>((x - cut.low) / (cut.high - cut.low) * kBins), 0, kBins - 1);
  }

  /// Narrows each cut to the bin in which the wanted number is reached.
  void refine() {
    std::vector<std::int64_t> counts(cuts_.size() * kBins, 0);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto g = static_cast<std::size_t>(group_[i]);
      const double x = points_[i][cuts_[g].axis];
      if (x < cuts_[g].low || x >= cuts_[g].high) continue;
      ++counts[g * kBins + static_cast<std::size_t>(bin(cuts_[g], x))];
    }
    counts = all_reduce(comm_, std::move(counts), MPI_SUM);
    for (std::size_t g = 0; g < cuts_.size(); ++g) {
      Cut& cut = cuts_[g];
      if (!(cut.high > cut.low)) continue;
      int b = 0;
      while (b < kBins - 1 && cut.below + counts[g * kBins + static_cast<std::size_t>(b)] < cut.wanted) {
        cut.below += counts[g * kBins + static_cast<std::size_t>(b++)];
      }
      const double width = (cut.high - cut.low) / kBins;
      const double low = cut.low;
      cut.low = low + b * width;
      if (b < kBins - 1) cut.high = low + (b + 1) * width;
    }
  }

  MPI_Comm comm_;
  const std::vector<Point3>& points_;
  std::vector<int> group_;
  std::vector<Ranks> groups_;
  std::vector<Cut> cuts_;
};

/// In increasing order.
std::vector<Id> unique_vertices(const std::vector<Cell>& cells) {
  std::vector<Id> ids;
  IdMap found;
  for (const Cell& c : cells) {
    for (const Id v : c.v) {
      if (found.add(v)) ids.push_back(v);
    }
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

/// The ranks that have a vertex, of those at home here.
class Holders {
 public:
  Holders(const Star& star, const Blocks& blocks, int rank) : first_(blocks.begin(rank)) {
    begin_.push_back(0);
    for (const int n : star.copies()) begin_.push_back(begin_.back() + static_cast<std::size_t>(n));
    ranks_.resize(begin_.back());
    std::vector<std::size_t> next = begin_;
    star.for_each_copy([&](int holder, std::size_t place) { ranks_[next[place]++] = holder; });
  }
  template <class F>
  void for_each(Id id, F f) const {
    const auto place = static_cast<std::size_t>(id - first_);
    for (std::size_t i = begin_[place]; i < begin_[place + 1]; ++i) f(ranks_[i]);
  }

 private:
  Id first_;
  std::vector<std::size_t> begin_;
  std::vector<int> ranks_;
};

/// Hands listed triangles and edges to the parts that have one of their vertices.
class Offers {
 public:
  Offers(MPI_Comm comm, const Part& part, const Blocks& blocks, const Star& vertices)
      : comm_(comm),
        part_(part),
        local_(part.vertex_id),
        blocks_(blocks),
        on_surface_(on_surface(part.mesh)),
        holders_(vertices, blocks, rank_of(comm)),
        surface_holders_(Star(comm, surface_ids(), blocks), blocks, rank_of(comm)) {}

  /// Those that belong to the part; `what` and `of` for the message about constraining ones that belong to none.
  template <std::size_t N>
  std::vector<Element<N>> placed(const std::vector<Element<N>>& elements, const char* what, const char* of) const {
    std::vector<int> to;
    to.reserve(elements.size());
    for (const Element<N>& e : elements) to.push_back(blocks_.home(e.v[0]));
    const std::vector<Element<N>> here = Route(comm_, to).send(elements);
    std::vector<Element<N>> offers;
    std::vector<std::size_t> which;
    to.clear();
    for (std::size_t i = 0; i < here.size(); ++i) {
      (constrains(here[i]) || N < 3 ? holders_ : surface_holders_).for_each(here[i].v[0], [&](int rank) {
        offers.push_back(here[i]);
        which.push_back(i);
        to.push_back(rank);
      });
    }
    const Route route(comm_, to);
    std::vector<Element<N>> kept;
    const std::vector<std::uint8_t> taken = route.answer(accept(route.send(offers), kept));
    std::vector<std::uint8_t> placed(here.size(), 0);
    for (std::size_t i = 0; i < taken.size(); ++i) placed[which[i]] |= taken[i];
    std::vector<Element<N>> lost;
    for (std::size_t i = 0; i < here.size(); ++i) {
      if (placed[i] == 0 && constrains(here[i])) lost.push_back(here[i]);
    }
    refuse(lost, what, of);
    return kept;
  }

 private:
  std::vector<Id> surface_ids() const {
    std::vector<Id> ids;
    for (std::size_t v = 0; v < on_surface_.size(); ++v) {
      if (on_surface_[v] != 0) ids.push_back(part_.vertex_id[v]);
    }
    return ids;
  }

  template <std::size_t N>
  static bool constrains(const Element<N>& e) {
    return e.tag != 0 || e.flags != 0;
  }

  /// Those of this part's tetrahedra: told by 1, and appended to `kept`. A triangle inside a region that constrains
  /// nothing is dropped, as optimize() would.
  template <std::size_t N>
  std::vector<std::uint8_t> accept(const std::vector<Element<N>>& offered, std::vector<Element<N>>& kept) const {
    std::vector<std::array<Index, N>> list;
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < offered.size(); ++i) {
      const bool anywhere = N < 3 || constrains(offered[i]);
      std::array<Index, N> v;
      bool possible = true;
      for (std::size_t k = 0; k < N && possible; ++k) {
        v[k] = local_[offered[i].v[k]];
        possible = v[k] >= 0 && (anywhere || on_surface_[static_cast<std::size_t>(v[k])] != 0);
      }
      if (!possible) continue;
      list.push_back(v);
      which.push_back(i);
    }
    const auto is_in = are_in(list, part_.mesh.tets, part_.mesh.points.size());
    std::vector<std::uint8_t> taken(offered.size(), 0);
    for (std::size_t i = 0; i < which.size(); ++i) {
      if (is_in[i] == 0) continue;
      taken[which[i]] = 1;
      kept.push_back(offered[which[i]]);
    }
    return taken;
  }

  template <std::size_t N>
  void refuse(const std::vector<Element<N>>& lost, const char* what, const char* of) const {
    const auto count = all_reduce(comm_, static_cast<std::int64_t>(lost.size()), MPI_SUM);
    if (count == 0) return;
    Id first = std::numeric_limits<Id>::max();
    for (const Element<N>& e : lost) first = std::min(first, e.id);
    first = all_reduce(comm_, first, MPI_MIN);
    throw MeshError(std::to_string(count) + " listed " + what + " with a tag or required are not " + of +
                    " of any tetrahedron (first, counted from 0: " + std::to_string(first) +
                    "); remove them, or optimise the mesh on one machine");
  }

  MPI_Comm comm_;
  const Part& part_;
  IdMap local_;
  Blocks blocks_;
  std::vector<std::uint8_t> on_surface_;
  Holders holders_, surface_holders_;
};

/// Sends entities home and keeps one of each.
template <class T>
std::vector<T> at_home(MPI_Comm comm, const std::vector<T>& items, Id total) {
  const Blocks blocks(total, size_of(comm));
  std::vector<int> to;
  to.reserve(items.size());
  for (const T& item : items) to.push_back(blocks.home(item.id));
  std::vector<T> here = Route(comm, to).send(items);
  std::stable_sort(here.begin(), here.end(), [](const T& a, const T& b) { return a.id < b.id; });
  here.erase(std::unique(here.begin(), here.end(), [](const T& a, const T& b) { return a.id == b.id; }), here.end());
  return here;
}

/// Numbers entities without gaps.
template <class T>
void number(MPI_Comm comm, std::vector<T>& items, Id& total) {
  Id next = sum_before(comm, static_cast<Id>(items.size()));
  total = all_reduce(comm, static_cast<Id>(items.size()), MPI_SUM);
  for (T& item : items) item.id = next++;
}

template <std::size_t N>
void check_vertices(const std::vector<Element<N>>& elements, Id vertices, const char* what) {
  for (const Element<N>& e : elements) {
    for (const Id v : e.v) {
      if (v >= 0 && v < vertices) continue;
      throw MeshError(std::string(what) + " " + std::to_string(e.id) + " has vertex " + std::to_string(v) +
                      " (both counted from 0), but there are " + std::to_string(vertices) + " vertices");
    }
  }
}

/// What must be right for the pieces to find each other; all else validate() sees in the parts.
void check(const Pieces& pieces, Id vertices) {
  for (const Vertex& v : pieces.vertices) {
    if (std::all_of(v.x.begin(), v.x.end(), [](double x) { return std::isfinite(x); })) continue;
    throw MeshError("vertex " + std::to_string(v.id) + " (counted from 0) has a coordinate that is not finite");
  }
  check_vertices(pieces.cells, vertices, "tetrahedron");
  check_vertices(pieces.sides, vertices, "triangle");
  check_vertices(pieces.lines, vertices, "edge");
}

}  // namespace

Part distribute(MPI_Comm comm, Pieces pieces, const Totals& totals) {
  together(comm, [&] { check(pieces, totals.vertices); });
  const Blocks blocks(totals.vertices, size_of(comm));
  const std::vector<Vertex> home = at_home(comm, pieces.vertices, totals.vertices);
  pieces.vertices = {};
  const Blocks cell_blocks(totals.cells, size_of(comm));
  std::vector<int> to;
  to.reserve(pieces.cells.size());
  for (const Cell& c : pieces.cells) to.push_back(cell_blocks.home(c.id));
  std::vector<Cell> cells = Route(comm, to).send(pieces.cells);
  pieces.cells = {};
  {
    const std::vector<Id> ids = unique_vertices(cells);
    const std::vector<Vertex> vertices = Star(comm, ids, blocks).fetch(home);
    const IdMap local(ids);
    std::vector<Point3> centres;
    centres.reserve(cells.size());
    for (const Cell& c : cells) {
      Point3 centre{};
      for (const Id v : c.v) {
        const Point3& x = vertices[static_cast<std::size_t>(local[v])].x;
        for (std::size_t k = 0; k < 3; ++k) centre[k] += 0.25 * x[k];
      }
      centres.push_back(centre);
    }
    to = Bisection(comm, centres).run();
  }
  Pieces mine;
  mine.cells = Route(comm, to).send(cells);
  cells = {};
  const Star vertices(comm, unique_vertices(mine.cells), blocks);
  mine.vertices = vertices.fetch(home);
  // Vertices of no tetrahedron stay at home.
  const std::vector<int> copies = vertices.copies();
  for (std::size_t i = 0; i < home.size(); ++i) {
    if (copies[i] == 0) mine.vertices.push_back(home[i]);
  }
  Part part = assemble(std::move(mine));
  std::vector<Side> sides;
  std::vector<Line> lines;
  {
    const Offers offers(comm, part, blocks, vertices);
    sides = offers.placed(pieces.sides, "triangles", "a face");
    lines = offers.placed(pieces.lines, "edges", "an edge");
  }
  add_lists(part, IdMap(part.vertex_id), std::move(sides), std::move(lines));
  return part;
}

Pieces send(MPI_Comm comm, Addressed a) {
  Pieces result;
  result.vertices = Route(comm, a.vertex_to).send(a.pieces.vertices);
  a.pieces.vertices = {};
  result.cells = Route(comm, a.cell_to).send(a.pieces.cells);
  a.pieces.cells = {};
  result.sides = Route(comm, a.side_to).send(a.pieces.sides);
  result.lines = Route(comm, a.line_to).send(a.pieces.lines);
  return result;
}

void close_gaps(MPI_Comm comm, Part& part, Totals& totals) {
  const Star star(comm, part.vertex_id, Blocks(totals.vertices, size_of(comm)));
  const std::vector<int> copies = star.copies();
  const auto used = static_cast<Id>(copies.size()) - std::count(copies.begin(), copies.end(), 0);
  Id next = sum_before(comm, used);
  std::vector<Id> ids;
  ids.reserve(copies.size());
  for (const int n : copies) ids.push_back(n > 0 ? next++ : -1);
  part.vertex_id = star.fetch(ids);
  totals.vertices = all_reduce(comm, used, MPI_SUM);
}

std::vector<Vertex> vertices_at_home(MPI_Comm comm, const std::vector<Vertex>& vertices, const Totals& totals) {
  return at_home(comm, vertices, totals.vertices);
}

Pieces collect(MPI_Comm comm, Part part, Totals& totals) {
  close_gaps(comm, part, totals);
  Pieces pieces = address(part, std::vector<int>(part.mesh.tets.size(), 0), 0).pieces;
  part = {};
  pieces.vertices = at_home(comm, pieces.vertices, totals.vertices);
  pieces.sides = at_home(comm, pieces.sides, totals.sides);
  pieces.lines = at_home(comm, pieces.lines, totals.lines);
  number(comm, pieces.cells, totals.cells);
  number(comm, pieces.sides, totals.sides);
  number(comm, pieces.lines, totals.lines);
  return pieces;
}

namespace {

std::vector<std::size_t> maybe_shared(const Part& part) {
  std::vector<std::size_t> vertices;
  for (std::size_t v = 0; v < part.vertex_flags.size(); ++v) {
    if ((part.vertex_flags[v] & kShared) != 0) vertices.push_back(v);
  }
  return vertices;
}

template <class T>
std::vector<T> values_of(const std::vector<std::size_t>& vertices, const std::vector<T>& values) {
  std::vector<T> result;
  result.reserve(vertices.size());
  for (const std::size_t v : vertices) result.push_back(values[v]);
  return result;
}

/// A vertex, and another rank that has it.
struct Copy {
  Id id;
  int rank;
};

void join(Addressed& all, const Addressed& more) {
  const auto add = [](auto& list, const auto& items) { list.insert(list.end(), items.begin(), items.end()); };
  add(all.pieces.vertices, more.pieces.vertices);
  add(all.pieces.cells, more.pieces.cells);
  add(all.pieces.sides, more.pieces.sides);
  add(all.pieces.lines, more.pieces.lines);
  add(all.vertex_to, more.vertex_to);
  add(all.cell_to, more.cell_to);
  add(all.side_to, more.side_to);
  add(all.line_to, more.line_to);
}

/// The tetrahedra around marked vertices, each addressed to one rank.
Addressed around(const Part& part, const std::vector<std::uint8_t>& vertices, int rank) {
  const Part some = copied(part, tets_around(part.mesh, vertices));
  return address(some, std::vector<int>(some.mesh.tets.size(), rank), rank);
}

}  // namespace

Part shell_of(MPI_Comm comm, const Part& part, const Totals& totals, const std::vector<int>& frozen_regions) {
  // Which ranks have a vertex is known at its home.
  const Blocks blocks(totals.vertices, size_of(comm));
  const std::vector<std::size_t> shared = maybe_shared(part);
  const Star star(comm, values_of(shared, part.vertex_id), blocks);
  const Holders holders(star, blocks, rank_of(comm));
  std::vector<Copy> copies;
  std::vector<int> to;
  for (Id id = blocks.begin(rank_of(comm)); id < blocks.begin(rank_of(comm) + 1); ++id) {
    holders.for_each(id, [&](int one) {
      holders.for_each(id, [&](int other) {
        if (one == other) return;
        copies.push_back({id, other});
        to.push_back(one);
      });
    });
  }
  copies = Route(comm, to).send(copies);

  Addressed all;
  Part shell;
  together(comm, [&] {
    std::vector<std::uint8_t> vertices(part.vertex_id.size(), 0);
    for (const std::size_t v : shared) vertices[v] = 1;
    const Part rim = copied(part, tets_around(part.mesh, vertices));
    const IdMap in_rim(rim.vertex_id);
    std::map<int, std::vector<std::uint8_t>> shared_with;
    for (const Copy& c : copies) {
      std::vector<std::uint8_t>& some = shared_with[c.rank];
      some.resize(rim.vertex_id.size(), 0);
      some[static_cast<std::size_t>(in_rim[c.id])] = 1;
    }
    for (const auto& [rank, some] : shared_with) join(all, around(rim, some, rank));
    shell = copied(part, tets_around(part.mesh, held_vertices(part.mesh, frozen_regions)));
  });
  Pieces arrived = send(comm, std::move(all));
  together(comm, [&] { absorb(shell, assemble(std::move(arrived))); });
  return shell;
}

Shared::Shared(MPI_Comm comm, const Part& part, const Totals& totals)
    : vertices_(maybe_shared(part)),
      star_(comm, values_of(vertices_, part.vertex_id), Blocks(totals.vertices, size_of(comm))) {}

void Shared::mark(Part& part) const {
  const std::vector<int> copies = star_.fetch(star_.copies());
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    if (copies[i] < 2) part.vertex_flags[vertices_[i]] &= static_cast<std::uint8_t>(~kShared);
  }
}

void Shared::least(std::vector<int>& values) const {
  const std::vector<int> least = star_.least(values_of(vertices_, values));
  for (std::size_t i = 0; i < vertices_.size(); ++i) values[vertices_[i]] = least[i];
}

}  // namespace tetune::mpi
