#include "command_line/threads.h"

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/recordings/error.h>

#include <future>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace fuse_flow::command_line {

void requireThreads(unsigned int threads) {
  const int wanted = host::resolveThreads(static_cast<int>(threads));
  std::promise<void> all_started;
  const std::shared_future<void> end = all_started.get_future().share();
  std::vector<std::thread> started;
  std::string problem;
  try {
    for (int k = 1; k < wanted; ++k) started.emplace_back([end] { end.wait(); });  // at once, as the pool keeps them
  } catch (const std::system_error& error) {
    problem = error.code().message();
  }
  all_started.set_value();
  for (std::thread& thread : started) thread.join();
  if (!problem.empty())
    throw io::InputError("of " + std::to_string(wanted) + " threads only " + std::to_string(started.size() + 1) +
                         " can be started: " + problem + "; --threads asks for fewer");
}

}  // namespace fuse_flow::command_line
