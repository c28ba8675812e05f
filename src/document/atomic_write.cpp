#include "document/atomic_write.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <filesystem>

#include <fmt/format.h>

#include "document/io_error.hpp"

namespace lamprey::document {

namespace {

class WrittenFile {
 public:
  WrittenFile(const std::string& path, int flags) : path_(path), value_(::open(path.c_str(), flags | O_CLOEXEC)) {
    if (value_ < 0) refuse_io(path, "cannot be opened");
  }
  ~WrittenFile() {
    if (value_ >= 0) ::close(value_);
  }
  WrittenFile(const WrittenFile&) = delete;
  WrittenFile& operator=(const WrittenFile&) = delete;

  void write(const std::string& content) const {
    for (std::size_t done = 0; done < content.size();) {
      const ssize_t count = ::write(value_, content.data() + done, content.size() - done);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) refuse_io(path_, "cannot be written");
      done += static_cast<std::size_t>(count);
    }
  }

  void flush() const {
    if (::fsync(value_) != 0 && errno != EINVAL) refuse_io(path_, "cannot be flushed to the disk");
  }

 private:
  std::string path_;
  int value_;
};

// What must be undone if not all goes well: temporary files and new folders, removed in reverse order.
class Undo {
 public:
  ~Undo() {
    if (kept_) return;
    for (const std::string& file : files_) ::unlink(file.c_str());
    for (auto folder = folders_.rbegin(); folder != folders_.rend(); ++folder) ::rmdir(folder->c_str());
  }
  void add_file(const std::string& path) { files_.push_back(path); }
  void add_folder(const std::string& path) { folders_.push_back(path); }
  void keep() { kept_ = true; }

 private:
  std::vector<std::string> files_;
  std::vector<std::string> folders_;
  bool kept_ = false;
};

void create_folder(const std::filesystem::path& folder, Undo& undo) {
  struct stat status = {};
  if (::stat(folder.c_str(), &status) == 0) {
    if (!S_ISDIR(status.st_mode)) throw IoError(folder.string(), "is a file; name a folder for the results");
    return;
  }
  if (folder.has_parent_path() && folder.parent_path() != folder) create_folder(folder.parent_path(), undo);
  if (::mkdir(folder.c_str(), 0777) == 0)
    undo.add_folder(folder.string());
  else if (errno != EEXIST)
    refuse_io(folder.string(), "cannot be created");
}

std::filesystem::path target_of(const std::string& folder) {
  std::filesystem::path target = std::filesystem::path(folder.empty() ? "." : folder).lexically_normal();
  return target.has_filename() ? target : target.parent_path();
}

std::string write_temporary(const std::filesystem::path& folder, const PendingFile& file, Undo& undo) {
  static std::atomic<unsigned> written = 0;  // by threads of this process, side by side
  const std::string temporary = (folder / fmt::format(".{}.{}.{}.partial", file.name, ::getpid(), written++)).string();
  ::unlink(temporary.c_str());
  if (const int made = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666); made < 0)
    refuse_io(folder.string(), "no file can be made in this folder");
  else
    ::close(made);
  undo.add_file(temporary);
  file.write(temporary);
  WrittenFile(temporary, O_RDONLY).flush();
  return temporary;
}

}  // namespace

PendingFile finished_file(std::string name, std::string content) {
  return {std::move(name), [content = std::move(content)](const std::string& temporary) {
            WrittenFile(temporary, O_WRONLY | O_TRUNC).write(content);
          }};
}

void require_writable(const std::string& folder) {
  Undo undo;
  const std::filesystem::path target = target_of(folder);
  create_folder(target, undo);
  write_temporary(target, finished_file("probe", ""), undo);
}

void write_files(const std::string& folder, const std::vector<PendingFile>& files) {
  Undo undo;
  const std::filesystem::path target = target_of(folder);
  create_folder(target, undo);
  std::vector<std::string> temporaries;
  for (const PendingFile& file : files) temporaries.push_back(write_temporary(target, file, undo));
  for (std::size_t i = 0; i < files.size(); ++i)
    if (const std::string final_path = (target / files[i].name).string();
        ::rename(temporaries[i].c_str(), final_path.c_str()) != 0)
      refuse_io(final_path, "cannot be put in place");
  undo.keep();
  WrittenFile(target.string(), O_RDONLY | O_DIRECTORY).flush();
}

}  // namespace lamprey::document
