// SPDX-License-Identifier: Apache-2.0
#include "distribute.hpp"

#include <cmath>
#include <limits>
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

std::vector<Id> unique_vertices(const std::vector<Cell>& cells) {
  std::vector<Id> ids;
  ids.reserve(4 * cells.size());
  for (const Cell& c : cells) ids.insert(ids.end(), c.v.begin(), c.v.end());
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  ids.shrink_to_fit();
  return ids;
}

/// The vertices at home, and who has them.
class Homes {
 public:
  Homes(MPI_Comm comm, std::vector<Vertex> vertices, const Blocks& blocks) : comm_(comm), blocks_(blocks) {
    std::vector<int> to;
    for (const Vertex& v : vertices) to.push_back(blocks.home(v.id));
    vertices_ = Route(comm, to).send(vertices);
    std::sort(vertices_.begin(), vertices_.end(), [](const Vertex& a, const Vertex& b) { return a.id < b.id; });
    holders_.resize(vertices_.size());
  }

  /// The vertices of these ids. With `hold`, this rank counts among the holders from now on.
  std::vector<Vertex> fetch(const std::vector<Id>& ids, bool hold) {
    std::vector<int> to;
    for (const Id id : ids) to.push_back(blocks_.home(id));
    const Route route(comm_, to);
    const std::vector<Id> asked = route.send(ids);
    const std::vector<int> senders = route.senders();
    std::vector<Vertex> answers;
    answers.reserve(asked.size());
    for (std::size_t i = 0; i < asked.size(); ++i) {
      answers.push_back(vertices_[place(asked[i])]);
      if (hold) holders_[place(asked[i])].push_back(senders[i]);
    }
    return route.answer(answers);
  }

  /// Hands each side or line to the holders of one of its vertices; `accept` says which of them belong to this rank.
  /// Returns the constraining ones that no rank accepted, as far as they are at home here.
  template <std::size_t N, class Accept>
  std::vector<Element<N>> offer(const std::vector<Element<N>>& elements, Accept accept) {
    std::vector<int> to;
    for (const Element<N>& e : elements) to.push_back(blocks_.home(e.v[0]));
    const std::vector<Element<N>> here = Route(comm_, to).send(elements);
    std::vector<Element<N>> offers;
    std::vector<std::size_t> which;
    to.clear();
    for (std::size_t i = 0; i < here.size(); ++i) {
      for (const int rank : holders_[place(here[i].v[0])]) {
        offers.push_back(here[i]);
        which.push_back(i);
        to.push_back(rank);
      }
    }
    const Route route(comm_, to);
    const std::vector<std::uint8_t> taken = route.answer(accept(route.send(offers)));
    std::vector<std::uint8_t> placed(here.size(), 0);
    for (std::size_t i = 0; i < taken.size(); ++i) placed[which[i]] |= taken[i];
    std::vector<Element<N>> lost;
    for (std::size_t i = 0; i < here.size(); ++i) {
      if (placed[i] == 0 && (here[i].tag != 0 || here[i].flags != 0)) lost.push_back(here[i]);
    }
    return lost;
  }

  std::vector<Vertex> without_holder() const {
    std::vector<Vertex> vertices;
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (holders_[i].empty()) vertices.push_back(vertices_[i]);
    }
    return vertices;
  }

 private:
  /// Ids of a block are there without gaps.
  std::size_t place(Id id) const { return static_cast<std::size_t>(id - vertices_.front().id); }

  MPI_Comm comm_;
  Blocks blocks_;
  std::vector<Vertex> vertices_;
  std::vector<std::vector<int>> holders_;
};

template <std::size_t N>
void refuse_lost(MPI_Comm comm, const std::vector<Element<N>>& lost, const char* what, const char* of) {
  const auto count = all_reduce(comm, static_cast<std::int64_t>(lost.size()), MPI_SUM);
  if (count == 0) return;
  Id first = std::numeric_limits<Id>::max();
  for (const Element<N>& e : lost) first = std::min(first, e.id);
  first = all_reduce(comm, first, MPI_MIN);
  throw MeshError(std::to_string(count) + " listed " + what + " with a tag or required are not " + of +
                  " of any tetrahedron (first, counted from 0: " + std::to_string(first) +
                  "); remove them, or optimise the mesh on one machine");
}

/// The sides or lines among those offered that are of this part's tetrahedra: told by 1, and appended to `kept`.
template <std::size_t N>
std::vector<std::uint8_t> accept(const std::vector<Element<N>>& offered, const IdMap& local, const Part& part,
                                 std::vector<Element<N>>& kept) {
  std::vector<std::array<Index, N>> list;
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < offered.size(); ++i) {
    std::array<Index, N> v;
    for (std::size_t k = 0; k < N; ++k) v[k] = local[offered[i].v[k]];
    if (std::any_of(v.begin(), v.end(), [](Index j) { return j < 0; })) continue;
    list.push_back(v);
    which.push_back(i);
  }
  const auto is_in = are_in(list, part.mesh.tets, part.mesh.points.size());
  std::vector<std::uint8_t> taken(offered.size(), 0);
  for (std::size_t i = 0; i < which.size(); ++i) {
    if (is_in[i] == 0) continue;
    taken[which[i]] = 1;
    kept.push_back(offered[which[i]]);
  }
  return taken;
}

/// Sends entities home and keeps one of each.
template <class T>
std::vector<T> at_home(MPI_Comm comm, const std::vector<T>& items, Id total) {
  const Blocks blocks(total, size_of(comm));
  std::vector<int> to;
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
  const int ranks = size_of(comm);
  Homes homes(comm, std::move(pieces.vertices), Blocks(totals.vertices, ranks));
  const Blocks cell_blocks(totals.cells, ranks);
  std::vector<int> to;
  for (const Cell& c : pieces.cells) to.push_back(cell_blocks.home(c.id));
  std::vector<Cell> cells = Route(comm, to).send(pieces.cells);
  pieces.cells = {};
  {
    const std::vector<Id> ids = unique_vertices(cells);
    const std::vector<Vertex> vertices = homes.fetch(ids, false);
    const IdMap local(ids);
    std::vector<Point3> centres;
    for (const Cell& c : cells) {
      Point3 centre{};
      for (const Id v : c.v) {
        for (std::size_t k = 0; k < 3; ++k) centre[k] += 0.25 * vertices[static_cast<std::size_t>(local[v])].x[k];
      }
      centres.push_back(centre);
    }
    to = Bisection(comm, centres).run();
  }
  Pieces mine;
  mine.cells = Route(comm, to).send(cells);
  cells = {};
  mine.vertices = homes.fetch(unique_vertices(mine.cells), true);
  // Vertices of no tetrahedron stay at home.
  for (const Vertex& v : homes.without_holder()) mine.vertices.push_back(v);
  Part part = assemble(std::move(mine));
  const IdMap local(part.vertex_id);
  std::vector<Side> sides;
  std::vector<Line> lines;
  refuse_lost(comm, homes.offer(pieces.sides, [&](const auto& o) { return accept(o, local, part, sides); }),
              "triangles", "a face");
  refuse_lost(comm, homes.offer(pieces.lines, [&](const auto& o) { return accept(o, local, part, lines); }), "edges",
              "an edge");
  add_lists(part, local, std::move(sides), std::move(lines));
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
  const Blocks blocks(totals.vertices, size_of(comm));
  std::vector<int> to;
  for (const Id id : part.vertex_id) to.push_back(blocks.home(id));
  const Route route(comm, to);
  std::vector<Id> answers = route.send(part.vertex_id);
  std::vector<Id> different = answers;
  std::sort(different.begin(), different.end());
  different.erase(std::unique(different.begin(), different.end()), different.end());
  const Id first = sum_before(comm, static_cast<Id>(different.size()));
  for (Id& id : answers) {
    id = first + (std::lower_bound(different.begin(), different.end(), id) - different.begin());
  }
  part.vertex_id = route.answer(answers);
  totals.vertices = all_reduce(comm, static_cast<Id>(different.size()), MPI_SUM);
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

Shared::Shared(MPI_Comm comm, const Part& part)
    : route_(comm, [&] {
        std::vector<int> to;
        for (const Id id : part.vertex_id) to.push_back(static_cast<int>(id % size_of(comm)));
        return to;
      }()) {
  const std::vector<Id> ids = route_.send(part.vertex_id);
  std::vector<Id> different = ids;
  std::sort(different.begin(), different.end());
  different.erase(std::unique(different.begin(), different.end()), different.end());
  slots_ = different.size();
  const IdMap local(different);
  std::vector<int> holders(slots_, 0);
  for (const Id id : ids) {
    slot_.push_back(static_cast<std::size_t>(local[id]));
    ++holders[slot_.back()];
  }
  std::vector<std::uint8_t> answers;
  for (const std::size_t s : slot_) answers.push_back(holders[s] > 1 ? 1 : 0);
  shared_ = route_.answer(answers);
}

void Shared::least(std::vector<int>& values) const {
  const std::vector<int> received = route_.send(values);
  std::vector<int> least(slots_, std::numeric_limits<int>::max());
  for (std::size_t i = 0; i < received.size(); ++i) least[slot_[i]] = std::min(least[slot_[i]], received[i]);
  std::vector<int> answers;
  answers.reserve(received.size());
  for (const std::size_t s : slot_) answers.push_back(least[s]);
  values = route_.answer(answers);
}

}  // namespace tetune::mpi
