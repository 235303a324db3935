// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <cstring>

#include "ptxsim/function_parser.hpp"
#include "ptxsim/global_memory.hpp"

namespace tetune::ptxsim {
namespace {

class ModuleParser {
 public:
  explicit ModuleParser(Module& module) : module_(module), tokens_(module.text) {}

  void parse() {
    while (!tokens_.at_end()) parse_directive();
    for (const auto& [at, name] : addresses_) {
      const auto found = module_.variables.find(name);
      if (found == module_.variables.end()) fatal("no such variable: " + name);
      std::memcpy(at, &found->second, sizeof found->second);
    }
  }

 private:
  void parse_directive() {
    const std::string_view directive = tokens_.peek();
    if (directive == ".version" || directive == ".address_size" || directive == ".target") {
      tokens_.skip_line();
    } else if (directive == ".file") {
      const auto id = static_cast<u32>(Tokens::number_of(tokens_.peek(1)));
      const std::string_view quoted = tokens_.peek(2);
      module_.files[id] = quoted.substr(1, quoted.size() - 2);
      tokens_.skip_line();
    } else if (directive == ".section") {
      tokens_.skip_behind("}");
    } else {
      parse_declaration();
    }
  }

  void parse_declaration() {
    std::string_view word = tokens_.take();
    while (word == ".visible" || word == ".weak" || word == ".extern" || word == ".common") word = tokens_.take();
    if (word == ".global" || word == ".const") {
      parse_variable_of_module();
    } else if (word == ".shared") {
      const Variable v = parse_variable(tokens_);
      tokens_.expect(";");
      // A variable without a size is dynamic shared memory, which the library does not use.
      if (v.bytes > 0) module_.shared[std::string(v.name)] = {v.alignment, v.bytes};
    } else if (word == ".func" || word == ".entry") {
      FunctionParser(module_, tokens_).parse(word == ".entry");
    } else if (word == ".alias") {
      tokens_.skip_behind(";");
    } else {
      tokens_.fail("not known: " + std::string(word));
    }
  }

  void parse_variable_of_module() {
    const Variable v = parse_variable(tokens_);
    const std::size_t bytes = (v.bytes / GlobalMemory::kGranule + 2) * GlobalMemory::kGranule;
    char* const memory = static_cast<char*>(std::aligned_alloc(GlobalMemory::kGranule, bytes));
    std::memset(memory, 0, bytes);
    const u64 address = reinterpret_cast<u64>(memory);
    global_memory().add(address, std::max(v.bytes, 1U));
    global_memory().mark_written(address, v.bytes);
    module_.variables[std::string(v.name)] = address;
    if (tokens_.accept("=")) parse_initializer(v, memory);
    tokens_.expect(";");
  }

  void parse_initializer(const Variable& v, char* memory) {
    if (!tokens_.accept("{")) {
      parse_element(v, memory);
      return;
    }
    while (!tokens_.accept("}")) {
      if (tokens_.accept(",")) continue;
      parse_element(v, memory);
      memory += v.element_bytes;
    }
  }

  void parse_element(const Variable& v, char* at) {
    const bool is_negative = tokens_.accept("-");
    std::string_view word = tokens_.take();
    if (!Tokens::is_number(word)) {
      if (word == "generic" && tokens_.accept("(")) {
        word = tokens_.take();
        tokens_.expect(")");
      }
      addresses_.emplace_back(at, word);
      return;
    }
    const u64 value = is_negative ? 0 - Tokens::number_of(word) : Tokens::number_of(word);
    std::memcpy(at, &value, v.element_bytes);
  }

  Module& module_;
  Tokens tokens_;
  std::vector<std::pair<char*, std::string>> addresses_;  // of variables that may follow, and where they go
};

}  // namespace

Function& Module::function(std::string_view name) {
  const auto [found, is_new] = functions.try_emplace(std::string(name));
  if (is_new) {
    found->second = std::make_unique<Function>();
    found->second->name = name;
    found->second->module = this;
  }
  return *found->second;
}

void parse(Module& module) { ModuleParser(module).parse(); }

std::string place_of(const Instruction& i) {
  const Function& f = *i.function;
  const auto file = f.module->files.find(i.file);
  const std::string line = file == f.module->files.end() ? "" : file->second + ":" + std::to_string(i.line) + ", ";
  return line + "PTX line " + std::to_string(i.ptx_line) + " of " + demangled(f.name);
}

}  // namespace tetune::ptxsim
