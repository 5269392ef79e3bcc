// What does a general library take for a scene of `throng bench plan`? RRTConnect of OMPL with collision checks by FCL, on what
// `cargo run --release --manifest-path research/Cargo.toml -- plan --scene arm-static --plain arm.json` writes.
//
// On Debian: apt-get install libompl-dev libfcl-dev nlohmann-json3-dev
//   # With -march=native, Eigen would lay out its numbers otherwise than the libraries.
//   g++ -O3 -std=c++17 -I/usr/include/ompl-1.5 -I/usr/include/eigen3 research/ompl.cpp -o ompl -lompl -lfcl -lccd
//   ./ompl arm.json [SEEDS=100] [RESOLUTION_RAD=0.02]
//
// Prints median and 95th percentile of 100 seeds: until the first way, with OMPL's own simplification, looks, time of a look, turns
// of all joints. Ways are looked at ten times as finely afterwards: in how many there is something in the way that was missed.
#include <fcl/fcl.h>
#include <ompl/base/ScopedState.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/PathSimplifier.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/config.h>
#include <chrono>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

namespace ob = ompl::base;
namespace og = ompl::geometric;
using Json = nlohmann::json;
using Vec = Eigen::Vector3d;
using Quat = Eigen::Quaterniond;
using Object = fcl::CollisionObjectd;
using Coordinates = std::vector<std::array<double, 3>>;

static Vec vec(const Json& j) { return Vec(j[0], j[1], j[2]); }
static Quat quat(const Json& j) { return Quat(j[3].get<double>(), j[0], j[1], j[2]); }
static Quat rotation(const Vec& v) {
    const double angle = v.norm();
    return angle < 1e-12 ? Quat::Identity() : Quat(Eigen::AngleAxisd(angle, v / angle));
}
static double seconds_since(std::chrono::steady_clock::time_point from) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
}

struct Joint {
    Vec offset, bone, axes[2];
    Quat centre;
    double bounds[3][2];
    bool is_ellipse, mirrored;

    explicit Joint(const Json& j)
        : offset(vec(j["offset"])), bone(vec(j["bone"])), axes{vec(j["axes"][0]), vec(j["axes"][1])}, centre(quat(j["centre"])),
          is_ellipse(j["is_ellipse"]), mirrored(j["mirrored"]) {
        for (int k = 0; k < 3; k++)
            for (int side = 0; side < 2; side++) bounds[k][side] = j["bounds"][k][side];
    }
    Quat turn(const std::array<double, 3>& c) const {
        const Quat q = centre * rotation(axes[0] * c[0] + axes[1] * c[1]) * rotation(bone * c[2]);
        return mirrored ? Quat(q.w(), q.x(), -q.y(), -q.z()) : q;
    }
    bool holds(const std::array<double, 3>& c) const {
        const double x = c[0] / bounds[0][1], y = c[1] / bounds[1][1];
        if (is_ellipse && x * x + y * y > 1.0 + 1e-9) return false;
        for (int k = is_ellipse ? 2 : 0; k < 3; k++)
            if (c[k] < bounds[k][0] - 1e-9 || c[k] > bounds[k][1] + 1e-9) return false;
        return true;
    }
};

// A capsule by its core, placed so that its own axis is z.
static std::pair<std::shared_ptr<fcl::Capsuled>, fcl::Transform3d> capsule(const Vec& a, const Vec& b, double radius) {
    fcl::Transform3d at = fcl::Transform3d::Identity();
    at.linear() = Quat::FromTwoVectors(Vec::UnitZ(), b - a).toRotationMatrix();
    at.translation() = 0.5 * (a + b);
    return {std::make_shared<fcl::Capsuled>(radius, (b - a).norm()), at};
}

struct Scene {
    std::vector<Joint> joints;
    fcl::Transform3d base = fcl::Transform3d::Identity();
    std::vector<Object> obstacles;
    // The moving one grown by how far it has to stay away.
    struct Pair {
        size_t joint, obstacle;
        fcl::Transform3d at;
        std::shared_ptr<Object> grown;
    };
    std::vector<Pair> pairs;
    // Which coordinates are free: no play of hinges, no twist of the last joint.
    std::vector<std::array<size_t, 2>> free;
    mutable size_t looks = 0;

    explicit Scene(const Json& j) {
        for (const auto& joint : j["joints"]) joints.emplace_back(joint);
        base.translation() = vec(j["base"][0]);
        base.linear() = quat(j["base"][1]).toRotationMatrix();
        for (const auto& o : j["obstacles"]) {
            if (o.contains("capsule")) {
                const auto [shape, at] = capsule(vec(o["capsule"]["core"][0]), vec(o["capsule"]["core"][1]), o["capsule"]["radius"]);
                obstacles.emplace_back(shape, at);
            } else if (o.contains("box")) {
                const Vec size = 2.0 * vec(o["box"]["half"]);
                fcl::Transform3d at = fcl::Transform3d::Identity();
                at.translation() = vec(o["box"]["at"][0]);
                at.linear() = quat(o["box"]["at"][1]).toRotationMatrix();
                obstacles.emplace_back(std::make_shared<fcl::Boxd>(size), at);
            } else {
                auto mesh = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
                mesh->beginModel();
                for (const auto& t : o["mesh"]["triangles"]) mesh->addTriangle(vec(t[0]), vec(t[1]), vec(t[2]));
                mesh->endModel();
                obstacles.emplace_back(mesh, fcl::Transform3d::Identity());
            }
            obstacles.back().computeAABB();
        }
        for (const auto& p : j["pairs"]) {
            const auto& part = j["parts"][p[0].get<size_t>()];
            const auto [shape, at] = capsule(vec(part["core"][0]), vec(part["core"][1]), part["radius"].get<double>() + p[2].get<double>());
            pairs.push_back({part["joint"], p[1], at, std::make_shared<Object>(shape, at)});
        }
        for (size_t i = 0; i < joints.size(); i++)
            for (size_t k = 0; k < 3; k++)
                if (!(k == 1 && !joints[i].is_ellipse) && !(k == 2 && i + 1 == joints.size())) free.push_back({i, k});
    }
    bool is_free(const Coordinates& c) const {
        looks++;
        std::vector<fcl::Transform3d> placed;
        fcl::Transform3d at = base;
        for (size_t i = 0; i < joints.size(); i++) {
            if (!joints[i].holds(c[i])) return false;
            fcl::Transform3d next = fcl::Transform3d::Identity();
            next.translation() = joints[i].offset;
            next.linear() = joints[i].turn(c[i]).toRotationMatrix();
            placed.push_back(at = at * next);
        }
        for (const auto& pair : pairs) {
            pair.grown->setTransform(placed[pair.joint] * pair.at);
            pair.grown->computeAABB();
            const auto& other = obstacles[pair.obstacle];
            if (!pair.grown->getAABB().overlap(other.getAABB())) continue;
            fcl::CollisionResultd result;
            if (fcl::collide(pair.grown.get(), &other, fcl::CollisionRequestd(), result) > 0) return false;
        }
        return true;
    }
    Coordinates coordinates(const ob::State* state) const {
        Coordinates c(joints.size(), {0.0, 0.0, 0.0});
        for (size_t d = 0; d < free.size(); d++) c[free[d][0]][free[d][1]] = (*state->as<ob::RealVectorStateSpace::StateType>())[d];
        return c;
    }
    // How far all joints turn on a way.
    double turned(og::PathGeometric path) const {
        path.interpolate(400);
        double sum = 0.0;
        for (size_t s = 1; s < path.getStateCount(); s++) {
            const Coordinates a = coordinates(path.getState(s - 1)), b = coordinates(path.getState(s));
            for (size_t i = 0; i < joints.size(); i++) sum += joints[i].turn(a[i]).angularDistance(joints[i].turn(b[i]));
        }
        return sum;
    }
};

static void print(const char* what, std::vector<double> all, double times, const char* unit) {
    std::sort(all.begin(), all.end());
    const double p95 = all[std::min(all.size() - 1, size_t(0.95 * all.size()))];
    printf("%-28s median %.3f, 95 %% %.3f, worst %.3f %s\n", what, all[all.size() / 2] * times, p95 * times, all.back() * times, unit);
}

int main(int count, char** args) {
    if (count < 2) {
        std::cerr << "expected the file that `throng bench plan --scene arm-static --plain FILE` writes\n";
        return 2;
    }
    std::ifstream file(args[1]);
    const Json json = Json::parse(file);
    const int seeds = count > 2 ? std::stoi(args[2]) : 100;
    const double resolution = count > 3 ? std::stod(args[3]) : 0.02;
    const Scene scene(json);
    printf("OMPL %d.%d.%d, FCL %s; %zu degrees of freedom, %zu pairs, a look every %g rad\n", OMPL_MAJOR_VERSION, OMPL_MINOR_VERSION, OMPL_PATCH_VERSION, FCL_VERSION, scene.free.size(), scene.pairs.size(), resolution);

    size_t others = 0, num_free = 0;
    const auto looked = std::chrono::steady_clock::now();
    for (const auto& s : json["samples"]) {
        const bool free = scene.is_free(s[0].get<Coordinates>());
        others += free != s[1].get<bool>();
        num_free += free;
    }
    const double each = seconds_since(looked) / std::max<size_t>(1, json["samples"].size());
    printf("%zu poses at random, %zu free: %zu judged otherwise than by Throng; %.2f us a look\n", json["samples"].size(), num_free, others, 1e6 * each);

    ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
    ompl::RNG::setSeed(1);
    auto space = std::make_shared<ob::RealVectorStateSpace>(scene.free.size());
    ob::RealVectorBounds bounds(scene.free.size());
    for (size_t d = 0; d < scene.free.size(); d++) {
        const auto& b = scene.joints[scene.free[d][0]].bounds[scene.free[d][1]];
        bounds.setLow(d, b[0] - 1e-6);
        bounds.setHigh(d, b[1] + 1e-6);
    }
    space->setBounds(bounds);
    std::vector<double> first, total, looks, lengths, smooth, per_look;
    int missed = 0;
    for (int seed = 0; seed < seeds; seed++) {
        og::SimpleSetup setup(space);
        setup.setStateValidityChecker([&](const ob::State* s) { return scene.is_free(scene.coordinates(s)); });
        ob::ScopedState<> ends[2] = {ob::ScopedState<>(space), ob::ScopedState<>(space)};
        for (int e = 0; e < 2; e++)
            for (size_t d = 0; d < scene.free.size(); d++) ends[e][d] = json["ends"][e][scene.free[d][0]][scene.free[d][1]];
        setup.setStartAndGoalStates(ends[0], ends[1]);
        setup.getSpaceInformation()->setStateValidityCheckingResolution(resolution / space->getMaximumExtent());
        setup.setPlanner(std::make_shared<og::RRTConnect>(setup.getSpaceInformation()));
        setup.setup();
        scene.looks = 0;
        const auto began = std::chrono::steady_clock::now();
        if (setup.solve(10.0) != ob::PlannerStatus::EXACT_SOLUTION) continue;
        first.push_back(seconds_since(began));
        per_look.push_back(first.back() / scene.looks);
        looks.push_back(scene.looks);
        lengths.push_back(scene.turned(setup.getSolutionPath()));
        setup.simplifySolution();
        total.push_back(seconds_since(began));
        smooth.push_back(scene.turned(setup.getSolutionPath()));
        og::PathGeometric fine = setup.getSolutionPath();
        fine.interpolate(size_t(fine.length() / (0.1 * resolution)) + 2);
        bool free = true;
        for (size_t s = 0; s < fine.getStateCount() && free; s++) free = scene.is_free(scene.coordinates(fine.getState(s)));
        missed += !free;
    }
    printf("%zu of %d seeds solved\n", first.size(), seeds);
    if (first.empty()) return 1;
    print("first way", first, 1e3, "ms");
    print("with simplification", total, 1e3, "ms");
    print("looks until the first way", looks, 1.0, "");
    print("a look, within a plan", per_look, 1e6, "us");
    print("turned, first way", lengths, 1.0, "rad");
    print("turned, simplified", smooth, 1.0, "rad");
    printf("%d ways are not free, seen ten times as finely\n", missed);
}
