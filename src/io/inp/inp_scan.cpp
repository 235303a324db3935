// SPDX-License-Identifier: Apache-2.0
// One pass over the text of an .inp file and the files that it includes.
#include "io/inp/inp_scan.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <optional>

#include "io/inp/inp_card_kind.hpp"
#include "io/inp/inp_cursor.hpp"
#include "io/inp/inp_data.hpp"
#include "io/inp/inp_include.hpp"
#include "system/path.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

class InpScanner {
 public:
  explicit InpScanner(const std::string& path) : main_path_(path), cursor_(path, {}) {}

  InpScan scan(std::string bytes) {
    const std::size_t line_end = bytes.find('\n');
    const bool has_return = line_end != std::string::npos && line_end > 0 && bytes[line_end - 1] == '\r';
    model_.newline = has_return ? "\r\n" : "\n";
    read_file(main_path_, std::move(bytes));
    if (!has_keyword_) {
      refuse_ansys_deck(main_path_, model_.files.front());
      throw FileError(main_path_ + ": this is not an Abaqus or CalculiX deck: it has no keyword lines (*...)");
    }
    return std::move(scan_);
  }

 private:
  /// `ignored`: text that does not concern the mesh.
  enum class Mode { text, ignored, nodes, tets, triangles, others, set, faces, condition };

  void read_file(const std::string& path, std::string bytes) {
    if (bytes.find('\0') != std::string::npos) throw FileError(path + ": this is a binary file, and no deck in text");
    if (!stack_.empty() && !bytes.empty() && bytes.back() != '\n') bytes += model_.newline;
    stack_.push_back(path);
    model_.files.push_back(std::move(bytes));
    scan_.paths.push_back(path);
    cursor_ = InpCursor(path, model_.files.back());
    const char* const begin = cursor_.at();
    if (cursor_.take_byte_order_mark()) add_piece(InpPiece::Kind::text, begin);
    while (!cursor_.at_end()) {
      const InpCursor::Line kind = cursor_.line_kind();
      if (kind == InpCursor::Line::keyword) {
        read_keyword();
      } else if (kind == InpCursor::Line::data) {
        read_data();
      } else {
        const char* const start = cursor_.at();
        cursor_.take_line();
        add_piece(InpPiece::Kind::text, start);
      }
    }
    stack_.pop_back();
  }

  /// Adds the text from `start` on, which defines the nodes, tetrahedra or triangles from `first` on.
  void add_piece(InpPiece::Kind kind, const char* start, std::size_t card = 0, std::size_t first = 0,
                 std::size_t last = 0) {
    const std::string_view text(start, to_size_t(cursor_.at() - start));
    if (!model_.pieces.empty()) {
      InpPiece& before = model_.pieces.back();
      const bool is_next = before.text.data() + before.text.size() == text.data();
      if (is_next && before.kind == kind && before.card == to_index(card)) {
        before.text = {before.text.data(), before.text.size() + text.size()};
        before.last = to_index(last);
        return;
      }
    }
    model_.pieces.push_back({kind, text, to_index(card), to_index(first), to_index(last)});
  }

  void read_keyword() {
    has_keyword_ = true;
    const char* const start = cursor_.at();
    const InpPlace where = cursor_.place();
    const InpKeyword keyword = cursor_.take_keyword();
    if (keyword.name == "INCLUDE") return include(keyword, where);
    if (enter_part(keyword, where) || is_ignored(keyword)) {
      mode_ = Mode::ignored;
      return add_piece(InpPiece::Kind::text, start);
    }
    mode_ = Mode::text;
    kind_ = inp_card_kind(keyword);
    if (kind_.refusal != nullptr) where.fail("*" + keyword.name + ": " + kind_.refusal);
    for (const char* parameter : {"INPUT", "FILE"}) {
      const bool defines =
          keyword.name == "NODE" || keyword.name == "ELEMENT" || keyword.name == "NSET" || keyword.name == "ELSET";
      if (defines && keyword.has(parameter)) where.fail("*" + keyword.name + " reads another file; use *INCLUDE");
    }
    if (!start_card(keyword, start, where)) {
      add_piece(InpPiece::Kind::text, start);
      for (const auto& [key, value] : keyword.parameters) note_inp_parameter(key, value, kind_, scan_);
      if (keyword.name == "STEP") ++step_;
      if (kind_.condition != InpCardKind::Condition::none) start_condition(keyword, head_from(start));
    }
  }

  /// Follows the keywords that begin and end parts, instances and the assembly. Returns false for others.
  bool enter_part(const InpKeyword& keyword, const InpPlace& where) {
    const std::string& name = keyword.name;
    const bool begins = name == "PART" || name == "INSTANCE";
    if (begins || name == "ASSEMBLY") {
      if (!parts_) {
        if (!model_.node_labels.empty()) where.fail("nodes precede the parts; move them to a part");
        parts_ = find_inp_parts(main_path_, model_.files.front());
        model_.references = InpReferences(parts_->instance);
      }
      const std::string* own = keyword.find("NAME");
      is_in_mesh_ = begins && own != nullptr &&
                    (name == "PART" ? inp_name(*own) == parts_->part
                                    : parts_->part.empty() && model_.references.is_instance(*own));
      is_in_other_ = begins && !is_in_mesh_;
    } else if (name == "ENDPART" || name == "ENDINSTANCE") {
      is_in_mesh_ = is_in_other_ = false;
    } else if (name != "ENDASSEMBLY") {
      return false;
    }
    scan_.in_assembly = parts_ && !is_in_mesh_ && !model_.references.written_prefix().empty();
    return true;
  }
  /// Whether a card is one of another part, or defines nodes, elements or sets of the assembly itself or of other
  /// instances. The names in such sets count as mentioned.
  bool is_ignored(const InpKeyword& keyword) {
    if (is_in_other_) return true;
    if (!scan_.in_assembly) return false;
    const std::string& name = keyword.name;
    if (name == "NODE" || name == "ELEMENT") return true;
    const std::string* instance = keyword.find("INSTANCE");
    const bool is_of_mesh = instance != nullptr && model_.references.is_instance(*instance);
    return (name == "NSET" || name == "ELSET") && !is_of_mesh;
  }

  /// Starts a card that tetune interprets; returns false for others.
  bool start_card(const InpKeyword& keyword, const char* start, const InpPlace& where) {
    if (keyword.name == "NODE") return start_nodes(keyword, start, where);
    if (keyword.name == "ELEMENT") return start_elements(keyword, start, where);
    if (keyword.name == "NSET" || keyword.name == "ELSET") return start_set(keyword, start, where);
    if (!kind_.has_faces) return false;
    mode_ = Mode::faces;
    InpFaceCard card;
    card.head = head_from(start);
    card.in_assembly = scan_.in_assembly;
    if (const std::string* name = keyword.find("NAME")) {
      card.name = scan_.full_name(*name);
      card.key = scan_.key(*name);
    }
    add_piece(InpPiece::Kind::faces, start, model_.face_cards.size());
    model_.face_cards.push_back(std::move(card));
    scan_.face_lines.emplace_back();
    scan_.face_places.push_back(where);
    return true;
  }

  void start_condition(const InpKeyword& keyword, std::string_view head) {
    mode_ = Mode::condition;
    std::string key = std::to_string(step_) + (scan_.in_assembly ? ",A," : ",") + keyword.name;
    for (const auto& [parameter, value] : keyword.parameters) key += "," + parameter + "=" + inp_name(value);
    const auto [at, is_new] = condition_of_.try_emplace(std::move(key), model_.conditions.size());
    condition_ = at->second;
    if (!is_new) return;
    head.remove_prefix(head.find('*') + 1);
    const std::string name(head.substr(0, head.find_first_of(",\r\n")));
    model_.conditions.push_back({name, kind_.condition, scan_.in_assembly, {}});
  }

  bool start_nodes(const InpKeyword& keyword, const char* start, const InpPlace& where) {
    const std::string* system = keyword.find("SYSTEM");
    if (system != nullptr && inp_name(*system) != "R") where.fail("nodes are in other than rectangular coordinates");
    mode_ = Mode::nodes;
    InpEntityCard card;
    card.first = to_index(model_.node_labels.size());
    if (const std::string* set = keyword.find("NSET")) card.set = node_set(*set, where);
    model_.node_cards.push_back(card);
    add_piece(InpPiece::Kind::text, start);
    return true;
  }

  bool start_elements(const InpKeyword& keyword, const char* start, const InpPlace& where) {
    const std::string* type = keyword.find("TYPE");
    if (type == nullptr) where.fail("*ELEMENT has no TYPE");
    type_ = inp_element_type(inp_name(*type));
    element_set_ = -1;
    if (const std::string* set = keyword.find("ELSET")) element_set_ = element_set(*set, where);
    const bool is_second_order = type_.role == InpElementType::Role::quadratic_tetrahedron;
    const bool is_tet = is_second_order || type_.role == InpElementType::Role::tetrahedron;
    if (is_tet && scan_.nodes_per_tet != 0 && scan_.nodes_per_tet != type_.nodes) {
      where.fail("the elements have type " + *type + ", and others before are tetrahedra of " +
                 std::to_string(scan_.nodes_per_tet) + " nodes; use one of both kinds in a deck");
    }
    if (is_tet) scan_.nodes_per_tet = type_.nodes;
    if (is_second_order) model_.is_second_order = true;
    mode_ = is_tet ? Mode::tets : type_.is_triangle() ? Mode::triangles : Mode::others;
    if (is_tet) model_.tet_cards.push_back({element_set_, to_index(model_.tet2element.size()), inp_name(*type)});
    if (mode_ == Mode::triangles)
      model_.triangle_cards.push_back({element_set_, to_index(model_.triangles.size()), inp_name(*type)});
    add_piece(InpPiece::Kind::text, start);
    return true;
  }

  bool start_set(const InpKeyword& keyword, const char* start, const InpPlace& where) {
    const bool of_nodes = keyword.name == "NSET";
    const std::string* name = keyword.find(keyword.name);
    if (name == nullptr) where.fail("*" + keyword.name + " has no name (" + keyword.name + "=...)");
    mode_ = Mode::set;
    InpSetCard card;
    card.set = of_nodes ? node_set(*name, where) : element_set(*name, where);
    card.head = head_from(start);
    card.in_assembly = scan_.in_assembly;
    card.generates = keyword.has("GENERATE");
    card.follows_elements = of_nodes && keyword.has("ELSET");
    InpSet& set = span_of(model_.sets)[card.set];
    if (keyword.has("UNSORTED")) set.is_held = true;
    const Index position = to_index(model_.set_cards.size());
    set.cards.push_back(position);
    InpSetLines lines;
    if (card.follows_elements) {
      lines.elements = *keyword.find("ELSET");
      scan_.mentioned.insert(scan_.key(lines.elements));
    }
    add_piece(InpPiece::Kind::set, start, to_size_t(position));
    model_.set_cards.push_back(std::move(card));
    scan_.set_lines.push_back(std::move(lines));
    scan_.set_places.push_back(where);
    return true;
  }

  /// The set of this name.
  Index node_set(const std::string& name, const InpPlace& where) { return set_of(/*of_nodes=*/true, name, where); }
  Index element_set(const std::string& name, const InpPlace& where) { return set_of(/*of_nodes=*/false, name, where); }
  Index set_of(bool of_nodes, const std::string& name, const InpPlace& where) {
    if (inp_name(name).empty()) where.fail("the name of a set is empty");
    const std::string key = scan_.key(name);
    const auto [at, is_new] = scan_.names.try_emplace({of_nodes, key}, to_index(model_.sets.size()));
    if (is_new) {
      InpSet set;
      set.name = scan_.full_name(name);
      set.key = key;
      set.parameters = std::string(of_nodes ? "*NSET, NSET=" : "*ELSET, ELSET=") + name;
      set.of_nodes = of_nodes;
      model_.sets.push_back(std::move(set));
    }
    return at->second;
  }

  void include(const InpKeyword& keyword, const InpPlace& where) {
    const std::string* input = keyword.find("INPUT");
    if (input == nullptr || input->empty()) where.fail("*INCLUDE has no INPUT");
    if (stack_.size() >= kMaxInpDepth || ++includes_ > kMaxInpIncludes) where.fail("there are too many included files");
    const std::string path = included_inp_path(main_path_, where.file, *input);
    if (!is_file(path)) where.fail("the included file " + path + " does not exist");
    if (std::find(stack_.begin(), stack_.end(), path) != stack_.end()) where.fail(path + " includes itself");
    const InpCursor here = cursor_;
    read_file(path, std::string(MappedFile(path).bytes()));
    cursor_ = here;
  }

  std::string_view head_from(const char* start) const { return {start, to_size_t(cursor_.at() - start)}; }

  void read_data() {
    const char* const start = cursor_.at();
    const std::size_t node = model_.node_labels.size();
    const std::size_t tet = model_.tet2element.size();
    switch (mode_) {
      case Mode::nodes:
        read_inp_nodes(cursor_, model_);
        return add_piece(InpPiece::Kind::nodes, start, model_.node_cards.size() - 1, node, model_.node_labels.size());
      case Mode::tets:
        read_inp_tets(cursor_, element_set_, scan_);
        return add_piece(InpPiece::Kind::tets, start, model_.tet_cards.size() - 1, tet, model_.tet2element.size());
      case Mode::triangles: {
        const std::size_t first = model_.triangles.size();
        const std::size_t card = model_.triangle_cards.size() - 1;
        read_inp_triangle(cursor_, type_, element_set_, scan_);
        return add_piece(InpPiece::Kind::triangles, start, card, first, first + 1);
      }
      case Mode::others:
        read_inp_other(cursor_, type_, element_set_, scan_);
        return add_piece(InpPiece::Kind::text, start);
      case Mode::set:
        read_inp_set_line(cursor_, kind_, scan_);
        return add_piece(InpPiece::Kind::set, start, model_.set_cards.size() - 1);
      case Mode::faces:
        read_inp_face_line(cursor_, kind_, scan_);
        return add_piece(InpPiece::Kind::faces, start, model_.face_cards.size() - 1);
      case Mode::condition:
        return read_condition_line();
      case Mode::ignored:
        note_ignored(cursor_.take_line());
        return add_piece(InpPiece::Kind::text, start);
      case Mode::text:
        note_inp_data(inp_fields(cursor_.take_line()), kind_, scan_);
        return add_piece(InpPiece::Kind::text, start);
    }
  }

  /// Sets of the assembly may list sets of the mesh by name.
  void note_ignored(std::string_view line) {
    if (!is_in_other_) note_inp_data(inp_fields(line), {}, scan_);
  }

  void read_condition_line() {
    const char* const start = cursor_.at();
    const std::string_view line = cursor_.take_line();
    const std::vector<std::string_view> fields = inp_fields(line);
    note_inp_data(fields, kind_, scan_);
    add_piece(InpPiece::Kind::condition, start, condition_);
    InpCondition& condition = model_.conditions[condition_];
    condition.lines.push_back({line});
    constexpr std::size_t kLongest = 8;  // fields of a line
    if (kind_.condition == InpCardKind::Condition::field && fields.size() >= kLongest) condition.may_continue = true;
    if (!fields.empty()) {
      condition.last_piece = to_index(model_.pieces.size() - 1);
    }
  }

  std::string main_path_;
  InpCursor cursor_;
  InpScan scan_;
  InpModel& model_ = scan_.model;
  std::vector<std::string> stack_;
  std::size_t includes_ = 0;
  bool has_keyword_ = false;

  Mode mode_ = Mode::text;
  InpCardKind kind_;
  InpElementType type_;
  Index element_set_ = -1;
  std::size_t step_ = 0, condition_ = 0;
  std::optional<InpParts> parts_;                    ///< of a deck of parts, from its first one on
  bool is_in_mesh_ = false;                          ///< in the part that has the mesh
  bool is_in_other_ = false;                         ///< in another part or instance
  std::map<std::string, std::size_t> condition_of_;  ///< by step and keyword line
};

}  // namespace

InpPlace InpScan::place_of(const char* at) const {
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const std::string& text = model.files[i];
    const char* const begin = text.data();
    if (std::less<>()(at, begin) || !std::less<>()(at, begin + text.size())) continue;
    return {paths[i], 1 + std::count(begin, at, '\n')};
  }
  return {paths.front(), 1};
}

const InpOther& InpScan::other(Index element) const {
  return *std::lower_bound(others.begin(), others.end(), element,
                           [](const InpOther& before, Index e) { return before.element < e; });
}

std::vector<Index> InpScan::find_held_elements() const {
  std::vector<Index> elements;
  for (const std::int64_t label : held_elements) {
    if (const Index element = model.element(label); element >= 0) elements.push_back(element);
  }
  sort_unique(elements);
  return elements;
}

void refuse_ansys_deck(const std::string& path, std::string_view text) {
  static constexpr std::array kCommands{"/PREP7", "/BATCH", "/COM",   "/TITLE", "/NOPR", "/FILNAME", "/CLEAR", "/UNITS",
                                        "*SET",   "N",      "NBLOCK", "EBLOCK", "ET",    "EN",       "MPTEMP"};
  static constexpr std::array kStarCommands{"*ABBR", "*ASK",    "*CFOPEN", "*CREATE", "*DEL",  "*DIM",   "*DO",
                                            "*ELSE", "*END",    "*ENDDO",  "*ENDIF",  "*GET",  "*IF",    "*MSG",
                                            "*SET",  "*STATUS", "*USE",    "*VFILL",  "*VGET", "*VREAD", "*VWRITE"};
  InpCursor cursor(path, text);
  cursor.take_byte_order_mark();
  bool has_keyword = false;  // after which N can be a set
  while (!cursor.at_end()) {
    const bool is_keyword = cursor.line_kind() == InpCursor::Line::keyword;
    const InpPlace where = cursor.place();
    const std::string_view line = cursor.take_line();
    const std::string first = inp_name(line.substr(0, line.find_first_of(", ")));
    const bool is_command = std::find(kCommands.begin(), kCommands.end(), first) != kCommands.end();
    if (!is_command && is_keyword &&
        std::find(kStarCommands.begin(), kStarCommands.end(), first) == kStarCommands.end())
      has_keyword = true;
    if (!is_command || (has_keyword && first.front() != '/' && first.front() != '*')) continue;
    where.fail("this is a deck of ANSYS (" + first +
               "), which tetune does not read; write the mesh with CDWRITE, and convert that file to .vtu, as with the "
               "Python package mapdl-archive");
  }
}

InpScan scan_inp(const std::string& path, std::string bytes) { return InpScanner(path).scan(std::move(bytes)); }

}  // namespace tetune
