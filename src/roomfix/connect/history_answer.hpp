// What /api/history answers.
#pragma once

#include <string>
#include <vector>

#include "roomfix/connect/fix_store.hpp"
#include "roomfix/connect/web_answer.hpp"

namespace roomfix {

/// A question for fixes and the form of its answer.
struct HistoryRequest {
    FixQuery query;
    bool csv = false;
};

/// `robot`; `zone` (of events); `from` and `to` (s); `area=x1,y1,x2,y2` (m); `limit` (1 to 100000, default 10000); `order=newest` (default) or `oldest`;
/// `format=jsonl` (default) or `csv`. Each once at most; the error says what is wrong with one of them.
Result<HistoryRequest> parse_history_request(const WebParameters& parameters);

/// Fixes as CSV with a header: time,robot,kind,status,x,y,yaw,xx,xy,xyaw,yy,yyaw,yawyaw,sources (s, m, rad; sources separated by blanks).
std::string fixes_csv(const std::vector<Fix>& fixes);

/// One line of JSON: time, robot, zone, event (enter or leave).
std::string zone_event_line(const ZoneEvent& event);

/// 200 with the events of zones, one a line; errors as below.
WebAnswer answer_zone_history(FixStore& store, const WebParameters& parameters);

/// 200 with the fixes, 400 where the question is wrong, 503 where the database does not answer.
WebAnswer answer_history(FixStore& store, const WebParameters& parameters);

}  // namespace roomfix
