#include "roomfix/base/worker_pool.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

TEST(WorkerPool, DoesEveryJobOnceWhateverTheThreads) {
    for (const int threads : {1, 2, 5}) {
        WorkerPool pool(threads);
        for (int round = 0; round < 200; ++round) {
            std::vector<std::atomic<int>> done(static_cast<std::size_t>(round % 7));
            pool.run(static_cast<int>(done.size()), [&](int job) { ++done[static_cast<std::size_t>(job)]; });
            for (const auto& count : done) ASSERT_EQ(count, 1);
        }
    }
}

}  // namespace
}  // namespace roomfix
