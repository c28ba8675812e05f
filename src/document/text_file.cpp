#include "document/text_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>

#include <fmt/format.h>
#include <openssl/evp.h>

#include "document/io_error.hpp"
#include "model/input_error.hpp"

namespace lamprey::document {

namespace {

class OpenedFile {
 public:
  explicit OpenedFile(const std::string& path) : value_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~OpenedFile() {
    if (value_ >= 0) ::close(value_);
  }
  OpenedFile(const OpenedFile&) = delete;
  OpenedFile& operator=(const OpenedFile&) = delete;
  int value() const { return value_; }

 private:
  int value_;
};

}  // namespace

std::string read_bytes(const std::string& path, std::size_t limit) {
  const OpenedFile file(path);
  if (file.value() < 0) refuse_io(path, "cannot be opened");
  struct stat status = {};
  if (::fstat(file.value(), &status) != 0) refuse_io(path, "cannot be read");
  if (S_ISDIR(status.st_mode)) throw IoError(path, "is a folder; name a file in it");
  std::string bytes;
  std::array<char, 65536> chunk;
  while (true) {
    const ssize_t count = ::read(file.value(), chunk.data(), chunk.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse_io(path, "cannot be read");
    if (count == 0) return bytes;
    bytes.append(chunk.data(), static_cast<std::size_t>(count));
    if (bytes.size() > limit)
      throw model::InputError(
          path, 1, 1, "file",
          fmt::format("found more than {} bytes; allowed: at most {} MiB; shorten the file", limit, limit >> 20));
  }
}

std::string motion_file(const std::string& path) {
  const std::filesystem::path stored = std::filesystem::path(path) / "solution.json";
  std::error_code none;
  return std::filesystem::is_regular_file(stored, none) ? stored.string() : path;
}

std::string sha256(const std::string& bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned int length = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &length, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("the cryptographic library refused SHA-256");
  std::string text;
  for (unsigned int i = 0; i < length; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

}  // namespace lamprey::document
