#include "roomfix/site/read_urdf.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <map>
#include <optional>
#include <vector>

#include "roomfix/base/number.hpp"
#include "roomfix/site/mesh_importer.hpp"
#include "roomfix/site/read_mesh.hpp"
#include "roomfix/site/urdf_mesh_file.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;
using Element = tinyxml2::XMLElement;

constexpr double largest = 1000;  // m: no number of a robot is larger

struct Joint {
    std::string parent, child;
    Eigen::Isometry3d parent_from_child;
    int line = 0;
};

/// Reads one file; the first problem ends it.
class UrdfReader {
public:
    explicit UrdfReader(const fs::path& file) : file_(file) {}

    Result<UrdfModel> read(const std::string& text) {
        tinyxml2::XMLDocument document;
        if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
            const std::string problem = document.ErrorName() ? document.ErrorName() : "unknown";
            return Error{fmt::format("{}:{}: is no URDF, or a damaged one ({})", file_.string(), document.ErrorLineNum(), problem)};
        }
        const Element* robot = document.FirstChildElement("robot");
        if (!robot) {
            const Element* root = document.RootElement();
            return Error{fmt::format("{}: is no URDF: its outermost element is <{}>, not <robot>", file_.string(), root ? root->Name() : "")};
        }
        if (text.find("<xacro:") != std::string::npos) {
            return Error{fmt::format("{}: is a xacro file: make a URDF of it with 'xacro {} > {}'", file_.string(), file_.filename().string(),
                                     file_.stem().stem().string() + ".urdf")};
        }
        read_links(*robot);
        read_joints(*robot);
        UrdfModel model;
        place_links();
        if (!problem_) build(model);
        if (problem_) return *problem_;
        return model;
    }

private:
    void fail(int line, const std::string& message) {
        if (!problem_) problem_ = Error{fmt::format("{}:{}: {}", file_.string(), line, message)};
    }

    std::string text(const Element& element, const char* name) {
        const char* value = element.Attribute(name);
        if (!value) fail(element.GetLineNum(), fmt::format("<{}> needs the attribute '{}'", element.Name(), name));
        return value ? value : "";
    }

    /// Blanks between `count` numbers.
    Eigen::Vector3d numbers(const Element& element, const char* name, int count, double least) {
        const std::string value = text(element, name);
        Eigen::Vector3d result = Eigen::Vector3d::Zero();
        int found = 0;
        for (std::size_t from = 0; (from = value.find_first_not_of(" \t\r\n", from)) != std::string::npos;) {
            const std::size_t end = std::min(value.find_first_of(" \t\r\n", from), value.size());
            const auto number = parse_number(std::string_view(value).substr(from, end - from));
            if (number && found < count && *number >= least && *number <= largest) result[found] = *number;
            found = number && *number >= least && *number <= largest ? found + 1 : 100;
            from = end;
        }
        if (found != count && !problem_) {
            fail(element.GetLineNum(), fmt::format("{}=\"{}\" of <{}> must be {} number{} from {:g} to {:g}", name, value.substr(0, 60), element.Name(), count,
                                                   count > 1 ? "s" : "", least, largest));
        }
        return result;
    }

    /// The pose of an element by its <origin>; fixed axes x, y, z in turn.
    Eigen::Isometry3d pose(const Element& element) {
        Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
        const Element* origin = element.FirstChildElement("origin");
        if (!origin) return result;
        if (origin->Attribute("xyz")) result.translation() = numbers(*origin, "xyz", 3, -largest);
        if (origin->Attribute("rpy")) {
            const Eigen::Vector3d rpy = numbers(*origin, "rpy", 3, -largest);
            result.linear() = (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
                                  .toRotationMatrix();
        }
        return result;
    }

    void read_links(const Element& robot) {
        for (const Element* link = robot.FirstChildElement("link"); link; link = link->NextSiblingElement("link")) {
            const std::string name = text(*link, "name");
            if (!links_.emplace(name, link).second) fail(link->GetLineNum(), fmt::format("there are two links '{}'", name));
        }
        if (links_.empty()) fail(robot.GetLineNum(), "the robot has no links");
    }

    void read_joints(const Element& robot) {
        for (const Element* element = robot.FirstChildElement("joint"); element; element = element->NextSiblingElement("joint")) {
            const Element* parent = element->FirstChildElement("parent");
            const Element* child = element->FirstChildElement("child");
            if (!parent || !child) return fail(element->GetLineNum(), "a joint needs <parent> and <child>");
            Joint joint{text(*parent, "link"), text(*child, "link"), pose(*element), element->GetLineNum()};
            for (const std::string& name : {joint.parent, joint.child}) {
                if (!links_.contains(name)) return fail(joint.line, fmt::format("a joint names the link '{}', which does not exist", name));
            }
            if (!above_.emplace(joint.child, joint).second) fail(joint.line, fmt::format("the link '{}' hangs on two joints", joint.child));
        }
    }

    /// Where each link is as seen from the root.
    void place_links() {
        if (problem_) return;
        std::vector<std::string> roots;
        std::multimap<std::string, const Joint*> below;
        for (const auto& [name, link] : links_) {
            if (!above_.contains(name)) roots.push_back(name);
        }
        for (const auto& [name, joint] : above_) below.emplace(joint.parent, &joint);
        if (roots.size() > 1) {
            return fail(links_.at(roots[1])->GetLineNum(), fmt::format("no joint connects the links '{}' and '{}': add a fixed one", roots[0], roots[1]));
        }
        if (!roots.empty()) root_from_link_.emplace(roots[0], Eigen::Isometry3d::Identity());
        for (std::vector<std::string> open = roots; !open.empty();) {
            const std::string name = open.back();
            open.pop_back();
            const auto [first, last] = below.equal_range(name);
            for (auto entry = first; entry != last; ++entry) {
                root_from_link_.emplace(entry->second->child, root_from_link_.at(name) * entry->second->parent_from_child);
                open.push_back(entry->second->child);
            }
        }
        if (root_from_link_.size() < links_.size()) return fail(above_.begin()->second.line, "joints go round in a circle");
        root_ = roots[0];
    }

    void build(UrdfModel& model) {
        model.stands_on_floor = links_.contains("base_footprint");
        model.origin = model.stands_on_floor ? "base_footprint" : links_.contains("base_link") ? "base_link" : root_;
        const Eigen::Isometry3d origin_from_root = root_from_link_.at(model.origin).inverse();
        for (const auto& [name, link] : links_) {
            const bool visible = link->FirstChildElement("visual") && link->FirstChildElement("visual")->FirstChildElement("geometry");
            const char* kind = visible ? "visual" : "collision";
            for (const Element* item = link->FirstChildElement(kind); item && !problem_; item = item->NextSiblingElement(kind)) {
                const Element* geometry = item->FirstChildElement("geometry");
                if (!geometry) continue;
                add_solid(*geometry, origin_from_root * root_from_link_.at(name) * pose(*item), model.mesh);
                if (model.mesh.triangles.size() > most_triangles)
                    fail(item->GetLineNum(), fmt::format("the meshes have more than {} million triangles: simplify them", most_triangles / 1'000'000));
            }
        }
        if (!problem_ && model.mesh.triangles.empty()) problem_ = Error{fmt::format("{}: no link has a geometry: there is nothing to see", file_.string())};
    }

    void add_solid(const Element& geometry, const Eigen::Isometry3d& place, TriangleMesh& mesh) {
        const Element* solid = geometry.FirstChildElement();
        const std::string kind = solid ? solid->Name() : "";
        constexpr double least = 1e-6;  // m
        if (kind == "box") {
            append(mesh, box_mesh(numbers(*solid, "size", 3, least)), Eigen::Affine3d(place));
        } else if (kind == "cylinder") {
            append(mesh, cylinder_mesh(numbers(*solid, "radius", 1, least)[0], numbers(*solid, "length", 1, least)[0]), Eigen::Affine3d(place));
        } else if (kind == "sphere") {
            append(mesh, ball_mesh(numbers(*solid, "radius", 1, least)[0]), Eigen::Affine3d(place));
        } else if (kind == "mesh") {
            const Eigen::Vector3d scale = solid->Attribute("scale") ? numbers(*solid, "scale", 3, -largest) : Eigen::Vector3d::Ones();
            if (const TriangleMesh* part = mesh_of(*solid)) append(mesh, *part, Eigen::Affine3d(place) * Eigen::Scaling(scale));
        } else {
            fail(geometry.GetLineNum(), fmt::format("a geometry must be box, cylinder, sphere or mesh, not '{}'", kind));
        }
    }

    /// Read once, however many wheels there are. Null, with the problem noted, where it cannot be read.
    const TriangleMesh* mesh_of(const Element& element) {
        const auto path = urdf_mesh_file(text(element, "filename"), file_);
        if (!path) fail(element.GetLineNum(), path.error().message);
        if (problem_) return nullptr;
        if (!is_mesh_file(*path)) fail(element.GetLineNum(), fmt::format("{} is no mesh: STL, OBJ, DAE, PLY, GLTF and GLB are read", path->string()));
        auto entry = meshes_.find(*path);
        if (entry == meshes_.end() && !problem_) {
            auto mesh = read_mesh(*path, UpAxis::ignored);
            if (!mesh) fail(element.GetLineNum(), mesh.error().message);
            if (mesh) entry = meshes_.emplace(*path, std::move(*mesh)).first;
        }
        return problem_ ? nullptr : &entry->second;
    }

    fs::path file_;
    std::optional<Error> problem_;
    std::map<std::string, const Element*> links_;
    std::map<std::string, Joint> above_;  // by the link that hangs on it
    std::map<std::string, Eigen::Isometry3d> root_from_link_;
    std::string root_;
    std::map<fs::path, TriangleMesh> meshes_;
};

}  // namespace

Result<UrdfModel> parse_urdf(const std::string& text, const fs::path& file) { return UrdfReader(file).read(text); }

Result<UrdfModel> read_urdf(const fs::path& file) {
    const auto text = read_model_file(file);
    if (!text) return text.error();
    return parse_urdf(*text, file);
}

}  // namespace roomfix
