// The same walk through the wrapper of C++, then a scene. Prints the hashes of both.
#include "throng.hpp"

#include <cstdio>
#include <cstdlib>

int main(int argc, char **argv) {
    if (argc != 3) return 2;
    throng::Bundle bundle{std::string(argv[1])};
    auto config = throng::Characters::config();
    config.capacity = 40;
    config.instances = 1;
    throng::Characters people(bundle, config);
    const auto approach = bundle.policy("approach");
    for (int k = 0; k < 40; ++k) {
        const auto id = people.spawn(3.0f * (k % 8), 3.0f * (k / 8), 0.1f * k);
        people.order(id, approach, 10.0f, 0.0f, 8.0f);
    }
    for (int k = 0; k < 90; ++k) people.step(1.0 / 60.0);
    std::printf("hash %016llx\n", static_cast<unsigned long long>(people.hash()));

    const auto instances = people.instances();
    if (instances.size() != 40 || instances[5].x != people.roots()[5].x) return 1;
    if (bundle.rows(THRONG_LAYOUT_UNITY).size() <= instances[5].row_a * 22u * 16u) return 1;
    const ThrongDetail nobody{0.0f, 0.0f, -1.0f, -1.0f};
    people.set_detail(&nobody);
    people.step(1.0 / 60.0);
    people.set_detail(nullptr);

    throng::Simulation scene{std::string(argv[2])};
    std::vector<uint8_t> middle;
    for (int k = 0; k < 60; ++k) {
        if (k == 30) middle = scene.save();
        scene.step(1.0 / 30.0);
    }
    const auto hash = scene.hash();
    std::vector<float> matrices;
    scene.write_matrices(matrices, THRONG_LAYOUT_UNREAL);
    if (matrices.size() != scene.count() * 22 * 16 || scene.roots().size() != scene.count()) return 1;
    std::printf("scene %016llx\n", static_cast<unsigned long long>(hash));
    scene.restore(middle);
    for (int k = 30; k < 60; ++k) scene.step(1.0 / 30.0);
    if (scene.hash() != hash) return 1;

    try {
        throng::Bundle nothing{std::string("there/is/none")};
        return 1;
    } catch (const throng::Error &e) {
        if (e.status() != THRONG_STATUS_IO || std::string(e.what()).find("there/is/none") == std::string::npos) return 1;
    }
    throng::Simulation moved = std::move(scene);
    return moved.count() > 0 ? 0 : 1;
}
