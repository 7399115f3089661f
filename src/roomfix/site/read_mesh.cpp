#include "roomfix/site/read_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <string_view>

#include "roomfix/base/own_process.hpp"
#include "roomfix/base/text_file.hpp"
#include "roomfix/site/mesh_importer.hpp"
#include "roomfix/site/whole_mesh_file.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t most_bytes = 200'000'000;

/// Of a file's name: in small letters, without the dot.
std::string ending_of(const fs::path& file) {
    std::string ending = file.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return ending.empty() ? ending : ending.substr(1);
}

template <class T>
void put(std::string& text, const std::vector<T>& values) {
    const std::size_t count = values.size();
    text.append(reinterpret_cast<const char*>(&count), sizeof count);
    text.append(reinterpret_cast<const char*>(values.data()), count * sizeof(T));
}

template <class T>
void take(std::string_view& text, std::vector<T>& values) {
    std::size_t count = 0;
    std::memcpy(&count, text.data(), sizeof count);
    values.resize(count);
    if (count > 0) std::memcpy(static_cast<void*>(values.data()), text.data() + sizeof count, count * sizeof(T));  // an empty one has no address
    text.remove_prefix(sizeof count + count * sizeof(T));
}

/// From one process to its original: 'M' and the mesh, or 'E' and an error's words.
std::string packed(const Result<TriangleMesh>& mesh) {
    if (!mesh) return "E" + mesh.error().message;
    std::string text = "M";
    put(text, mesh->corners);
    put(text, mesh->triangles);
    return text;
}

Result<TriangleMesh> unpacked(std::string_view text) {
    if (text.front() == 'E') return Error{std::string(text.substr(1))};
    text.remove_prefix(1);
    TriangleMesh mesh;
    take(text, mesh.corners);
    take(text, mesh.triangles);
    return mesh;
}

}  // namespace

bool is_mesh_file(const fs::path& file) {
    const std::string ending = ending_of(file);
    const auto known = {"stl", "obj", "dae", "ply", "gltf", "glb"};
    return std::find(known.begin(), known.end(), ending) != known.end();
}

Result<std::string> read_model_file(const fs::path& file) {
    std::error_code failure;
    if (!fs::exists(file, failure)) return Error{fmt::format("{}: there is no such file: check the name", file.string())};
    if (!fs::is_regular_file(file, failure)) return Error{fmt::format("{}: is no file: name the model itself", file.string())};
    const std::uintmax_t bytes = fs::file_size(file, failure);
    if (failure || bytes > most_bytes)
        return Error{fmt::format("{}: has {} MB, {} MB are possible: simplify the model", file.string(), bytes / 1'000'000, most_bytes / 1'000'000)};
    return read_text(file);
}

Result<TriangleMesh> parse_mesh(const std::string& bytes, const fs::path& file, UpAxis up) {
    const std::string ending = ending_of(file);
    const auto damaged = [&](const std::string& reason) {
        return Error{fmt::format("{}: is no {} file, or a damaged one ({}): export the model again", file.string(), ending, reason)};
    };
    if (const auto whole = check_whole(bytes, ending); !whole) return damaged(whole.error().message);
    // Ten times what whole files need. Damaged ones make Assimp 5.2 loop for ever, and take memory while it does.
    const int megabytes = static_cast<int>(bytes.size() / 1'000'000);
    const int most_seconds = 3 + megabytes / 4;
    const int most_megabytes = 512 + 30 * megabytes;
    const auto result = in_own_process([&] { return packed(import_mesh(bytes, file, ending, up == UpAxis::as_stated)); }, most_seconds, most_megabytes);
    if (!result) return damaged("reading it " + result.error().message);
    auto mesh = unpacked(*result);
    if (!mesh) return damaged(mesh.error().message);
    if (mesh->triangles.empty()) return damaged("it has no triangles");
    if (ending == "gltf" || ending == "glb" || (ending == "dae" && up == UpAxis::as_stated)) {
        for (Eigen::Vector3d& p : mesh->corners) p = {p.x(), -p.z(), p.y()};
    }
    return mesh;
}

Result<TriangleMesh> read_mesh(const fs::path& file, UpAxis up) {
    const auto bytes = read_model_file(file);
    if (!bytes) return bytes.error();
    return parse_mesh(*bytes, file, up);
}

}  // namespace roomfix
