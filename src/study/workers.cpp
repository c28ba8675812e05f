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

// A message is the task's number, the count of its numbers, and these.
bool send(int file, std::int64_t task, const Numbers& numbers) {
  const std::int64_t head[2] = {task, static_cast<std::int64_t>(numbers.size())};
  return write_all(file, head, sizeof head) && write_all(file, numbers.data(), numbers.size() * sizeof(double));
}

bool receive(int file, std::int64_t& task, Numbers& numbers) {
  std::int64_t head[2];
  if (!read_all(file, head, sizeof head)) return false;
  task = head[0];
  numbers.resize(static_cast<std::size_t>(head[1]));
  return read_all(file, numbers.data(), numbers.size() * sizeof(double));
}

[[noreturn]] void work(int first, int count, int workers, int pipe, const std::function<Numbers(int)>& task) {
  int failed = 0;
  try {
    for (int t = first; t < count && !failed; t += workers) failed = send(pipe, t, task(t)) ? 0 : 1;
  } catch (...) {
    failed = 1;  // the parent sees missing tasks
  }
  close(pipe);
  _exit(failed);
}

std::vector<Worker> start(int count, int workers, const std::function<Numbers(int)>& task) {
  std::fflush(nullptr);  // a child must not write the parent's buffers again
  std::vector<Worker> started;
  for (int w = 0; w < workers; ++w) {
    int ends[2];
    if (pipe(ends) != 0) break;
    const pid_t process = fork();
    if (process == 0) {
      close(ends[0]);
      work(w, count, workers, ends[1], task);
    }
    close(ends[1]);
    if (process < 0) {
      close(ends[0]);
      break;
    }
    started.push_back({process, ends[0]});
  }
  return started;
}

}  // namespace

std::vector<std::optional<Numbers>> run_in_workers(int count, int workers, const std::function<Numbers(int)>& task,
                                                   const std::function<void(int)>& finished) {
  std::vector<std::optional<Numbers>> results(static_cast<std::size_t>(count));
  int done = 0;
  workers = std::min(workers, count);
  if (workers > 1) {
    std::vector<Worker> running = start(count, workers, task);
    while (!running.empty()) {
      std::vector<pollfd> waiting;
      for (const Worker& worker : running) waiting.push_back({worker.pipe, POLLIN, 0});
      if (poll(waiting.data(), waiting.size(), -1) < 0) continue;  // a signal: workers end by themselves
      for (std::size_t w = waiting.size(); w-- > 0;) {
        if (waiting[w].revents == 0) continue;
        std::int64_t index = 0;
        Numbers numbers;
        if (receive(running[w].pipe, index, numbers)) {
          results[static_cast<std::size_t>(index)] = std::move(numbers);
          finished(++done);
          continue;
        }
        close(running[w].pipe);
        while (waitpid(running[w].process, nullptr, 0) < 0 && errno == EINTR) {
        }
        running.erase(running.begin() + static_cast<std::ptrdiff_t>(w));
      }
    }
    if (done > 0) return results;
  }
  for (int t = 0; t < count; ++t) {  // one worker, or none could be started
    results[static_cast<std::size_t>(t)] = task(t);
    finished(++done);
  }
  return results;
}

}  // namespace lamprey::study
