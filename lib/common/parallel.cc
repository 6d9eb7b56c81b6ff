#include "lib/common/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstddef>

#include "lib/common/error.h"

namespace secondlook {

void ParallelFor(int count, const std::function<void(int)>& body) {
  tbb::parallel_for(
      0, count, [&](int i) { body(i); }, tbb::simple_partitioner());
}

ThreadLimit::ThreadLimit(int threads) : control_(nullptr) {
  if (threads < 1) Throw<InvalidArgument>("threads = {}; it must be at least 1", threads);
  control_ = new tbb::global_control(tbb::global_control::max_allowed_parallelism,
                                     static_cast<std::size_t>(threads));
}

ThreadLimit::~ThreadLimit() { delete static_cast<tbb::global_control*>(control_); }

}  // namespace secondlook
