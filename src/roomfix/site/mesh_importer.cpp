#include "roomfix/site/mesh_importer.hpp"

#include <assimp/BaseImporter.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <set>
#include <utility>
#include <vector>

#include "roomfix/base/text_file.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

constexpr unsigned most_corners = 1000;  // of a polygon: cutting it up takes quadratic time
constexpr std::size_t most_nodes = 100'000;

/// The file itself, and the numbers of a glTF that stand in files beside it. Materials and pictures are not there for Assimp.
class ModelFiles : public Assimp::IOSystem {
public:
    ModelFiles(const fs::path& file, const std::string& bytes) : file_(file.string()), bytes_(bytes) {}

    bool Exists(const char* name) const override { return name == file_ || beside(name); }
    char getOsSeparator() const override { return '/'; }
    Assimp::IOStream* Open(const char* name, const char* mode) override {
        if (std::strchr(mode, 'w')) return nullptr;
        if (name == file_) return stream(bytes_);
        if (!beside(name)) return nullptr;
        const auto more = read_text(name);
        return more ? stream(*more) : nullptr;
    }
    void Close(Assimp::IOStream* stream) override { delete stream; }

private:
    bool beside(const std::string& name) const {
        const fs::path path = fs::path(name).lexically_normal();
        const fs::path relative = path.lexically_relative(fs::path(file_).parent_path().lexically_normal());
        std::error_code failure;
        return path.extension() == ".bin" && !relative.empty() && *relative.begin() != ".." && fs::is_regular_file(path, failure);
    }
    static Assimp::IOStream* stream(const std::string& bytes) {
        auto* copy = new std::uint8_t[bytes.size() + 1];
        std::memcpy(copy, bytes.data(), bytes.size());
        return new Assimp::MemoryIOStream(copy, bytes.size(), true);
    }

    std::string file_;
    const std::string& bytes_;
};

/// Leaves only the readers of one format: others would otherwise be tried on a file that this one refuses.
void keep_format(Assimp::Importer& importer, const std::string& ending) {
    for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
        Assimp::BaseImporter* reader = importer.GetImporter(i);
        std::set<std::string> endings;
        reader->GetExtensionList(endings);
        if (endings.contains(ending)) continue;
        importer.UnregisterLoader(reader);
        delete reader;
    }
}

/// Faces that name no corner, or one that does not exist, are what a truncated file leaves; Assimp itself does not look.
Result<void> check_faces(const aiScene& scene) {
    for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
        const aiMesh& mesh = *scene.mMeshes[m];
        for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
            const aiFace& face = mesh.mFaces[f];
            if (face.mNumIndices == 0) return Error{fmt::format("face {} has no corners", f)};
            if (face.mNumIndices > most_corners) return Error{fmt::format("face {} has {} corners, {} are possible", f, face.mNumIndices, most_corners)};
            for (unsigned i = 0; i < face.mNumIndices; ++i) {
                if (face.mIndices[i] >= mesh.mNumVertices) return Error{fmt::format("face {} names a corner that does not exist", f)};
            }
        }
    }
    return {};
}

Eigen::Affine3d affine(const aiMatrix4x4& m) {
    Eigen::Affine3d pose = Eigen::Affine3d::Identity();
    pose.matrix().topRows<3>() << static_cast<double>(m.a1), static_cast<double>(m.a2), static_cast<double>(m.a3), static_cast<double>(m.a4),
        static_cast<double>(m.b1), static_cast<double>(m.b2), static_cast<double>(m.b3), static_cast<double>(m.b4), static_cast<double>(m.c1),
        static_cast<double>(m.c2), static_cast<double>(m.c3), static_cast<double>(m.c4);
    return pose;
}

TriangleMesh triangles_of(const aiMesh& mesh) {
    TriangleMesh triangles;
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
        const aiVector3D& p = mesh.mVertices[v];
        triangles.corners.emplace_back(static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z));
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        const aiFace& face = mesh.mFaces[f];
        if (face.mNumIndices != 3) continue;
        triangles.triangles.push_back({static_cast<int>(face.mIndices[0]), static_cast<int>(face.mIndices[1]), static_cast<int>(face.mIndices[2])});
    }
    return triangles;
}

/// All meshes where the nodes of the scene put them.
Result<TriangleMesh> placed(const aiScene& scene) {
    TriangleMesh all;
    std::vector<std::pair<const aiNode*, Eigen::Affine3d>> open = {{scene.mRootNode, Eigen::Affine3d::Identity()}};
    for (std::size_t nodes = 0; !open.empty(); ++nodes) {
        if (nodes > most_nodes) return Error{"its parts are placed too often"};
        const auto [node, above] = open.back();
        open.pop_back();
        const Eigen::Affine3d pose = above * affine(node->mTransformation);
        for (unsigned m = 0; m < node->mNumMeshes; ++m) {
            const TriangleMesh mesh = triangles_of(*scene.mMeshes[node->mMeshes[m]]);
            if (mesh.triangles.empty()) continue;
            append(all, mesh, pose);
            if (all.triangles.size() > most_triangles)
                return Error{fmt::format("it has more than {} million triangles: simplify it first", most_triangles / 1'000'000)};
        }
        for (unsigned c = 0; c < node->mNumChildren; ++c) open.emplace_back(node->mChildren[c], pose);
    }
    for (const Eigen::Vector3d& p : all.corners) {
        if (!p.allFinite()) return Error{"a corner's place is no number"};
    }
    return all;
}

}  // namespace

Result<TriangleMesh> import_mesh(const std::string& bytes, const fs::path& file, const std::string& ending, bool collada_up) {
    Assimp::Importer importer;
    keep_format(importer, ending);
    importer.SetIOHandler(new ModelFiles(file, bytes));  // the importer deletes it
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, !collada_up);
    const aiScene* scene = importer.ReadFile(file.string(), 0);
    if (!scene || !scene->mRootNode) return Error{importer.GetErrorString()};
    if (const auto fine = check_faces(*scene); !fine) return fine.error();
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
    if (!scene) return Error{importer.GetErrorString()};
    return placed(*scene);
}

}  // namespace roomfix
