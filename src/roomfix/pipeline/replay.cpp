#include "roomfix/pipeline/replay.hpp"

#include "roomfix/pipeline/source_runner.hpp"

namespace roomfix {

Result<Replayed> replay(const Site& site, const ReplaySettings& settings) {
    auto tracker = SiteTracker::create(site);
    if (!tracker) return tracker.error();
    if (auto learned = learn_backgrounds(**tracker, settings.background, settings.listener); !learned) return learned.error();
    if (settings.keep_history) (*tracker)->keep_history();
    const auto fixes = std::make_shared<std::vector<Fix>>();  // the tracker keeps its listeners
    (*tracker)->on_fixes([fixes](const FixBatch& batch) { fixes->insert(fixes->end(), batch.given.begin(), batch.given.end()); });
    SourceRunner runner(**tracker);
    const std::atomic<bool> never{false};
    const RunSettings run{.speed = 0, .threads = settings.threads};
    if (auto ran = runner.run(run, settings.stop ? *settings.stop : never, settings.progress); !ran) return ran.error();
    return Replayed{std::move(*tracker), std::move(*fixes)};
}

}  // namespace roomfix
