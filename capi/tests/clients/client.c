/* Walks characters of a bundle, with and without helping threads, and misuses every handle and pointer.
 * Prints hashes of states and matrices, which the test compares with those of Rust. */
#include "throng.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

#define EXPECT(call, wanted)                                                                                           \
    do {                                                                                                               \
        ThrongStatus got = (call);                                                                                     \
        if (got != (wanted)) {                                                                                         \
            char why[512];                                                                                             \
            throng_last_error(why, sizeof why);                                                                        \
            fprintf(stderr, "line %d: status %d, expected %d: %s\n", __LINE__, (int)got, (int)(wanted), why);          \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)
#define OK(call) EXPECT(call, THRONG_STATUS_OK)
#define CHECK(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            fprintf(stderr, "line %d: %s\n", __LINE__, #condition);                                                    \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)

enum { PEOPLE = 40, STEPS = 90, HELPERS = 3 };

static void *help(void *simulation) {
    OK(throng_simulation_help(*(ThrongSimulation *)simulation));
    return NULL;
}

/* Somebody else holds the simulation while this thread calls. */
static void *steps(void *simulation) {
    for (int k = 0; k < 50; ++k) {
        ThrongStatus got = throng_simulation_step(*(ThrongSimulation *)simulation, 1.0 / 60.0);
        CHECK(got == THRONG_STATUS_OK || got == THRONG_STATUS_BUSY);
    }
    return NULL;
}

static uint64_t fnv(const void *bytes, size_t size) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (size_t k = 0; k < size; ++k) hash = (hash ^ ((const unsigned char *)bytes)[k]) * 0x100000001b3u;
    return hash;
}

static ThrongSimulation people(ThrongBundle bundle, ThrongId *ids) {
    ThrongCharactersConfig config;
    OK(throng_characters_config_init(&config, sizeof config));
    CHECK(config.struct_size == sizeof config);
    config.capacity = PEOPLE;
    config.instances = 1;
    ThrongSimulation made;
    OK(throng_characters_new(bundle, &config, &made));
    uint32_t approach;
    OK(throng_bundle_policy(bundle, "approach", &approach));
    for (int k = 0; k < PEOPLE; ++k) {
        OK(throng_characters_spawn(made, 3.0f * (k % 8), 3.0f * (k / 8), 0.1f * k, &ids[k]));
        OK(throng_characters_order(made, ids[k], approach, 10.0f, 0.0f, 8.0f));
    }
    return made;
}

static void misuse(ThrongBundle bundle, ThrongSimulation simulation, ThrongId id) {
    char why[512];
    size_t size;
    uint32_t policy;
    uint64_t hash;
    ThrongBundle no_bundle = {0}, other = {simulation.handle};
    ThrongSimulation none = {0}, bundle_as_simulation = {bundle.handle};
    ThrongCharactersConfig config;
    EXPECT(throng_bundle_open(NULL, &other), THRONG_STATUS_POINTER);
    EXPECT(throng_bundle_open("there/is/none", NULL), THRONG_STATUS_POINTER);
    EXPECT(throng_bundle_open("there/is/none", &other), THRONG_STATUS_IO);
    throng_last_error(why, sizeof why);
    CHECK(strstr(why, "there/is/none") != NULL);
    CHECK(throng_last_error(NULL, 0) == strlen(why));
    CHECK(throng_last_error(why, 6) > 5 && strlen(why) == 5);
    EXPECT(throng_bundle_open("\xff", &other), THRONG_STATUS_POINTER);
    EXPECT(throng_bundle_from_memory(NULL, 10, &other), THRONG_STATUS_POINTER);
    EXPECT(throng_bundle_from_memory((const uint8_t *)"nonsense", 8, &other), THRONG_STATUS_FORMAT);
    EXPECT(throng_bundle_policy(no_bundle, "approach", &policy), THRONG_STATUS_HANDLE);
    EXPECT(throng_bundle_policy(bundle, "fly", &policy), THRONG_STATUS_VALUE);
    throng_last_error(why, sizeof why);
    CHECK(strstr(why, "approach") != NULL);
    EXPECT(throng_bundle_policy(bundle, "approach", NULL), THRONG_STATUS_POINTER);
    EXPECT(throng_bundle_skeleton(bundle, NULL), THRONG_STATUS_POINTER);
    EXPECT(throng_bundle_free(other), THRONG_STATUS_HANDLE);
    OK(throng_characters_config_init(&config, sizeof config));
    EXPECT(throng_characters_config_init(&config, 32), THRONG_STATUS_VALUE);
    config.struct_size = 8;
    EXPECT(throng_characters_new(bundle, &config, &none), THRONG_STATUS_VALUE);
    OK(throng_characters_config_init(&config, sizeof config));
    config.half_life_s = -1.0f;
    EXPECT(throng_characters_new(bundle, &config, &none), THRONG_STATUS_VALUE);
    EXPECT(throng_characters_new(bundle, NULL, &none), THRONG_STATUS_POINTER);
    EXPECT(throng_simulation_hash(none, &hash), THRONG_STATUS_HANDLE);
    EXPECT(throng_simulation_hash(bundle_as_simulation, &hash), THRONG_STATUS_HANDLE);
    EXPECT(throng_simulation_hash(simulation, NULL), THRONG_STATUS_POINTER);
    EXPECT(throng_simulation_step(simulation, -1.0), THRONG_STATUS_VALUE);
    EXPECT(throng_simulation_step(simulation, 0.0 / 0.0), THRONG_STATUS_VALUE);
    EXPECT(throng_simulation_raise(simulation, "fire"), THRONG_STATUS_UNSUPPORTED);
    ThrongOrder order = {0};
    EXPECT(throng_people_order(simulation, id, NULL), THRONG_STATUS_POINTER);
    EXPECT(throng_people_order(simulation, id, &order), THRONG_STATUS_VALUE);
    order.struct_size = sizeof order;
    EXPECT(throng_people_order(simulation, id, &order), THRONG_STATUS_UNSUPPORTED);
    order.task = 9;
    EXPECT(throng_people_order(simulation, id, &order), THRONG_STATUS_VALUE);
    EXPECT(throng_people_raise(simulation, id, "fire"), THRONG_STATUS_UNSUPPORTED);
    EXPECT(throng_people_set_value(simulation, id, "hunger", 1.0f), THRONG_STATUS_UNSUPPORTED);
    EXPECT(throng_simulation_roots(simulation, NULL, 3, &size), THRONG_STATUS_POINTER);
    EXPECT(throng_simulation_restore(simulation, (const uint8_t *)"nonsense, but long enough", 25), THRONG_STATUS_FORMAT);
    EXPECT(throng_simulation_open("there/is/none.toml", &none), THRONG_STATUS_IO);
    float matrices[12];
    EXPECT(throng_simulation_write_matrices(simulation, NULL, 0, 4 * 22 * 12, 0), THRONG_STATUS_POINTER);
    EXPECT(throng_simulation_write_matrices(simulation, matrices, sizeof matrices, 4 * 22 * 12, 0), THRONG_STATUS_TOO_SMALL);
    EXPECT(throng_simulation_write_matrices(simulation, matrices, sizeof matrices, 8, 0), THRONG_STATUS_VALUE);
    EXPECT(throng_simulation_write_matrices(simulation, matrices, sizeof matrices, (size_t)-4, 0), THRONG_STATUS_TOO_SMALL);
    EXPECT(throng_simulation_write_matrices(simulation, matrices, sizeof matrices, 4 * 22 * 16, 9), THRONG_STATUS_VALUE);
    ThrongDetail detail = {0.0f, 0.0f, 5.0f, 4.0f};
    EXPECT(throng_characters_set_detail(simulation, &detail), THRONG_STATUS_VALUE);
    EXPECT(throng_characters_set_detail(none, NULL), THRONG_STATUS_HANDLE);
    EXPECT(throng_characters_instances(simulation, NULL, 3, &size), THRONG_STATUS_POINTER);
    EXPECT(throng_characters_instances(simulation, NULL, 0, NULL), THRONG_STATUS_POINTER);
    EXPECT(throng_bundle_num_rows(bundle, NULL), THRONG_STATUS_POINTER);
    EXPECT(throng_bundle_write_rows(no_bundle, matrices, sizeof matrices, 0), THRONG_STATUS_HANDLE);
    EXPECT(throng_bundle_write_rows(bundle, NULL, sizeof matrices, 0), THRONG_STATUS_POINTER);
    EXPECT(throng_bundle_write_rows(bundle, matrices, sizeof matrices, 0), THRONG_STATUS_TOO_SMALL);
    EXPECT(throng_bundle_write_rows(bundle, matrices, sizeof matrices, 7), THRONG_STATUS_VALUE);
    EXPECT(throng_characters_order(simulation, id, 99, 0, 0, 0), THRONG_STATUS_VALUE);
    EXPECT(throng_characters_order(simulation, (ThrongId){9999, 0}, 0, 0, 0, 0), THRONG_STATUS_GONE);
    ThrongLayers layers = {0};
    EXPECT(throng_characters_set_layers(simulation, id, &layers), THRONG_STATUS_VALUE);
    layers.struct_size = sizeof layers;
    layers.arms[1] = 8;
    EXPECT(throng_characters_set_layers(simulation, id, &layers), THRONG_STATUS_VALUE);
    layers.arms[1] = 2;
    layers.lean[0] = 9.0f;
    EXPECT(throng_characters_set_layers(simulation, id, &layers), THRONG_STATUS_VALUE);
    layers.lean[0] = 0.0f;
    EXPECT(throng_characters_set_layers(simulation, id, NULL), THRONG_STATUS_POINTER);
    EXPECT(throng_characters_set_layers(simulation, (ThrongId){9999, 0}, &layers), THRONG_STATUS_GONE);
    EXPECT(throng_characters_spawn(simulation, 90.0f, 90.0f, 0.0f, &id), THRONG_STATUS_FULL);
}

/* Poses of all frame rows, in three layouts. */
static void rows(ThrongBundle bundle) {
    size_t count;
    OK(throng_bundle_num_rows(bundle, &count));
    for (uint32_t layout = 0; layout < 3; ++layout) {
        size_t size = count * THRONG_NUM_JOINTS * throng_layout_floats(layout) * sizeof(float);
        float *matrices = malloc(size);
        CHECK(matrices != NULL);
        OK(throng_bundle_write_rows(bundle, matrices, size, layout));
        printf("rows %016llx\n", (unsigned long long)fnv(matrices, size));
        free(matrices);
    }
}

/* Nobody is posed: people go where they would go. */
static void far_away(ThrongSimulation posed, ThrongSimulation far) {
    ThrongDetail nobody = {0.0f, 0.0f, -1.0f, -1.0f};
    OK(throng_characters_set_detail(far, &nobody));
    static ThrongInstance before[PEOPLE], a[PEOPLE], b[PEOPLE];
    size_t count;
    OK(throng_characters_instances(far, before, PEOPLE, &count));
    for (int k = 0; k < STEPS; ++k) {
        OK(throng_simulation_step(posed, 1.0 / 60.0));
        OK(throng_simulation_step(far, 1.0 / 60.0));
    }
    OK(throng_characters_instances(posed, a, PEOPLE, &count));
    OK(throng_characters_instances(far, b, PEOPLE, &count));
    CHECK(count == PEOPLE && memcmp(a, b, sizeof a) == 0 && memcmp(before, b, sizeof b) != 0);
    OK(throng_characters_set_detail(far, NULL));
}

int main(int argc, char **argv) {
    CHECK(argc == 2);
    ThrongBundle bundle, copy;
    OK(throng_bundle_open(argv[1], &bundle));
    /* The same from memory, which is then overwritten and freed. */
    FILE *file = fopen(argv[1], "rb");
    CHECK(file != NULL && fseek(file, 0, SEEK_END) == 0);
    size_t length = (size_t)ftell(file);
    rewind(file);
    uint8_t *bytes = malloc(length);
    CHECK(bytes != NULL && fread(bytes, 1, length, file) == length);
    fclose(file);
    OK(throng_bundle_from_memory(bytes, length, &copy));
    memset(bytes, 0, length);
    free(bytes);

    ThrongId ids[PEOPLE];
    ThrongSimulation alone = people(bundle, ids), helped = people(copy, ids);
    misuse(bundle, alone, ids[0]);
    rows(bundle);
    OK(throng_bundle_free(bundle));
    OK(throng_bundle_free(copy));
    EXPECT(throng_bundle_free(bundle), THRONG_STATUS_HANDLE);

    size_t saved_size = 0;
    uint8_t *saved = NULL;
    for (int k = 0; k < STEPS; ++k) {
        OK(throng_simulation_step(alone, 1.0 / 60.0));
        pthread_t threads[HELPERS];
        OK(throng_simulation_announce(helped));
        for (int h = 0; h < HELPERS; ++h) CHECK(pthread_create(&threads[h], NULL, help, &helped) == 0);
        OK(throng_simulation_step(helped, 1.0 / 60.0));
        for (int h = 0; h < HELPERS; ++h) pthread_join(threads[h], NULL);
        if (k == STEPS / 2) {
            OK(throng_simulation_save(alone, NULL, 0, &saved_size));
            saved = malloc(saved_size);
            EXPECT(throng_simulation_save(alone, saved, saved_size - 1, &saved_size), THRONG_STATUS_TOO_SMALL);
            OK(throng_simulation_save(alone, saved, saved_size, &saved_size));
        }
    }
    uint64_t hash, hash_helped;
    OK(throng_simulation_hash(alone, &hash));
    OK(throng_simulation_hash(helped, &hash_helped));
    CHECK(hash == hash_helped);

    size_t count;
    OK(throng_simulation_count(alone, &count));
    CHECK(count == PEOPLE);
    ThrongRoot roots[PEOPLE];
    OK(throng_simulation_roots(alone, roots, PEOPLE, &count));
    CHECK(count == PEOPLE && roots[7].is_there == 1 && roots[7].id.index == ids[7].index);
    ThrongProgress progress;
    float left_m;
    OK(throng_characters_progress(alone, ids[0], &progress, &left_m));
    CHECK(progress == THRONG_PROGRESS_GOING && left_m > 0.0f);

    printf("hash %016llx\n", (unsigned long long)hash);
    printf("roots");
    for (int k = 0; k < PEOPLE; ++k) {
        float at[3] = {roots[k].x, roots[k].z, roots[k].heading};
        printf(" %016llx", (unsigned long long)fnv(at, sizeof at));
    }
    printf("\n");
    ThrongInstance instances[PEOPLE];
    OK(throng_characters_instances(alone, instances, PEOPLE, &count));
    CHECK(count == PEOPLE && instances[7].x == roots[7].x && instances[7].variant == ids[7].index);
    printf("instances %016llx\n", (unsigned long long)fnv(instances, sizeof instances));
    for (uint32_t layout = 0; layout < 3; ++layout) {
        /* Room behind each character that stays as it was. */
        size_t length_of_one = THRONG_NUM_JOINTS * throng_layout_floats(layout) * sizeof(float), stride = length_of_one + 64;
        unsigned char *matrices = malloc(PEOPLE * stride - 64);
        memset(matrices, 0xa5, PEOPLE * stride - 64);
        OK(throng_simulation_write_matrices(alone, (float *)matrices, PEOPLE * stride - 64, stride, layout));
        uint64_t all = 0;
        for (int k = 0; k < PEOPLE; ++k) all = all * 31 + fnv(matrices + k * stride, length_of_one);
        for (int k = 0; k + 1 < PEOPLE; ++k) CHECK(matrices[k * stride + length_of_one] == 0xa5);
        printf("matrices %016llx\n", (unsigned long long)all);
        free(matrices);
    }

    /* Back to the middle, and on again: the same. A damaged snapshot changes nothing. */
    saved[saved_size / 2] ^= 4;
    EXPECT(throng_simulation_restore(alone, saved, saved_size), THRONG_STATUS_FORMAT);
    OK(throng_simulation_hash(alone, &hash_helped));
    CHECK(hash == hash_helped);
    saved[saved_size / 2] ^= 4;
    OK(throng_simulation_restore(alone, saved, saved_size));
    for (int k = STEPS / 2 + 1; k < STEPS; ++k) OK(throng_simulation_step(alone, 1.0 / 60.0));
    OK(throng_simulation_hash(alone, &hash_helped));
    CHECK(hash == hash_helped);
    free(saved);
    far_away(alone, helped);

    OK(throng_characters_despawn(alone, ids[3]));
    EXPECT(throng_characters_despawn(alone, ids[3]), THRONG_STATUS_GONE);
    EXPECT(throng_characters_place(alone, ids[3], 0, 0, 0), THRONG_STATUS_GONE);
    pthread_t a, b;
    CHECK(pthread_create(&a, NULL, steps, &alone) == 0 && pthread_create(&b, NULL, steps, &alone) == 0);
    pthread_join(a, NULL);
    pthread_join(b, NULL);
    OK(throng_simulation_free(alone));
    OK(throng_simulation_free(helped));
    EXPECT(throng_simulation_free(alone), THRONG_STATUS_HANDLE);
    EXPECT(throng_simulation_step(alone, 0.01), THRONG_STATUS_HANDLE);
    EXPECT(throng_simulation_help(alone), THRONG_STATUS_HANDLE);
    return 0;
}
