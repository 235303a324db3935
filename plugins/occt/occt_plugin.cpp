// SPDX-License-Identifier: Apache-2.0
// main() of the plugin of CAD geometry: src/io/plugin_protocol.hpp.
#include <sys/resource.h>
#include <unistd.h>

#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Standard_Failure.hxx>
#include <utility>

#include "classify.hpp"
#include "process.hpp"

namespace tetune::plugin {
namespace {

/// Ends this process where a damaged file keeps OpenCASCADE busy forever.
void limit_time(const std::string& file) {
  constexpr rlim_t kBaseSeconds = 60;
  constexpr rlim_t kBytesPerSecond = 100'000;
  const rlim_t seconds = kBaseSeconds + std::filesystem::file_size(file) / kBytesPerSecond;
  const rlimit limit{seconds, seconds};
  ::setrlimit(RLIMIT_CPU, &limit);
}

template <class Query>
Query receive_query() {
  Query query;
  receive([&](MeshReader& in) { in(query); });
  return query;
}

template <class Answer>
AnswerBody body_of(Answer answer) {
  return [answer = std::move(answer)](AnswerWriter& out) { out(answer); };
}

AnswerBody run(const std::string& verb, const std::string& file, Warnings& warnings) {
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
  try {
    if (verb == "classify") return body_of(classify(receive_query<ClassifyQuery>()));
    if (verb == "project") return body_of(project(receive_query<ProjectQuery>()));
    limit_memory(file);
    limit_time(file);
    return body_of(load(file, warnings));
  } catch (const Standard_Failure& e) {
    throw FileError(std::string("OpenCASCADE: ") + e.DynamicType()->Name() + " " + e.GetMessageString());
  }
}

}  // namespace
}  // namespace tetune::plugin

int main(int argc, char** argv) {
  namespace plugin = tetune::plugin;
  if (argc != 3 || !plugin::has_channel()) return 2;
  plugin::install_signal_handlers(nullptr);
  ::_exit(plugin::run_and_answer([&](plugin::Warnings& warnings) { return plugin::run(argv[1], argv[2], warnings); }));
}
