// Real data lies in $ROOMFIX_DATA or in ../shared/data beside the checkout; tests without it are skipped.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

namespace roomfix {

inline std::filesystem::path data_folder(const std::string& name) {
    const char* from_user = std::getenv("ROOMFIX_DATA");
    return (from_user ? std::filesystem::path(from_user) : std::filesystem::path(ROOMFIX_SOURCE).parent_path() / "shared/data") / name;
}

inline std::string text_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// The rows of a CSV file after its header, each by fields.
inline std::vector<std::vector<std::string>> csv_rows(const std::filesystem::path& file) {
    std::vector<std::vector<std::string>> rows;
    std::ifstream stream(file);
    std::string line;
    std::getline(stream, line);
    while (std::getline(stream, line)) {
        rows.emplace_back();
        std::istringstream fields(line);
        for (std::string field; std::getline(fields, field, ',');) rows.back().push_back(field);
    }
    return rows;
}

}  // namespace roomfix
