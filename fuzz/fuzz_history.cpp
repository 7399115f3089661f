// Any bytes as a question to /api/history, down to what the database is asked.
#include <cstddef>
#include <cstdint>
#include <string>

#include "roomfix/connect/history_answer.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace roomfix;
    static const auto store = FixStore::open(":memory:", "fuzz");
    // name=value pairs, separated by &
    WebParameters parameters;
    std::string text(reinterpret_cast<const char*>(data), size);
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('&', begin), text.size());
        const std::string pair = text.substr(begin, end - begin);
        const std::size_t equals = std::min(pair.find('='), pair.size());
        parameters.emplace(pair.substr(0, equals), equals < pair.size() ? pair.substr(equals + 1) : "");
        begin = end + 1;
    }
    const auto request = parse_history_request(parameters);
    const WebAnswer answer = answer_history(**store, parameters);
    const bool fine = request && request->query.zone.empty();   // that is of events only
    if (answer.status != (fine ? 200 : 400)) __builtin_trap();  // an SQL error would be 503
    if (answer_zone_history(**store, parameters).status == 503) __builtin_trap();
    if (!request) return 0;
    const FixQuery& query = request->query;
    const bool area = !query.area || (query.area->x_from <= query.area->x_to && query.area->y_from <= query.area->y_to);
    if (query.limit < 1 || query.limit > 100000 || !area) __builtin_trap();
    return 0;
}
