// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <map>
#include <string_view>
#include <vector>

#include "ptxsim/program.hpp"

namespace tetune::ptxsim {

/// A type of PTX: kind 'u', 's', 'b', 'f', or 'p' for predicates; 0 if it is none.
struct Type {
  char kind = 0;
  u32 bits = 0;
  bool is_float() const { return kind == 'f'; }
  bool is_signed() const { return kind == 's'; }
};
/// "s32", for example.
Type type_of(std::string_view text);

struct Operand {
  enum class Form : u8 { row, symbol, address, vector };
  Form form = Form::row;
  Row row = kNoRow;         ///< a register, a constant, or the base of an address
  u64 value = 0;            ///< of a constant; what is added to an address or symbol
  std::string_view name;    ///< of a symbol
  bool negated = false;     ///< !predicate
  Row second_row = kNoRow;  ///< of "first|second"
  std::vector<Operand> elements;
};

/// An instruction as it is written: "setp.lt.f64 %p1, %d1, %d2" has the operation "setp" and modifiers "lt", "f64".
struct Statement {
  std::string_view operation;
  std::vector<std::string_view> modifiers;
  std::vector<Operand> operands;

  bool has(std::string_view modifier) const {
    return std::find(modifiers.begin(), modifiers.end(), modifier) != modifiers.end();
  }
  /// The last modifier.
  Type type() const { return modifiers.empty() ? Type{} : type_of(modifiers.back()); }
};

/// The properties of a function that decoding its instructions needs.
class Scope {
 public:
  /// The row of a constant.
  virtual Row constant(u64 value) = 0;
  /// The variable of this name in the frame of the function; null if there is none.
  virtual const Slot* frame_variable(std::string_view name) const = 0;
  /// The address of a kernel's parameter, a shared variable or a variable of the module in its own space.
  virtual bool address_of(std::string_view name, u64& address) = 0;

 protected:
  ~Scope() = default;
};

/// Completes an instruction; returns whether the statement is supported. What is not supported ends the process when it
/// runs, as compilers emit code that never does.
using Decode = bool (*)(const Statement&, Scope&, Instruction&);
using DecodeTable = std::map<std::string_view, Decode>;

/// By operation. Each table is in the file that also has the operations.
void add_arithmetic(DecodeTable& table);
void add_comparisons(DecodeTable& table);
void add_bit_operations(DecodeTable& table);
void add_conversions(DecodeTable& table);
void add_moves(DecodeTable& table);
void add_memory_accesses(DecodeTable& table);
void add_atomics(DecodeTable& table);
void add_control(DecodeTable& table);
void add_warp_operations(DecodeTable& table);

/// The barriers of blocks: those of warps have the same operation.
bool decode_block_barrier(const Statement& statement, Scope& scope, Instruction& instruction);

bool decode(const Statement& statement, Scope& scope, Instruction& instruction);

/// Calls and branches are completed by the parser, which knows labels and functions.
void execute_call(Warp& warp, const Instruction& instruction);
void execute_branch(Warp& warp, const Instruction& instruction);
void execute_return(Warp& warp, const Instruction& instruction);
void execute_unsupported(Warp& warp, const Instruction& instruction);

/// Takes the rows of the first operands as result, a, b, c, d. False where there are fewer, or a symbol is among them.
bool take_rows(const Statement& statement, u32 count, Instruction& instruction);
/// Takes an address as base, offset and space.
bool take_address(const Operand& address, Scope& scope, Instruction& instruction);

}  // namespace tetune::ptxsim
