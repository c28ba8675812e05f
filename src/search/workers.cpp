#include "search/workers.hpp"

#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

#include "optimizer/ipopt.hpp"

namespace lamprey::search {

namespace {

using Numbers = std::vector<double>;

constexpr std::int64_t thrown = -1;  // in place of a message's count

// The exception of the first task that threw, by number, whichever ended first.
class FirstFailure {
 public:
  // From where the exception is being handled.
  void take(int task) {
    const std::scoped_lock lock(mutex_);
    if (any_ && task_ < task) return;
    any_ = true;
    task_ = task;
    exception_ = std::current_exception();
  }
  bool any() const { return any_; }
  void go_on() const {
    if (exception_) std::rethrow_exception(exception_);
  }

 private:
  std::mutex mutex_;
  std::atomic<bool> any_ = false;
  int task_ = 0;
  std::exception_ptr exception_;
};

struct Worker {
  pid_t process;
  int pipe;
  int task;
};

void bury(const Worker& worker) {
  close(worker.pipe);
  while (waitpid(worker.process, nullptr, 0) < 0 && errno == EINTR) {
  }
}

// Workers that run; those that still do when an exception passes here are ended.
struct Crew : std::vector<Worker> {
  ~Crew() {
    for (const Worker& worker : *this) {
      kill(worker.process, SIGKILL);
      bury(worker);
    }
  }
};

struct Message {
  bool threw = false;
  std::optional<Numbers> numbers;  // nothing: the task threw, or its process died
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

// A message is the count of numbers, and these; or that the task threw.
bool send(int file, const Numbers& numbers) {
  const std::int64_t count = static_cast<std::int64_t>(numbers.size());
  return write_all(file, &count, sizeof count) && write_all(file, numbers.data(), numbers.size() * sizeof(double));
}

Message receive(int file) {
  std::int64_t count = 0;
  if (!read_all(file, &count, sizeof count)) return {};
  if (count == thrown) return {.threw = true, .numbers = {}};
  Numbers numbers(static_cast<std::size_t>(count));
  if (!read_all(file, numbers.data(), numbers.size() * sizeof(double))) return {};
  return {.threw = false, .numbers = std::move(numbers)};
}

[[noreturn]] void work(int pipe, int t, const std::function<Numbers(int)>& task) {
  bool sent = false;
  try {
    sent = send(pipe, task(t));
  } catch (...) {  // which no other process can catch
    sent = write_all(pipe, &thrown, sizeof thrown);
  }
  _exit(sent ? 0 : 1);
}

// A process for one task, so that its death costs no other; nothing where the machine gives no more processes.
std::optional<Worker> start(int t, const std::function<Numbers(int)>& task) {
  std::fflush(nullptr);  // a child must not write the parent's buffers again
  int ends[2];
  if (pipe(ends) != 0) return std::nullopt;
  std::unique_lock<std::mutex> turn = optimizer::turn_of_ipopt();
  const pid_t process = fork();
  turn.unlock();
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
std::size_t next_to_finish(const Crew& running) {
  std::vector<pollfd> waiting;
  for (const Worker& worker : running) waiting.push_back({worker.pipe, POLLIN, 0});
  while (poll(waiting.data(), waiting.size(), -1) < 0)  // a signal: workers end by themselves
    if (errno != EINTR && errno != EAGAIN)
      throw std::system_error(errno, std::generic_category(), "waiting for workers");
  std::size_t first = 0;
  while (waiting[first].revents == 0) ++first;
  return first;
}

Message finish(const Worker& worker) {
  Message message = receive(worker.pipe);
  bury(worker);
  return message;
}

}  // namespace

void run_in_threads(int count, int workers, const std::function<void(int)>& task) {
  std::atomic<int> next = 0;
  FirstFailure failure;
  const auto work = [&] {
    // numbers go out in order, so that all tasks before one that throws begin
    for (int t = 0; !failure.any() && (t = next++) < count;) {
      try {
        task(t);
      } catch (...) {
        failure.take(t);
      }
    }
  };
  {
    std::vector<std::jthread> others;
    try {
      for (int t = 1; t < std::min(workers, count); ++t) others.emplace_back(work);
    } catch (const std::system_error&) {  // no more threads: those that there are do all tasks
    }
    work();
  }
  failure.go_on();
}

std::vector<std::optional<Numbers>> run_in_workers(int count, int workers, const std::function<Numbers(int)>& task,
                                                   const Finished& finished, const std::function<bool()>& stopped) {
  std::vector<std::optional<Numbers>> results(static_cast<std::size_t>(count));
  Crew running;
  int next = 0;
  std::optional<int> threw;  // the first task by number that did
  for (int done = 0; done < count;) {
    if (next > 0 && next < count && (threw || (stopped && stopped()))) {
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
    int ended = next;
    if (running.empty()) {  // one worker or one task, or no process could be started
      results[static_cast<std::size_t>(next)] = task(next);
      ++next;
    } else {
      const std::size_t w = next_to_finish(running);
      const Worker worker = running[w];
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(w));
      Message message = finish(worker);
      ended = worker.task;
      results[static_cast<std::size_t>(ended)] = std::move(message.numbers);
      if (message.threw) threw = std::min(threw.value_or(worker.task), worker.task);
    }
    finished(++done, results[static_cast<std::size_t>(ended)]);
  }
  if (threw) results[static_cast<std::size_t>(*threw)] = task(*threw);  // its exception goes on from here
  return results;
}

}  // namespace lamprey::search
