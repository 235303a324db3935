// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/function_parser.hpp"

namespace tetune::ptxsim {
namespace {

/// Moves the end behind a variable; returns where the variable is.
u32 place(u32& end, u32 bytes, u32 alignment) {
  const u32 begin = aligned(end, alignment);
  end = begin + bytes;
  return begin;
}

/// Of "setp.lt.f64": the operation and the modifiers.
Statement split(std::string_view text) {
  Statement s;
  std::size_t end = text.find('.');
  s.operation = text.substr(0, end);
  while (end != std::string_view::npos) {
    const std::size_t begin = end + 1;
    end = text.find('.', begin);
    s.modifiers.push_back(text.substr(begin, end == std::string_view::npos ? end : end - begin));
  }
  return s;
}

constexpr u32 kFrameAlignment = 8;

}  // namespace

Variable parse_variable(Tokens& tokens) {
  Variable v;
  for (std::string_view t = tokens.take();; t = tokens.take()) {
    if (t == ".align") {
      v.alignment = static_cast<u32>(tokens.take_number());
    } else if (t[0] != '.') {
      v.name = t;
      break;
    } else if (t == ".pred") {
      v.element_bytes = 1;
    } else if (const Type type = type_of(t.substr(1)); type.bits != 0) {
      v.element_bytes = type.bits / 8;
    }
  }
  v.bytes = v.element_bytes;
  while (tokens.accept("[")) {
    v.bytes *= tokens.peek() == "]" ? 0 : static_cast<u32>(tokens.take_number());
    tokens.expect("]");
  }
  v.alignment = std::max(v.alignment, v.element_bytes);
  return v;
}

void FunctionParser::parse(bool is_kernel) {
  std::vector<Variable> parameters;
  std::vector<Variable> results;
  if (!is_kernel && tokens_.peek() == "(") results = parse_parameters();
  function_ = &module_.function(tokens_.take());
  function_->is_kernel = is_kernel;
  if (tokens_.peek() == "(") parameters = parse_parameters();
  parse_attributes();
  if (tokens_.accept(";")) return;  // a declaration
  function_->is_defined = true;
  function_->begin = static_cast<u32>(module_.code.size());
  scopes_.assign(1, {});
  place_parameters(parameters, results);
  parse_body();
  Instruction end;
  end.execute = execute_return;
  end.is_control = true;
  end.kind = Kind::branch;
  end.function = function_;
  append(end);
  resolve_branches();
}

std::vector<Variable> FunctionParser::parse_parameters() {
  std::vector<Variable> all;
  tokens_.expect("(");
  while (!tokens_.accept(")")) {
    if (tokens_.accept(",")) continue;
    tokens_.expect(".param");
    all.push_back(parse_variable(tokens_));
  }
  return all;
}

void FunctionParser::parse_attributes() {
  while (tokens_.peek() != "{" && tokens_.peek() != ";") {
    const std::string_view attribute = tokens_.take();
    if (attribute != ".maxntid" && attribute != ".reqntid") continue;
    u64 threads = tokens_.take_number();
    while (tokens_.accept(",")) threads *= tokens_.take_number();
    function_->max_threads = static_cast<u32>(threads);
  }
}

void FunctionParser::place_parameters(const std::vector<Variable>& parameters, const std::vector<Variable>& results) {
  for (const Variable& v : parameters) {
    if (function_->is_kernel) {
      const u32 offset = place(function_->parameter_bytes, v.bytes, v.alignment);
      kernel_parameters_[v.name] = offset;
      function_->parameters.push_back({offset, v.bytes});
    } else {
      function_->parameters.push_back(place_in_frame(v));
    }
  }
  for (const Variable& v : results) function_->results.push_back(place_in_frame(v));
}

Slot FunctionParser::place_in_frame(const Variable& v) {
  const Slot slot{place(function_->frame_bytes, v.bytes, std::max(v.alignment, kFrameAlignment)), v.bytes};
  scopes_.back().variables[v.name] = slot;
  return slot;
}

void FunctionParser::parse_body() {
  tokens_.expect("{");
  const std::size_t outside = scopes_.size() - 1;
  while (scopes_.size() > outside) {
    if (tokens_.accept("{")) {
      scopes_.emplace_back();
    } else if (tokens_.accept("}")) {
      scopes_.pop_back();
    } else if (tokens_.accept(".reg")) {
      parse_registers();
    } else if (tokens_.accept(".param") || tokens_.accept(".local")) {
      parse_frame_variable();
    } else if (tokens_.accept(".shared")) {
      parse_shared_variable();
    } else if (tokens_.accept(".loc")) {
      parse_location();
    } else if (tokens_.accept(".pragma")) {
      tokens_.skip_behind(";");
    } else if (tokens_.peek(1) == ":") {
      labels_[tokens_.take()] = static_cast<u32>(module_.code.size());
      tokens_.expect(":");
    } else if (!tokens_.accept(";")) {
      parse_instruction();
    }
  }
}

void FunctionParser::parse_registers() {
  tokens_.take();  // the type
  do {
    const std::string_view name = tokens_.take();
    if (tokens_.accept("<")) {
      const auto count = static_cast<u32>(tokens_.take_number());
      tokens_.expect(">");
      scopes_.back().families.push_back({name, function_->registers, count});
      function_->registers += count;
    } else {
      scopes_.back().registers[name] = function_->registers++;
    }
  } while (tokens_.accept(","));
  tokens_.expect(";");
}

void FunctionParser::parse_frame_variable() {
  place_in_frame(parse_variable(tokens_));
  tokens_.expect(";");
}

void FunctionParser::parse_shared_variable() {
  const Variable v = parse_variable(tokens_);
  tokens_.expect(";");
  shared_[v.name] = place(function_->shared_bytes, v.bytes, v.alignment);
}

void FunctionParser::parse_location() {
  file_ = static_cast<u32>(tokens_.take_number());
  line_ = static_cast<u32>(tokens_.take_number());
  tokens_.take_number();  // the column
  // ", function_name label, inlined_at file line column"
  if (tokens_.peek() == ",") tokens_.skip_line();
}

void FunctionParser::parse_instruction() {
  Instruction i;
  i.function = function_;
  i.ptx_line = tokens_.line();
  i.file = file_;
  i.line = line_;
  if (tokens_.accept("@")) {
    i.guard_negated = tokens_.accept("!");
    i.guard = find_register(tokens_.take());
    if (i.guard == kNoRow) tokens_.fail("no such predicate");
  }
  Statement s = split(tokens_.take());
  if (s.operation == "call") {
    parse_call(i);
    return;
  }
  while (!tokens_.accept(";")) {
    if (!tokens_.accept(",")) s.operands.push_back(parse_operand());
  }
  if (s.operation == "bra") {
    i.execute = execute_branch;
    i.is_control = true;
    i.kind = Kind::branch;
    branches_.emplace_back(module_.code.size(), s.operands[0].name);
  } else if (!decode(s, *this, i)) {
    i.execute = execute_unsupported;
    i.is_control = true;
  }
  append(i);
}

std::vector<std::string_view> FunctionParser::parse_names() {
  std::vector<std::string_view> names;
  tokens_.expect("(");
  while (!tokens_.accept(")")) {
    if (!tokens_.accept(",")) names.push_back(tokens_.take());
  }
  return names;
}

void FunctionParser::parse_call(Instruction& i) {
  i.execute = execute_call;
  i.is_control = true;
  i.kind = Kind::branch;
  std::vector<std::string_view> results;
  std::vector<std::string_view> names;
  if (tokens_.peek() == "(") {
    results = parse_names();
    tokens_.expect(",");
  }
  i.callee = &module_.function(tokens_.take());
  if (tokens_.accept(",")) names = parse_names();
  tokens_.skip_behind(";");
  names.insert(names.end(), results.begin(), results.end());
  for (const std::string_view name : names) {
    const Slot* const slot = frame_variable(name);
    if (slot == nullptr) tokens_.fail("no such parameter: " + std::string(name));
    i.arguments.push_back(slot->offset);
  }
  append(i);
}

void FunctionParser::resolve_branches() {
  for (const auto& [position, label] : branches_) {
    const auto target = labels_.find(label);
    if (target == labels_.end()) tokens_.fail("no such label: " + std::string(label));
    module_.code[position].immediate = target->second;
  }
}

Operand FunctionParser::parse_operand() {
  if (tokens_.accept("{")) return parse_vector();
  if (tokens_.accept("[")) return parse_address();
  if (tokens_.accept("!")) {
    Operand o = parse_operand();
    o.negated = true;
    return o;
  }
  return parse_value(tokens_.accept("-"));
}

Operand FunctionParser::parse_vector() {
  Operand o;
  o.form = Operand::Form::vector;
  while (!tokens_.accept("}")) {
    if (!tokens_.accept(",")) o.elements.push_back(parse_operand());
  }
  return o;
}

Operand FunctionParser::parse_address() {
  Operand o;
  o.form = Operand::Form::address;
  const std::string_view base = tokens_.take();
  if (Tokens::is_number(base)) {
    o.value = Tokens::number_of(base);
  } else {
    o.row = find_register(base);
    if (o.row == kNoRow) o.name = base;
  }
  while (!tokens_.accept("]")) {
    const bool is_negative = tokens_.accept("-");
    if (!is_negative) tokens_.expect("+");
    const bool is_opposite = tokens_.accept("-");  // "+-8"
    const u64 offset = tokens_.take_number();
    o.value += is_negative != is_opposite ? 0 - offset : offset;
  }
  return o;
}

Operand FunctionParser::parse_value(bool is_negative) {
  Operand o;
  const std::string_view t = tokens_.take();
  if (Tokens::is_number(t)) {
    o.value = is_negative ? 0 - Tokens::number_of(t) : Tokens::number_of(t);
    o.row = constant(o.value);
    return o;
  }
  o.name = t;
  o.row = t == "_" ? kNoRow : find_register(t);
  if (o.row == kNoRow && t != "_") o.form = Operand::Form::symbol;
  if (o.form == Operand::Form::symbol && tokens_.accept("+")) o.value = tokens_.take_number();
  if (tokens_.accept("|")) o.second_row = find_register(tokens_.take());
  return o;
}

Row FunctionParser::find_register(std::string_view name) const {
  const std::size_t digits = name.find_last_not_of("0123456789") + 1;
  const std::string_view prefix = name.substr(0, digits);
  const bool is_numbered = digits < name.size();
  const u64 number = is_numbered ? Tokens::number_of(name.substr(digits)) : 0;
  for (auto scope = scopes_.rbegin(); scope != scopes_.rend(); ++scope) {
    if (const auto found = scope->registers.find(name); found != scope->registers.end()) return found->second;
    for (const RegisterFamily& f : scope->families) {
      if (is_numbered && f.prefix == prefix && number < f.count) return f.first + static_cast<u32>(number);
    }
  }
  return kNoRow;
}

Row FunctionParser::constant(u64 value) {
  const auto id = static_cast<u32>(module_.constant_ids.size());
  const auto [found, is_new] = module_.constant_ids.try_emplace(value, id);
  if (is_new) module_.constants.insert(module_.constants.end(), kLanes, value);
  return found->second | kConstantRow;
}

const Slot* FunctionParser::frame_variable(std::string_view name) const {
  for (auto scope = scopes_.rbegin(); scope != scopes_.rend(); ++scope) {
    if (const auto found = scope->variables.find(name); found != scope->variables.end()) return &found->second;
  }
  return nullptr;
}

bool FunctionParser::address_of(std::string_view name, u64& address) {
  if (const auto found = kernel_parameters_.find(name); found != kernel_parameters_.end()) {
    address = found->second;
    return true;
  }
  if (const auto found = module_.shared.find(name); found != module_.shared.end() && !shared_.contains(name)) {
    if (!function_->is_kernel) tokens_.fail("a function uses shared memory of the module");
    shared_[found->first] = place(function_->shared_bytes, found->second.bytes, found->second.offset);
  }
  if (const auto found = shared_.find(name); found != shared_.end()) {
    address = found->second;
    return true;
  }
  const auto found = module_.variables.find(name);
  if (found != module_.variables.end()) address = found->second;
  return found != module_.variables.end();
}

}  // namespace tetune::ptxsim
