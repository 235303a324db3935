// SPDX-License-Identifier: Apache-2.0
#include "io/gzip.hpp"

#include <algorithm>
#include <array>

#include "tetune/error.hpp"

#ifdef TETUNE_ZLIB
#define ZLIB_CONST
#include <zlib.h>

namespace tetune {
namespace {

constexpr int kGzip = 16;  ///< added to the size of the window: a .gz file, not a bare stream
constexpr std::size_t kMaxAtOnce = 1U << 30;

/// Takes the next bytes as input, as many as fit the counter of zlib, and removes them from `rest`.
void feed(z_stream& stream, std::string_view& rest) {
  const std::size_t n = std::min(rest.size(), kMaxAtOnce);
  stream.next_in = reinterpret_cast<const Bytef*>(rest.data());
  stream.avail_in = uInt(n);
  rest.remove_prefix(n);
}

/// The state of decompression, which the destructor frees.
struct Inflation {
  z_stream stream{};
  ~Inflation() { inflateEnd(&stream); }
};

}  // namespace

std::string gunzip(const std::string& path, std::string_view bytes) {
  Inflation inflation;
  z_stream& stream = inflation.stream;
  if (inflateInit2(&stream, MAX_WBITS + kGzip) != Z_OK) throw FileError(path + ": no memory to decompress the file");
  std::string text;
  std::array<char, 1U << 16> part;
  std::string_view rest = bytes;
  for (bool more = !bytes.empty(); more;) {
    if (stream.avail_in == 0) feed(stream, rest);
    stream.next_out = reinterpret_cast<Bytef*>(part.data());
    stream.avail_out = uInt(part.size());
    const int result = inflate(&stream, Z_NO_FLUSH);
    text.append(part.data(), part.size() - stream.avail_out);
    const bool input_left = stream.avail_in > 0 || !rest.empty();
    if (result == Z_STREAM_END && !input_left) return text;
    if (result == Z_STREAM_END) {
      inflateReset(&stream);  // several files, one after the other
    } else if (result != Z_OK && result != Z_BUF_ERROR) {
      throw FileError(path + ": the compressed data are damaged after " + std::to_string(text.size()) +
                      " bytes of text, or the file is not a .gz file");
    }
    more = input_left || stream.avail_out == 0;
  }
  throw FileError(path + ": the compressed data end early, after " + std::to_string(text.size()) + " bytes of text");
}

struct GzipWriter::Stream {
  z_stream state{};
  ~Stream() { deflateEnd(&state); }
  /// Compresses all input, and with `flush` Z_FINISH the end.
  void run(FileWriter& file, int flush) {
    std::array<char, 1U << 16> part;
    do {
      state.next_out = reinterpret_cast<Bytef*>(part.data());
      state.avail_out = uInt(part.size());
      deflate(&state, flush);
      file.write(part.data(), part.size() - state.avail_out);
    } while (state.avail_out == 0);
  }
};

GzipWriter::GzipWriter(FileWriter& file) : file_(file), stream_(std::make_unique<Stream>()) {
  constexpr int kMemory = 8;  // zlib's default
  if (deflateInit2(&stream_->state, Z_BEST_SPEED, Z_DEFLATED, MAX_WBITS + kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK) {
    throw FileError("no memory to compress the file");
  }
}

void GzipWriter::write(std::string_view text) {
  while (!text.empty()) {
    feed(stream_->state, text);
    stream_->run(file_, Z_NO_FLUSH);
  }
}

void GzipWriter::finish() { stream_->run(file_, Z_FINISH); }

GzipWriter::~GzipWriter() = default;

}  // namespace tetune

#else

namespace tetune {

constexpr const char* kNoZlib = "this build of tetune has no zlib; use a file that is not compressed";

struct GzipWriter::Stream {};
std::string gunzip(const std::string& path, std::string_view) { throw FileError(path + ": " + kNoZlib); }
GzipWriter::GzipWriter(FileWriter& file) : file_(file) { throw FileError(kNoZlib); }
void GzipWriter::write(std::string_view text) { file_.write(text); }
void GzipWriter::finish() {}
GzipWriter::~GzipWriter() = default;

}  // namespace tetune

#endif
