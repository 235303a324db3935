// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "ptxsim/statement.hpp"
#include "ptxsim/tokens.hpp"

namespace tetune::ptxsim {

/// A declaration, such as ".align 8 .b8 name[48]".
struct Variable {
  std::string_view name;
  u32 bytes = 0, element_bytes = 0;
  u32 alignment = 1;
};
/// The rest of a declaration after its space.
Variable parse_variable(Tokens& tokens);

/// Parses the parameters and the body of one function.
class FunctionParser final : Scope {
 public:
  FunctionParser(Module& module, Tokens& tokens) : module_(module), tokens_(tokens) {}

  /// The rest of a function after ".func" or ".entry".
  void parse(bool is_kernel);

 private:
  /// Registers %r0 to %r9 are declared as %r<10>.
  struct RegisterFamily {
    std::string_view prefix;
    u32 first, count;
  };
  /// The text between braces.
  struct Braces {
    std::map<std::string_view, Row> registers;
    std::vector<RegisterFamily> families;
    std::map<std::string_view, Slot> variables;  // in the frame
  };

  Row constant(u64 value) override;
  const Slot* frame_variable(std::string_view name) const override;
  bool address_of(std::string_view name, u64& address) override;

  std::vector<Variable> parse_parameters();
  void parse_attributes();
  void place_parameters(const std::vector<Variable>& parameters, const std::vector<Variable>& results);
  void parse_body();
  void parse_registers();
  void parse_frame_variable();
  void parse_shared_variable();
  void parse_location();
  void parse_instruction();
  void parse_call(Instruction& instruction);
  std::vector<std::string_view> parse_names();
  void resolve_branches();

  Operand parse_operand();
  Operand parse_address();
  Operand parse_vector();
  Operand parse_value(bool is_negative);
  Row find_register(std::string_view name) const;
  Slot place_in_frame(const Variable& variable);
  void append(const Instruction& instruction) { module_.code.push_back(instruction); }

  Module& module_;
  Tokens& tokens_;
  Function* function_ = nullptr;
  std::vector<Braces> scopes_;
  std::map<std::string_view, u32> kernel_parameters_, shared_, labels_;  // offsets, and positions in the code
  std::vector<std::pair<std::size_t, std::string_view>> branches_;       // to labels that may follow
  u32 file_ = 0, line_ = 0;
};

}  // namespace tetune::ptxsim
