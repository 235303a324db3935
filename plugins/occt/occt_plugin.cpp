// SPDX-License-Identifier: Apache-2.0
// main() of the plugin of CAD geometry: src/io/plugin/plugin_protocol.hpp.
#include <sys/resource.h>
#include <unistd.h>

#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Standard_Failure.hxx>
#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>

#include "classify.hpp"
#include "process.hpp"
#include "workers.hpp"

namespace tetune::plugin {
namespace {

/// Ends this process where a damaged file or model keeps OpenCASCADE busy for longer than this from now on, summed over
/// threads.
void limit_time(rlim_t seconds) {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  rlimit limit{};
  ::getrlimit(RLIMIT_CPU, &limit);
  limit.rlim_cur = std::min(limit.rlim_max, rlim_t(used.ru_utime.tv_sec + used.ru_stime.tv_sec) + seconds);
  ::setrlimit(RLIMIT_CPU, &limit);
}

constexpr rlim_t kBaseSeconds = 20;
constexpr rlim_t kBaseSecondsToLoad = 5;

/// The model of a file, and answers to requests about it.
class Service {
 public:
  explicit Service(std::string file) : file_(std::move(file)) {}

  AnswerBody answer(Warnings& warnings) {
    AnswerBody body;
    receive([&](MeshReader& in) {
      std::string verb;
      in(verb);
      if (verb == "load") {
        body = body_of(load(warnings));
      } else if (!workers_) {
        throw FileError("the model was not loaded");
      } else if (verb == "classify") {
        body = body_of(classify(query<ClassifyQuery>(in), *model_, *workers_));
      } else {
        body = body_of(project(query<ProjectQuery>(in), *model_, *workers_));
      }
    });
    return body;
  }

 private:
  LoadedModel load(Warnings& warnings) {
    constexpr rlim_t kBytesPerSecond = 100'000;
    const MemoryLimit memory(file_);
    limit_time(kBaseSecondsToLoad + std::filesystem::file_size(file_) / kBytesPerSecond);
    const TopoDS_Shape shape = read_shape(file_, warnings);
    LoadedModel loaded = summarize(shape);
    model_ = std::make_unique<Model>(shape);
    workers_ = std::make_unique<Workers>(*model_);
    return loaded;
  }

  template <class Query>
  static Query query(MeshReader& in) {
    constexpr rlim_t kPointsPerSecond = 100;
    Query query;
    in(query);
    limit_time(kBaseSeconds + query.points.size() / kPointsPerSecond);
    return query;
  }

  template <class Answer>
  static AnswerBody body_of(Answer answer) {
    return [answer = std::move(answer)](AnswerWriter& out) { out(answer); };
  }

  const std::string file_;
  std::unique_ptr<const Model> model_;
  std::unique_ptr<Workers> workers_;
};

AnswerBody answer(Service& service, Warnings& warnings) {
  try {
    return service.answer(warnings);
  } catch (const Standard_Failure& e) {
    throw FileError(std::string("OpenCASCADE: ") + e.DynamicType()->Name() + " " + e.GetMessageString());
  }
}

/// Answers until the requests end.
void serve(const std::string& file) {
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
  Service service(file);
  char byte = 0;
  while (::read(STDIN_FILENO, &byte, 1) == 1) {
    run_and_answer([&](Warnings& warnings) { return answer(service, warnings); });
    if (::write(STDIN_FILENO, &byte, 1) != 1) return;
  }
}

}  // namespace
}  // namespace tetune::plugin

int main(int argc, char** argv) {
  namespace plugin = tetune::plugin;
  if (argc != 3 || std::string_view(argv[1]) != "serve" || !plugin::has_channel()) return 2;
  plugin::install_signal_handlers(nullptr);
  plugin::serve(argv[2]);
  ::_exit(0);
}
