#include "study/workers.hpp"

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>

namespace lamprey::study {

namespace {

using Numbers = std::vector<double>;

struct Worker {
  pid_t process;
  int pipe;
  int task;
};

bool write_all(int file, const void* data, std::size_t size) {
  const char* next = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = write(file, next, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    next += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

bool read_all(int file, void* data, std::size_t size) {
  char* next = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t got = read(file, next, size);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    next += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

// A message is the count of numbers, and these.
bool send(int file, const Numbers& numbers) {
  const std::int64_t count = static_cast<std::int64_t>(numbers.size());
  return write_all(file, &count, sizeof count) && write_all(file, numbers.data(), numbers.size() * sizeof(double));
}

std::optional<Numbers> receive(int file) {
  std::int64_t count = 0;
  if (!read_all(file, &count, sizeof count)) return std::nullopt;
  Numbers numbers(static_cast<std::size_t>(count));
  if (!read_all(file, numbers.data(), numbers.size() * sizeof(double))) return std::nullopt;
  return numbers;
}

[[noreturn]] void work(int pipe, int t, const std::function<Numbers(int)>& task) {
  bool sent = false;
  try {
    sent = send(pipe, task(t));
  } catch (...) {  // the parent sees a missing result
  }
  _exit(sent ? 0 : 1);
}

// A process for one task, so that its death costs no other; nothing where the machine gives no more processes.
std::optional<Worker> start(int t, const std::function<Numbers(int)>& task) {
  std::fflush(nullptr);  // a child must not write the parent's buffers again
  int ends[2];
  if (pipe(ends) != 0) return std::nullopt;
  const pid_t process = fork();
  if (process == 0) {
    close(ends[0]);
    work(ends[1], t, task);
  }
  close(ends[1]);
  if (process > 0) return Worker{process, ends[0], t};
  close(ends[0]);
  return std::nullopt;
}

// The first of the running workers that has something to say, or has died.
std::size_t next_to_finish(const std::vector<Worker>& running) {
  std::vector<pollfd> waiting;
  for (const Worker& worker : running) waiting.push_back({worker.pipe, POLLIN, 0});
  while (poll(waiting.data(), waiting.size(), -1) < 0) {  // a signal: workers end by themselves
  }
  std::size_t first = 0;
  while (waiting[first].revents == 0) ++first;
  return first;
}

std::optional<Numbers> finish(const Worker& worker) {
  std::optional<Numbers> numbers = receive(worker.pipe);
  close(worker.pipe);
  while (waitpid(worker.process, nullptr, 0) < 0 && errno == EINTR) {
  }
  return numbers;
}

}  // namespace

std::vector<std::optional<Numbers>> run_in_workers(int count, int workers, const std::function<Numbers(int)>& task,
                                                   const std::function<void(int)>& finished,
                                                   const std::function<bool()>& stopped) {
  std::vector<std::optional<Numbers>> results(static_cast<std::size_t>(count));
  std::vector<Worker> running;
  int next = 0;
  for (int done = 0; done < count;) {
    if (next > 0 && next < count && stopped && stopped()) {
      count = next;
      continue;
    }
    const bool room = next < count && running.size() < static_cast<std::size_t>(workers);
    if (room && workers > 1 && count > 1) {
      if (const std::optional<Worker> started = start(next, task)) {
        running.push_back(*started);
        ++next;
        continue;
      }
    }
    if (running.empty()) {  // one worker or one task, or no process could be started
      results[static_cast<std::size_t>(next)] = task(next);
      ++next;
    } else {
      const std::size_t w = next_to_finish(running);
      results[static_cast<std::size_t>(running[w].task)] = finish(running[w]);
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(w));
    }
    finished(++done);
  }
  return results;
}

}  // namespace lamprey::study
