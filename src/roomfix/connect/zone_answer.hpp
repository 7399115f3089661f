// What PUT and DELETE /api/zones/ID do: zones that are drawn on the page go into the site file.
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "roomfix/connect/web_answer.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// {"border": [[x, y], ...]}, m, map; corners to the millimetre. The error says what is wrong with it.
Result<Polyline> parse_zone_border(std::string_view json);

/// Changes the zones of a site file, one after the other, from several threads. What it writes can be used and differs in nothing but the zone: otherwise
/// the file stays as it is. The file as it was before the last change is kept beside it, with a ~ behind its name.
class ZoneEditor {
public:
    explicit ZoneEditor(std::filesystem::path site_file);
    ~ZoneEditor();
    ZoneEditor(ZoneEditor&&) noexcept;

    /// 200 with the zone, 400 where the JSON is wrong, 409 where the file has mistakes or cannot be changed so, 500 where it cannot be written.
    WebAnswer put(const WebQuestion& question);
    /// 204; 404 where there is no such zone; 409 and 500 as above.
    WebAnswer remove(const WebQuestion& question);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace roomfix
