// The report on errors as text, as JSON, and as a page.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "roomfix/base/html.hpp"
#include "roomfix/evaluate/error_report.hpp"
#include "roomfix/evaluate/line_chart.hpp"
#include "roomfix/evaluate/several_targets_text.hpp"

namespace roomfix {
namespace {

using nlohmann::json;

constexpr std::size_t most_points = 1500;  // of one curve: a screen shows no more

double millimetres(double m) { return 1e3 * m; }

/// Degrees where there is anything to state.
std::string degrees_text(const Summary& yaw, double value) { return yaw.count > 0 ? fmt::format("{:.2f}", degrees(value)) : "-"; }

std::string row(const ErrorTable& t) {
    return fmt::format("{:24} {:7} {:8.1f} {:8.1f} {:8.1f} {:8.1f} {:8.1f}   {:>7} {:>7}   {:6.2f} {:>11} {:8.1f}{}\n", t.name, t.position.count,
                       millimetres(t.position.rms), millimetres(t.position.mean), millimetres(t.position.median), millimetres(t.position.p95),
                       millimetres(t.position.max), degrees_text(t.yaw, t.yaw.rms), degrees_text(t.yaw, t.yaw.p95), t.nees.mean,
                       fmt::format("{:.2f}-{:.2f}", t.nees.low, t.nees.high), millimetres(t.stated_sigma),
                       t.bound > 0 ? fmt::format(" {:8.1f} {:10.2f}", millimetres(t.bound), t.over_bound) : "");
}

json summary_json(const Summary& s) {
    if (s.count == 0) return {{"count", 0}};
    return {{"count", s.count}, {"rmse", s.rms}, {"mean", s.mean}, {"median", s.median}, {"p95", s.p95}, {"max", s.max}};
}

json consistency_json(const Consistency& c) { return {{"mean", c.mean}, {"band", {c.low, c.high}}, {"independent", c.independent}}; }

json table_json(const ErrorTable& t) {
    json j = {{"name", t.name},
              {"position", summary_json(t.position)},
              {"yaw", summary_json(t.yaw)},
              {"nees", consistency_json(t.nees)},
              {"stated_sigma", t.stated_sigma}};
    if (t.bound > 0) j["bound"] = {{"sigma", t.bound}, {"rmse_over_bound", t.over_bound}};
    return j;
}

void add_several_targets(const ErrorReport& report, json& j) {
    const Gospa& g = report.gospa;
    j["gospa"] = {{"cutoff", g.cutoff},
                  {"moments", g.moments},
                  {"mean", g.mean},
                  {"rms", g.rms},
                  {"localisation", g.localisation},
                  {"missed", g.missed},
                  {"false", g.false_ones},
                  {"missed_at_once", g.missed_at_once},
                  {"false_at_once", g.false_at_once}};
    const IdentityScore& id = report.identities;
    j["idf1"] = {{"idf1", id.f1()},           {"precision", id.precision()}, {"recall", id.recall()},
                 {"idtp", id.true_positives}, {"idfp", id.false_positives},  {"idfn", id.false_negatives}};
    j["hota"] = {{"hota", report.hota.hota}, {"deta", report.hota.detection}, {"assa", report.hota.association}};
    const ConfidentlyWrong& wrong = report.confidently_wrong;
    j["confidently_wrong"] = {{"farther_than", wrong.farther_than}, {"fixes", wrong.fixes}, {"wrong", wrong.wrong}, {"part", wrong.part()}};
    if (wrong.wrong > 0) j["confidently_wrong"]["stated_sigma"] = wrong.stated_sigma;
    const UnknownThings& things = report.unknown_things;
    j["unknown_things"] = {{"in_truth", things.in_truth}, {"fixes", things.fixes}};
    if (!things.in_truth) return;
    j["unknown_things"].update({{"found", things.found_part()},
                                {"error", summary_json(things.error)},
                                {"false_ones", things.false_ones},
                                {"minutes", things.minutes},
                                {"robot_fixes", things.robot_fixes},
                                {"robots_on_one", things.robots_on_one}});
}

std::string latency_text(const Summary& latency) {
    return fmt::format("Latency from frame to fix: mean {:.0f} ms, median {:.0f} ms, 95 % within {:.0f} ms, largest {:.0f} ms", 1e3 * latency.mean,
                       1e3 * latency.median, 1e3 * latency.p95, 1e3 * latency.max);
}

std::string ways_text(const ErrorReport& report) {
    if (report.relative_position.count == 0) return "not known, since no robot has two fixes one second apart";
    const std::string place = fmt::format("rmse {:.1f} mm", millimetres(report.relative_position.rms));
    return report.relative_yaw.count > 0 ? fmt::format("{}, {:.2f} deg", place, degrees(report.relative_yaw.rms)) : place;
}

/// What could not be compared, as sentences.
std::vector<std::string> left_out(const ErrorReport& report) {
    std::vector<std::string> sentences;
    if (report.without_true_yaw > 0) {
        sentences.push_back(
            fmt::format("The truth has no yaw beside {} of {} fixes: their x and y are judged alone.", report.without_true_yaw, report.fixes.size()));
    }
    for (const auto& [robot, count] : report.without_point) {
        sentences.push_back(fmt::format("Robot {}: {} fixes have no yaw, so that nobody knows where the point --point is; they are left out.", robot, count));
    }
    for (const std::string& robot : report.unknown_robots) {
        sentences.push_back(robot.empty() ? "Fixes of a camera that belongs to no robot are left out."
                                          : fmt::format("Robot {}: the truth does not know it. GOSPA, IDF1 and HOTA take it for false.", robot));
    }
    return sentences;
}

std::string html_row(const ErrorTable& t) {
    const bool honest = t.nees.mean >= t.nees.low && t.nees.mean <= t.nees.high;
    return fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{:.1f}</td><td>{:.1f}</td><td>{:.1f}</td><td>{:.1f}</td><td>{:.1f}</td><td>{}</td><td>{}</td>"
        "<td class=\"{}\">{:.2f}</td><td>{:.2f}&ndash;{:.2f}</td><td>{:.1f}</td>{}</tr>\n",
        html_escaped(t.name), t.position.count, millimetres(t.position.rms), millimetres(t.position.mean), millimetres(t.position.median),
        millimetres(t.position.p95), millimetres(t.position.max), degrees_text(t.yaw, t.yaw.rms), degrees_text(t.yaw, t.yaw.p95), honest ? "good" : "off",
        t.nees.mean, t.nees.low, t.nees.high, millimetres(t.stated_sigma),
        t.bound > 0 ? fmt::format("<td>{:.1f}</td><td>{:.2f}</td>", millimetres(t.bound), t.over_bound) : "");
}

/// Curves of all robots; long ones are thinned, but keep the worst of each stretch.
LineChart errors_over_time(const ErrorReport& report) {
    LineChart chart{"Position error over time", "time, s", "error, mm", {}, false};
    std::map<std::string, std::vector<Eigen::Vector2d>> curves;
    Nanoseconds start = report.fixes.empty() ? 0 : report.fixes.front().time;
    for (const JudgedFix& f : report.fixes) start = std::min(start, f.time);
    for (const JudgedFix& f : report.fixes) curves[f.robot].emplace_back(to_seconds(f.time - start), millimetres(f.error.head<2>().norm()));
    for (auto& [robot, points] : curves) {
        const std::size_t stride = points.size() / most_points + 1;
        Curve curve{robot, {}, false};
        for (std::size_t i = 0; i < points.size(); i += stride) {
            const auto end = points.begin() + static_cast<std::ptrdiff_t>(std::min(points.size(), i + stride));
            curve.points.push_back(
                *std::max_element(points.begin() + static_cast<std::ptrdiff_t>(i), end, [](const auto& a, const auto& b) { return a.y() < b.y(); }));
        }
        chart.curves.push_back(curve);
    }
    return chart;
}

LineChart distribution(const ErrorReport& report) {
    LineChart chart{"How many fixes are that good", "position error, mm", "fixes, %", {}, false};
    std::map<std::string, std::vector<double>> errors;
    for (const JudgedFix& f : report.fixes) errors[f.robot].push_back(millimetres(f.error.head<2>().norm()));
    for (auto& [robot, values] : errors) {
        std::sort(values.begin(), values.end());
        Curve curve{robot, {}, false};
        const double limit = values[static_cast<std::size_t>(0.995 * static_cast<double>(values.size() - 1))];
        for (int percent = 0; percent <= 100; ++percent) {
            const double value = values[static_cast<std::size_t>(percent / 100.0 * static_cast<double>(values.size() - 1))];
            curve.points.emplace_back(std::min(value, limit), percent);
        }
        chart.curves.push_back(curve);
    }
    return chart;
}

/// The true ways and the fixes on them, in map x and y.
std::string map_svg(const ErrorReport& report) {
    if (report.fixes.empty()) return "";
    Eigen::Vector2d low(1e300, 1e300), high(-1e300, -1e300);
    for (const JudgedFix& f : report.fixes) {
        for (const Pose2& p : {f.fix, f.truth}) {
            low = low.cwiseMin(Eigen::Vector2d(p.x, p.y));
            high = high.cwiseMax(Eigen::Vector2d(p.x, p.y));
        }
    }
    const double size = std::max({(high - low).maxCoeff(), 0.5});
    const double scale = 700 / size;
    constexpr double margin = 20;
    const auto at = [&](const Pose2& p) { return fmt::format("{:.1f},{:.1f}", margin + scale * (p.x - low.x()), margin + scale * (high.y() - p.y)); };
    std::map<std::string, std::vector<const JudgedFix*>> by_robot;
    for (const JudgedFix& f : report.fixes) by_robot[f.robot].push_back(&f);
    static const char* const colours[] = {"#1f6fb2", "#c2571a", "#3b8f3b", "#8a4fbf", "#b3323f", "#5a6b7a"};
    std::string lines;
    std::size_t colour = 0;
    for (const auto& [robot, fixes] : by_robot) {
        const std::size_t stride = fixes.size() / most_points + 1;
        std::string truth;
        for (std::size_t i = 0; i < fixes.size(); i += stride) truth += at(fixes[i]->truth) + " ";
        lines += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"#bbb\" stroke-width=\"5\" stroke-linejoin=\"round\"/>\n", truth);
    }
    for (const auto& [robot, fixes] : by_robot) {
        const char* ink = colours[colour++ % std::size(colours)];
        const std::size_t stride = fixes.size() / most_points + 1;
        for (std::size_t i = 0; i < fixes.size(); i += stride) {
            const std::string point = at(fixes[i]->fix);
            lines += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"1.6\" fill=\"{}\"/>\n", point.substr(0, point.find(',')), point.substr(point.find(',') + 1),
                                 fixes[i]->coasting ? "#e0a030" : ink);
        }
    }
    return fmt::format("<svg viewBox=\"0 0 {:.0f} {:.0f}\" width=\"760\" role=\"img\" aria-label=\"map\">{}</svg>\n", 2 * margin + scale * (high.x() - low.x()),
                       2 * margin + scale * (high.y() - low.y()), lines);
}

}  // namespace

std::string text_of(const ErrorReport& report) {
    std::string text = fmt::format("{:24} {:>7} {:>8} {:>8} {:>8} {:>8} {:>8}   {:>7} {:>7}   {:>6} {:>11} {:>8}{}\n", "", "fixes", "rmse mm", "mean", "median",
                                   "p95", "max", "yaw deg", "p95", "NEES/n", "95 % band", "stated", report.all.bound > 0 ? "    bound rmse/bound" : "");
    text += row(report.all);
    for (const ErrorTable& t : report.robots) text += row(t);
    text += "by source\n";
    for (const ErrorTable& t : report.sources) text += row(t);
    if (!report.nis.empty()) {
        text += "innovations, NIS per dimension (1 is truthful)\n";
        for (const auto& [source, c] : report.nis) text += fmt::format("{:24} {:.2f} ({:.2f}-{:.2f})\n", source, c.mean, c.low, c.high);
    }
    text += "way driven in 1 s: " + ways_text(report) + "\n";
    text += fmt::format("available {:.1f} % of the time, {:.1f} % of the fixes by prediction alone\n", 100 * report.availability, 100 * report.coasting);
    text += fmt::format("identity switches: {}, of which {} were flagged as doubtful\n", report.identity_switches, report.flagged_switches);
    if (report.misnamed > 0) {
        text += fmt::format(
            "names of another robot from the start: {}, of which {} were flagged as doubtful; rms from the robots that the names follow {:.1f} mm\n",
            report.misnamed, report.flagged_misnamed, 1000 * report.followed_rms);
    }
    if (const auto figures = several_targets_figures(report); !figures.empty()) {
        text += several_targets_heading(report) + "\n";
        for (const auto& [name, value] : figures) text += fmt::format("{:5}  {}\n", name, value);
    }
    for (const std::string& sentence : wrong_and_unknown(report)) text += sentence + "\n";
    if (report.latency.count > 0) text += latency_text(report.latency) + "\n";
    for (const std::string& sentence : left_out(report)) text += sentence + "\n";
    return text;
}

std::string json_of(const ErrorReport& report) {
    json j = {{"all", table_json(report.all)},
              {"relative", {{"position", summary_json(report.relative_position)}, {"yaw", summary_json(report.relative_yaw)}}},
              {"availability", report.availability},
              {"coasting", report.coasting},
              {"identity_switches", report.identity_switches},
              {"flagged_switches", report.flagged_switches},
              {"misnamed", report.misnamed},
              {"flagged_misnamed", report.flagged_misnamed},
              {"followed_rms", report.followed_rms},
              {"unknown_robots", report.unknown_robots},
              {"without_true_yaw", report.without_true_yaw},
              {"without_point", report.without_point}};
    add_several_targets(report, j);
    if (report.latency.count > 0) j["latency"] = summary_json(report.latency);
    for (const ErrorTable& t : report.robots) j["robots"].push_back(table_json(t));
    for (const ErrorTable& t : report.sources) j["sources"].push_back(table_json(t));
    for (const auto& [source, c] : report.nis) j["nis"][source] = consistency_json(c);
    return j.dump(1) + "\n";
}

std::string html_of(const ErrorReport& report, const std::string& title) {
    std::string rows = html_row(report.all);
    for (const ErrorTable& t : report.robots) rows += html_row(t);
    std::string source_rows;
    for (const ErrorTable& t : report.sources) source_rows += html_row(t);
    const bool bounded = report.all.bound > 0;
    const std::string head =
        std::string(
            "<tr><th></th><th>fixes</th><th>rmse mm</th><th>mean</th><th>median</th><th>p95</th><th>max</th><th>yaw rmse &deg;</th><th>yaw p95</th>"
            "<th>NEES per dimension</th><th>95 % band</th><th>stated sigma mm</th>") +
        (bounded ? "<th>bound mm</th><th>rmse / bound</th>" : "") + "</tr>\n";
    std::string nis;
    for (const auto& [source, c] : report.nis) {
        nis += fmt::format("<tr><td>{}</td><td>{:.2f}</td><td>{:.2f}&ndash;{:.2f}</td></tr>\n", html_escaped(source), c.mean, c.low, c.high);
    }
    std::string together;
    for (const auto& [name, value] : several_targets_figures(report)) together += fmt::format("<tr><td>{}</td><td class=\"text\">{}</td></tr>\n", name, value);
    if (!together.empty()) together = "<h2>Several targets</h2><p>" + several_targets_heading(report) + "</p>\n<table>" + together + "</table>\n";
    for (const std::string& sentence : wrong_and_unknown(report)) together += "<p>" + html_escaped(sentence) + "</p>\n";
    std::string remarks;
    for (const std::string& sentence : left_out(report)) remarks += "<p>" + html_escaped(sentence) + "</p>\n";
    if (!nis.empty()) nis = "<h2>Innovations</h2><table><tr><th>source</th><th>NIS per dimension</th><th>95 % band</th></tr>\n" + nis + "</table>\n";
    return fmt::format(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title><style>"
        "body{{font:15px/1.5 system-ui,sans-serif;max-width:1000px;margin:2em auto;padding:0 1em;color:#222}}"
        "table{{border-collapse:collapse;font-variant-numeric:tabular-nums}}td,th{{padding:.25em .6em;text-align:right;border-bottom:1px solid #ddd}}"
        "td:first-child,th:first-child,td.text{{text-align:left}}.good{{color:#2a7d2a}}.off{{color:#b3323f;font-weight:600}}h2{{margin-top:1.6em}}"
        "svg{{max-width:100%;height:auto}}</style></head><body>\n<h1>{0}</h1>\n"
        "<p>Available {1:.1f} % of the time; {2:.1f} % of the fixes by prediction alone. Way driven in one second: {3}. "
        "Identity switches: {4}, of which {5} were flagged as doubtful. {13}</p>\n{15}"
        "<h2>Errors</h2><table>{6}{7}</table>\n<h2>By source</h2><table>{6}{8}</table>\n{9}"
        "<p>NEES per dimension is 1 where the stated covariances are true; the band holds 95 % of such means, with fixes two seconds apart taken as "
        "independent.{14}</p>\n{16}<h2>Map</h2><p>Grey: the truth. Dots: fixes; amber ones by prediction alone.</p>\n{10}\n"
        "<h2>Over time</h2>{11}\n<h2>Distribution</h2>{12}\n</body></html>\n",
        html_escaped(title), 100 * report.availability, 100 * report.coasting, ways_text(report), report.identity_switches, report.flagged_switches, head, rows,
        source_rows, nis, map_svg(report), svg_of(errors_over_time(report)), svg_of(distribution(report)),
        report.latency.count == 0 ? "" : latency_text(report.latency) + ".",
        bounded ? " The bound is what the best tracker could reach with the same observations and the noise that they state." : "", remarks, together);
}

}  // namespace roomfix
