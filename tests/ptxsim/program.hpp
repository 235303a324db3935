// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "ptxsim/types.hpp"

namespace tetune::ptxsim {

struct Warp;
struct Instruction;
struct Function;
struct Module;

/// Runs an instruction for the active lanes of a warp.
using Execute = void (*)(Warp&, const Instruction&);

/// The classes by which instructions are counted. Accesses to memory are counted as what their addresses turn out to
/// be.
enum class Kind : u8 {
  integer,
  f64,
  f64_division,
  f32,
  move,
  load,
  store,
  local,
  shared,
  atomic,
  branch,
  sync,
  parameter
};
inline constexpr u32 kKinds = 13;
const char* name_of(Kind kind);

/// Where an address is. `frame` is the part of local memory that the running function addresses by its variables.
enum class Space : u8 { generic, global, shared, local, parameter, frame };

/// A register of a function, with one value of 64 bits per lane; or a constant of the module.
using Row = u32;
inline constexpr Row kNoRow = 0xffffffffU;
inline constexpr Row kConstantRow = 0x80000000U;  ///< the bit that distinguishes a constant

inline constexpr u32 kMaxVector = 4;

struct Instruction {
  Execute execute = nullptr;
  Row to = kNoRow, a = kNoRow, b = kNoRow, c = kNoRow, d = kNoRow;
  Row second_to = kNoRow;
  /// The instruction runs for the lanes for which this predicate holds, or does not hold.
  Row guard = kNoRow;
  bool guard_negated = false;
  /// It reads its guard itself, or changes which lanes run.
  bool is_control = false;
  Kind kind = Kind::integer;
  Space space = Space::generic;
  bool is_signed = false;
  bool negated = false;  ///< the predicate operand is negated
  bool strong = false;   ///< a volatile access
  u8 bytes = 4;          ///< of an element
  u8 elements = 1;
  u8 variant = 0;     ///< of the operation: see where it is decoded
  char type = 'b';    ///< of an atomic operation: b, u, s or f
  i64 immediate = 0;  ///< offset of an address, target of a branch, or as documented where it is decoded
  Row vector[kMaxVector] = {kNoRow, kNoRow, kNoRow, kNoRow};
  const Function* callee = nullptr;
  std::vector<u32> arguments;  ///< of a call: offsets in the caller's frame of what is passed, then of the results
  const Function* function = nullptr;
  u32 ptx_line = 0, file = 0, line = 0;
};

/// A variable in a function's frame or a parameter of a kernel.
struct Slot {
  u32 offset, bytes;
};

struct Function {
  std::string name;
  Module* module = nullptr;
  bool is_kernel = false, is_defined = false;
  u32 begin = 0;  ///< index of the first instruction in the module
  u32 registers = 0;
  u32 frame_bytes = 0;  ///< parameters, results and local variables
  u32 shared_bytes = 0;
  u32 max_threads = 0;  ///< of a block, as declared; 0 if it is not
  u32 parameter_bytes = 0;
  std::vector<Slot> parameters, results;
};

/// The code for one architecture that was compiled from one source file.
struct Module {
  std::string text;
  u32 architecture = 0;  ///< such as 75
  std::vector<Instruction> code;
  std::vector<u64> constants;  ///< one per lane each
  std::unordered_map<u64, u32> constant_ids;
  std::map<std::string, std::unique_ptr<Function>, std::less<>> functions;
  std::map<std::string, u64, std::less<>> variables;  ///< addresses
  std::map<std::string, Slot, std::less<>> shared;    ///< sizes and alignments, of shared variables of the module
  std::map<u32, std::string> files;

  Function& function(std::string_view name);
};

/// Parses `module.text`. Ends the process where it is not PTX as nvcc writes it.
void parse(Module& module);

/// "file:line, PTX line n of function f".
std::string place_of(const Instruction& instruction);

}  // namespace tetune::ptxsim
