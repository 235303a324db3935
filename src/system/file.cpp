// SPDX-License-Identifier: Apache-2.0
#include "system/file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <random>

#include "system/native.hpp"
#include "system/path.hpp"
#include "system/write_all.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& text) { throw FileError(text + ": " + std::strerror(errno)); }

}  // namespace

MappedFile::MappedFile(const std::string& path) {
  std::error_code ignored;
  // Windows opens no folder.
  if (fs::is_directory(native::long_path(path), ignored)) throw FileError(path + ": not a regular file");
  const int descriptor = native::open_to_read(path);
  if (descriptor < 0) fail(path + ": cannot open");
  try {
    map(descriptor, path);
  } catch (...) {
    native::close(descriptor);
    throw;
  }
  native::close(descriptor);
}

void MappedFile::map(int descriptor, const std::string& name) {
  const std::optional<std::size_t> size = native::regular_size(descriptor);
  if (!size && errno == 0) throw FileError(name + ": not a regular file");
  if (!size && (errno == EFBIG || errno == EOVERFLOW)) {
    throw FileError(name + ": too large for the addresses of this program; use tetune on a system of 64 bits");
  }
  if (!size) fail(name + ": cannot inspect");
  if (*size == 0) return;
  const char* const memory = native::map(descriptor, *size);
  if (memory == nullptr) fail(name + ": cannot map into memory");
  bytes_ = {memory, *size};
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) native::unmap(bytes_);
}

TemporaryFile::TemporaryFile(std::string path) : path_(std::move(path)) {
  std::random_device random;
  std::error_code ignored;
  const fs::path place = path_of(path_);
  const std::string ending = place.extension().string();
  constexpr std::size_t kMaxName = 255;  // of most file systems
  do {
    const std::string suffix = ".tetune-" + std::to_string(random()) + ".tmp" + ending;
    const bool fits = place.filename().string().size() + suffix.size() <= kMaxName;
    name_ = fits ? path_ + suffix : (place.parent_path() / suffix).string();
  } while (fs::exists(native::long_path(name_), ignored));
}

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  if (!name_.empty()) fs::remove(native::long_path(name_), ignored);
}

void TemporaryFile::replace() {
  native::copy_permissions(path_, name_);
  std::error_code error, ignored;
  fs::rename(native::long_path(name_), native::long_path(path_), error);
  if (error) fs::remove(native::long_path(name_), ignored);
  name_.clear();
  if (error) throw FileError("cannot write " + path_ + ": " + error.message());
}

FileWriter::FileWriter(std::string path) : path_(std::move(path)), descriptor_(native::create_unnamed(path_)) {
  if (descriptor_ >= 0) return;
  temporary_.emplace(path_);
  descriptor_ = native::create(temporary_->name());
  if (descriptor_ < 0) fail("cannot create a file in the folder of " + path_);
}

FileWriter::~FileWriter() {
  if (owns_descriptor_ && descriptor_ >= 0) native::close(descriptor_);
}

void FileWriter::write(const void* data, std::size_t bytes) {
  if (!write_all(descriptor_, data, bytes)) fail("cannot write " + path_);
}

void FileWriter::commit() {
  if (!owns_descriptor_) return;
  if (!temporary_) {
    // No call replaces an existing file by one without a name: it gets a temporary name for the time between two calls.
    temporary_.emplace(path_);
    if (!native::link_unnamed(descriptor_, temporary_->name())) fail("cannot write " + path_);
  }
  const int descriptor = std::exchange(descriptor_, -1);
  if (!native::close(descriptor)) fail("cannot write " + path_);
  temporary_->replace();
}

}  // namespace tetune
