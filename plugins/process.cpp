// SPDX-License-Identifier: Apache-2.0
#include "process.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <new>
#include <stdexcept>

#include "system/write_all.hpp"

namespace tetune::plugin {
namespace {

constexpr const char* kTooMuchMemory = "reading it takes more memory than a file of its size can fill: it is damaged";

/// Makes a library's message printable: it may contain bytes of the file.
std::string printable(std::string text) {
  constexpr std::size_t kMaxLength = 300;
  if (text.size() > kMaxLength) text.replace(kMaxLength, std::string::npos, " ...");
  for (char& c : text) {
    if (c == '\n' || c == '\r' || c == '\t') c = ' ';
    if (c < ' ' || c > '~') c = '?';
  }
  return text;
}

void answer(const std::string& error, const Warnings& warnings, const AnswerBody& body) {
  if (::ftruncate(kPluginDescriptor, 0) != 0 || ::lseek(kPluginDescriptor, 0, SEEK_SET) != 0) {
    throw FileError("cannot answer");
  }
  AnswerWriter out(ChannelSink{});
  out(kAnswerVersion, error, warnings);
  if (body) body(out);
}

/// The input in the channel, mapped into memory.
class MappedInput {
 public:
  MappedInput() {
    struct stat info {};
    if (::fstat(kPluginDescriptor, &info) != 0) throw FileError("started without a channel");
    size_ = std::size_t(info.st_size);
    memory_ = ::mmap(nullptr, size_, PROT_READ, MAP_SHARED, kPluginDescriptor, 0);
    if (memory_ == MAP_FAILED) throw FileError("started without input");
  }
  ~MappedInput() { ::munmap(memory_, size_); }
  MappedInput(const MappedInput&) = delete;
  MappedInput& operator=(const MappedInput&) = delete;
  std::string_view bytes() const { return {static_cast<const char*>(memory_), size_}; }

 private:
  void* memory_ = nullptr;
  std::size_t size_ = 0;
};

const char* file_to_delete = nullptr;
pid_t parent = 0;

void handle_end_of_parent(int) {
  if (::getppid() == parent) return;
  if (file_to_delete != nullptr) ::unlink(file_to_delete);
  ::_exit(1);
}

}  // namespace

void ChannelSink::operator()(const void* data, std::size_t bytes) const {
  if (!write_all(kPluginDescriptor, data, bytes)) throw FileError("no memory for handing the answer over");
}

void receive(const std::function<void(MeshReader&)>& decode) {
  const MappedInput input;
  MeshReader in(input.bytes());
  std::uint64_t version = 0;
  in(version);
  if (version != kStreamVersion) throw FileError("the plugin is of another build; install tetune again");
  decode(in);
}

bool has_channel() {
  struct stat info {};
  return ::fstat(kPluginDescriptor, &info) == 0;
}

void install_signal_handlers(const char* written_file) {
  file_to_delete = written_file;
  const int owner = ::fcntl(kPluginDescriptor, F_GETOWN);
  parent = owner >= 0 ? owner : ::getppid();  // 0: it has ended; an emulator of Linux may not know owners
  ::signal(SIGINT, SIG_IGN);
  ::signal(SIGTERM, handle_end_of_parent);
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  handle_end_of_parent(SIGTERM);  // there is no signal where tetune has ended already
}

MemoryLimit::MemoryLimit(const std::string& file) {
  ::getrlimit(RLIMIT_DATA, &before_);
#if !defined(__SANITIZE_ADDRESS__)  // whose shadow memory counts too
  constexpr rlim_t kBaseBytes = 1'000'000'000;
  constexpr rlim_t kPerFileByte = 100;
  if (ending_of(file) == ".pvtu") return;  // the data are in other files
  const rlim_t bytes = kBaseBytes + kPerFileByte * std::filesystem::file_size(file);
  const rlimit limit{std::min(bytes, before_.rlim_max), before_.rlim_max};
  ::setrlimit(RLIMIT_DATA, &limit);
#else
  (void)file;
#endif
}

MemoryLimit::~MemoryLimit() { ::setrlimit(RLIMIT_DATA, &before_); }

int run_and_answer(const std::function<AnswerBody(Warnings&)>& work) {
  const auto answer_error = [](const std::string& text) {
    try {
      answer(text, {}, {});
      return 0;
    } catch (const std::exception&) {
      return 1;  // the channel is gone
    }
  };
  try {
    Warnings warnings;
    const AnswerBody body = work(warnings);
    answer("", warnings, body);
  } catch (const std::bad_alloc&) {
    return answer_error(kTooMuchMemory);
  } catch (const std::length_error&) {
    return answer_error(kTooMuchMemory);
  } catch (const std::exception& e) {
    return answer_error(printable(e.what()));
  }
  return 0;
}

}  // namespace tetune::plugin
