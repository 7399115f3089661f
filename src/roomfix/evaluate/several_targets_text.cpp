#include "roomfix/evaluate/several_targets_text.hpp"

#include <fmt/format.h>

namespace roomfix {
namespace {

std::string confidently_wrong_text(const ConfidentlyWrong& wrong) {
    if (wrong.wrong == 0) return fmt::format("confidently wrong: none of {} ok fixes is farther than {} m from the truth", wrong.fixes, wrong.farther_than);
    return fmt::format("confidently wrong: {} of {} ok fixes ({:.2f} %) are farther than {} m from the truth; they state {:.3f} m (median)", wrong.wrong,
                       wrong.fixes, 100 * wrong.part(), wrong.farther_than, wrong.stated_sigma);
}

}  // namespace

std::string several_targets_heading(const ErrorReport& report) {
    return fmt::format("all robots together, over {} moments of the truth, cut-off {:.2f} m", report.gospa.moments, report.gospa.cutoff);
}

std::vector<std::pair<std::string, std::string>> several_targets_figures(const ErrorReport& report) {
    const Gospa& g = report.gospa;
    const IdentityScore& id = report.identities;
    if (id.true_positives + id.false_negatives == 0) return {};
    return {{"GOSPA", fmt::format("{:.3f} m on average; rms {:.3f} m (localisation {:.3f}, missed {:.3f}, false {:.3f}; their squares add up)", g.mean, g.rms,
                                  g.localisation, g.missed, g.false_ones)},
            {"", fmt::format("{:.2f} robots missed and {:.2f} false at a moment", g.missed_at_once, g.false_at_once)},
            {"IDF1", fmt::format("{:.3f} (precision {:.3f}, recall {:.3f})", id.f1(), id.precision(), id.recall())},
            {"HOTA", fmt::format("{:.3f} (DetA {:.3f}, AssA {:.3f})", report.hota.hota, report.hota.detection, report.hota.association)}};
}

std::vector<std::string> wrong_and_unknown(const ErrorReport& report) {
    std::vector<std::string> sentences;
    if (report.confidently_wrong.fixes > 0) sentences.push_back(confidently_wrong_text(report.confidently_wrong));
    const UnknownThings& things = report.unknown_things;
    if (!things.in_truth) {
        if (things.fixes > 0) sentences.push_back(fmt::format("unknown things: {} fixes; the truth has no robot 'unknown' to compare them with", things.fixes));
        return sentences;
    }
    std::string text = fmt::format("unknown things: found {:.1f} % of the time", 100 * things.found_part());
    if (things.found > 0) text += fmt::format(", mean error {:.3f} m", things.error.mean);
    text += things.minutes > 0 ? fmt::format(", {:.1f} false ones a minute", things.false_per_minute()) : fmt::format(", {} false ones", things.false_ones);
    sentences.push_back(text);
    sentences.push_back(fmt::format("robots put on what is no robot: {} of {} ok fixes ({:.2f} %)", things.robots_on_one, things.robot_fixes,
                                    100 * things.robots_on_one_part()));
    return sentences;
}

}  // namespace roomfix
