// Throng for C++17: owners that free what they hold, and errors as exceptions. Stands on throng.h alone.
#ifndef THRONG_HPP
#define THRONG_HPP

#include "throng.h"

#include <array>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace throng {

/// A call that failed; what() has the reason.
class Error : public std::runtime_error {
public:
    Error(ThrongStatus status, const std::string &why) : std::runtime_error(why), status_(status) {}
    ThrongStatus status() const noexcept { return status_; }

private:
    ThrongStatus status_;
};

/// Throws unless a call has succeeded.
inline void check(ThrongStatus status) {
    if (status == THRONG_STATUS_OK) return;
    std::string why(throng_last_error(nullptr, 0), '\0');
    throng_last_error(&why[0], why.size() + 1);
    throw Error(status, why);
}

/// A handle that is freed once.
template <typename Handle, ThrongStatus (*Free)(Handle)> class Owner {
public:
    Owner() = default;
    explicit Owner(Handle handle) : handle_(handle) {}
    Owner(Owner &&other) noexcept : handle_(std::exchange(other.handle_, Handle{0})) {}
    Owner &operator=(Owner &&other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Owner() {
        if (handle_.handle != 0) Free(handle_);
    }
    Handle get() const noexcept { return handle_; }

protected:
    Handle handle_{0};
};

/// A bundle of tables.
class Bundle : public Owner<ThrongBundle, throng_bundle_free> {
public:
    explicit Bundle(const std::string &path) { check(throng_bundle_open(path.c_str(), &handle_)); }
    explicit Bundle(const std::vector<uint8_t> &bytes) {
        check(throng_bundle_from_memory(bytes.data(), bytes.size(), &handle_));
    }
    uint32_t policy(const std::string &behaviour) const {
        uint32_t number = 0;
        check(throng_bundle_policy(handle_, behaviour.c_str(), &number));
        return number;
    }
    std::array<ThrongJoint, THRONG_NUM_JOINTS> skeleton() const {
        std::array<ThrongJoint, THRONG_NUM_JOINTS> joints{};
        check(throng_bundle_skeleton(handle_, joints.data()));
        return joints;
    }
    /// Poses of all frame rows, for a vertex shader that makes poses from ThrongInstance.
    std::vector<float> rows(ThrongLayout layout) const {
        std::size_t count = 0;
        check(throng_bundle_num_rows(handle_, &count));
        std::vector<float> all(count * THRONG_NUM_JOINTS * throng_layout_floats(layout));
        check(throng_bundle_write_rows(handle_, all.data(), all.size() * sizeof(float), layout));
        return all;
    }
};

/// Characters who move: what scenes and characters of a bundle have in common.
class Simulation : public Owner<ThrongSimulation, throng_simulation_free> {
public:
    /// Opens a scene file.
    explicit Simulation(const std::string &scene) { check(throng_simulation_open(scene.c_str(), &handle_)); }

    void step(double dt_s) { check(throng_simulation_step(handle_, dt_s)); }
    /// Before threads are started that call help().
    void announce() { check(throng_simulation_announce(handle_)); }
    /// Works for the announced step until it is over; for any thread.
    void help() const { check(throng_simulation_help(handle_)); }
    void raise(const std::string &event) { check(throng_simulation_raise(handle_, event.c_str())); }
    /// Orders to people of a scene, and changes of their brains.
    void order(ThrongId who, const ThrongOrder &order) { check(throng_people_order(handle_, who, &order)); }
    void raise_for(ThrongId who, const std::string &event) { check(throng_people_raise(handle_, who, event.c_str())); }
    void set_value(ThrongId who, const std::string &name, float value) {
        check(throng_people_set_value(handle_, who, name.c_str(), value));
    }

    std::size_t count() const { return asked<std::size_t>(throng_simulation_count); }
    double time_s() const { return asked<double>(throng_simulation_time); }
    uint64_t hash() const { return asked<uint64_t>(throng_simulation_hash); }

    std::vector<ThrongRoot> roots() const { return records<ThrongRoot>(throng_simulation_roots); }
    std::vector<ThrongEvent> events() const { return records<ThrongEvent>(throng_simulation_events); }

    /// The matrix from each joint to the world, of everybody.
    void write_matrices(std::vector<float> &out, ThrongLayout layout) const {
        const std::size_t length = THRONG_NUM_JOINTS * throng_layout_floats(layout);
        out.resize(count() * length);
        const auto bytes = out.size() * sizeof(float);
        check(throng_simulation_write_matrices(handle_, out.data(), bytes, length * sizeof(float), layout));
    }

    std::vector<uint8_t> save() const {
        std::size_t size = 0;
        check(throng_simulation_save(handle_, nullptr, 0, &size));
        std::vector<uint8_t> bytes(size);
        check(throng_simulation_save(handle_, bytes.data(), bytes.size(), &size));
        return bytes;
    }
    void restore(const std::vector<uint8_t> &bytes) {
        check(throng_simulation_restore(handle_, bytes.data(), bytes.size()));
    }

protected:
    Simulation() = default;
    template <typename T> std::vector<T> records(ThrongStatus (*call)(ThrongSimulation, T *, std::size_t, std::size_t *)) const {
        std::size_t count = 0;
        check(call(handle_, nullptr, 0, &count));
        std::vector<T> all(count);
        check(call(handle_, all.data(), all.size(), &count));
        return all;
    }

private:
    template <typename T> T asked(ThrongStatus (*call)(ThrongSimulation, T *)) const {
        T value{};
        check(call(handle_, &value));
        return value;
    }
};

/// Characters of one bundle, who come, go and are told what to do.
class Characters : public Simulation {
public:
    static ThrongCharactersConfig config() {
        ThrongCharactersConfig config;
        check(throng_characters_config_init(&config, sizeof config));
        return config;
    }
    explicit Characters(const Bundle &bundle, const ThrongCharactersConfig &with = config()) {
        check(throng_characters_new(bundle.get(), &with, &handle_));
    }
    ThrongId spawn(float x, float z, float heading) {
        ThrongId id;
        check(throng_characters_spawn(handle_, x, z, heading, &id));
        return id;
    }
    void despawn(ThrongId id) { check(throng_characters_despawn(handle_, id)); }
    void place(ThrongId id, float x, float z, float heading) {
        check(throng_characters_place(handle_, id, x, z, heading));
    }
    void order(ThrongId id, uint32_t policy, float x, float y, float z) {
        check(throng_characters_order(handle_, id, policy, x, y, z));
    }
    void set_layers(ThrongId id, ThrongLayers layers) {
        layers.struct_size = sizeof layers;
        check(throng_characters_set_layers(handle_, id, &layers));
    }
    void stop(ThrongId id) { check(throng_characters_stop(handle_, id)); }
    void turn_to(ThrongId id, float heading) { check(throng_characters_turn_to(handle_, id, heading)); }
    void set_manner(ThrongId id, const std::string& manner) { check(throng_characters_set_manner(handle_, id, manner.c_str())); }
    /// Records of everybody; none unless config().instances.
    std::vector<ThrongInstance> instances() const { return records<ThrongInstance>(throng_characters_instances); }
    /// Who is posed from now on; null for everybody.
    void set_detail(const ThrongDetail *detail) { check(throng_characters_set_detail(handle_, detail)); }
    std::pair<ThrongProgress, float> progress(ThrongId id) const {
        std::pair<ThrongProgress, float> found{};
        check(throng_characters_progress(handle_, id, &found.first, &found.second));
        return found;
    }
};

} // namespace throng

#endif
