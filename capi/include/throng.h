/* Throng's runtime for C and C++. Made by `cargo test -p throng-capi`: do not edit. */

#ifndef THRONG_H
#define THRONG_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/**
 * Joints of every skeleton; parents come before their children.
 */
#define THRONG_NUM_JOINTS 22

/**
 * What a call returns. `throng_last_error` has the reason in words.
 */
typedef enum ThrongStatus {
  /**
   * Done.
   */
  THRONG_STATUS_OK = 0,
  /**
   * A pointer is null or not aligned, or a text is not UTF-8.
   */
  THRONG_STATUS_POINTER = 1,
  /**
   * The handle was freed, or is none.
   */
  THRONG_STATUS_HANDLE = 2,
  /**
   * Another thread is in a call with this handle.
   */
  THRONG_STATUS_BUSY = 3,
  /**
   * A number, name or length is out of its range.
   */
  THRONG_STATUS_VALUE = 4,
  /**
   * The memory given is too small.
   */
  THRONG_STATUS_TOO_SMALL = 5,
  /**
   * A file cannot be read.
   */
  THRONG_STATUS_IO = 6,
  /**
   * A file or snapshot is damaged, or not what it should be.
   */
  THRONG_STATUS_FORMAT = 7,
  /**
   * The character has left.
   */
  THRONG_STATUS_GONE = 8,
  /**
   * All places are taken.
   */
  THRONG_STATUS_FULL = 9,
  /**
   * The place is taken, or no way leads there.
   */
  THRONG_STATUS_PLACE = 10,
  /**
   * This kind of simulation cannot do that.
   */
  THRONG_STATUS_UNSUPPORTED = 11,
  /**
   * A fault of this library; the simulation has to be freed.
   */
  THRONG_STATUS_PANIC = 12,
} ThrongStatus;

/**
 * How far a character has come with its order.
 */
typedef enum ThrongProgress {
  /**
   * It has none.
   */
  THRONG_PROGRESS_IDLE = 0,
  /**
   * On its way.
   */
  THRONG_PROGRESS_GOING = 1,
  /**
   * It is where it was sent.
   */
  THRONG_PROGRESS_THERE = 2,
  /**
   * It makes no progress.
   */
  THRONG_PROGRESS_BLOCKED = 3,
  /**
   * No way leads there.
   */
  THRONG_PROGRESS_NO_WAY = 4,
} ThrongProgress;

/**
 * What happened to a character.
 */
typedef enum ThrongHappened {
  /**
   * Its blow has landed, or, for characters of a bundle, has passed its place.
   */
  THRONG_HAPPENED_HIT = 0,
  /**
   * Its blow met `other`, its opponent.
   */
  THRONG_HAPPENED_STRUCK = 1,
  /**
   * Its wish is fulfilled.
   */
  THRONG_HAPPENED_FULFILLED = 2,
  /**
   * It is at its goal.
   */
  THRONG_HAPPENED_ARRIVED = 3,
  /**
   * It has left at its goal.
   */
  THRONG_HAPPENED_LEFT = 4,
  /**
   * It makes no progress.
   */
  THRONG_HAPPENED_STUCK = 5,
  /**
   * The moving obstacle `other` ran into it.
   */
  THRONG_HAPPENED_RUN_INTO = 6,
} ThrongHappened;

/**
 * How matrices lie in memory, and in which axes.
 */
typedef enum ThrongLayout {
  /**
   * Three rows of four; right-handed, X left, Y up, Z forward, metres.
   */
  THRONG_LAYOUT_THRONG = 0,
  /**
   * Unity's `Matrix4x4`, four columns of four; left-handed, X right, Y up, Z forward, metres.
   */
  THRONG_LAYOUT_UNITY = 1,
  /**
   * Unreal's `FMatrix` of floats, rows that hold the axes and then the place; left-handed, X forward, Y right, Z up,
   * centimetres.
   */
  THRONG_LAYOUT_UNREAL = 2,
} ThrongLayout;

/**
 * A bundle of tables. Simulations made from it keep what they need when it is freed.
 */
typedef struct ThrongBundle {
  /**
   * Zero is none.
   */
  uint64_t handle;
} ThrongBundle;

/**
 * A joint of a skeleton in rest pose, where every joint's rotation is the identity in Throng's axes.
 */
typedef struct ThrongJoint {
  /**
   * Number of its parent; -1 for the first.
   */
  int32_t parent;
  /**
   * From its parent (m; X left, Y up, Z forward).
   */
  float offset[3];
} ThrongJoint;

/**
 * Characters who move. One thread at a time may call with it; `throng_simulation_help` is for all.
 */
typedef struct ThrongSimulation {
  /**
   * Zero is none.
   */
  uint64_t handle;
} ThrongSimulation;

/**
 * How characters of a bundle move.
 */
typedef struct ThrongCharactersConfig {
  /**
   * `sizeof(ThrongCharactersConfig)`, as `throng_characters_config_init` writes it.
   */
  size_t struct_size;
  /**
   * Seed of random choices.
   */
  uint64_t seed;
  /**
   * Most characters at a time.
   */
  uint32_t capacity;
  /**
   * 1: they make way for each other. 0: they take no notice of anybody.
   */
  uint32_t makes_way;
  /**
   * 0 takes the best action; above, one of the best few at random.
   */
  float temperature;
  /**
   * Time in which the offset of a transition halves (s).
   */
  float half_life_s;
  /**
   * 1: steps also leave a `ThrongInstance` of everybody.
   */
  uint32_t instances;
  /**
   * 0.
   */
  uint32_t reserved;
} ThrongCharactersConfig;

/**
 * Names a character. Nobody else of its simulation ever has the same one. In scenes the index is its number, and the
 * generation 0.
 */
typedef struct ThrongId {
  /**
   * Its place (< capacity).
   */
  uint32_t index;
  /**
   * How many had this place before.
   */
  uint32_t generation;
} ThrongId;

/**
 * Where a character stands and looks.
 */
typedef struct ThrongRoot {
  /**
   * Who.
   */
  struct ThrongId id;
  /**
   * 0 where it has left, else 1.
   */
  uint32_t is_there;
  /**
   * Along X, to the left of heading 0 (m).
   */
  float x;
  /**
   * Along Z (m).
   */
  float z;
  /**
   * About +Y from +Z (rad).
   */
  float heading;
} ThrongRoot;

/**
 * Something that happened in the last step.
 */
typedef struct ThrongEvent {
  /**
   * When (s).
   */
  double time_s;
  /**
   * To whom, or by whom.
   */
  struct ThrongId id;
  /**
   * What.
   */
  enum ThrongHappened happened;
  /**
   * See `ThrongHappened`; else 0.
   */
  uint32_t other;
  /**
   * Where, for blows; else zeros (m).
   */
  float at[3];
} ThrongEvent;

/**
 * Where characters are looked at from, and who is near enough for what. They go where they would go without it.
 *
 * Eight characters whose rows are neighbours have one level: that of the nearest.
 */
typedef struct ThrongDetail {
  /**
   * The eye, along X (m).
   */
  float eye_x;
  /**
   * The eye, along Z (m).
   */
  float eye_z;
  /**
   * Feet stay in place up to this distance; -1 for nobody (m).
   */
  float full_m;
  /**
   * Poses are computed up to this distance, at least `full_m`; the matrices of others stay as they were (m).
   */
  float posed_m;
} ThrongDetail;

/**
 * What a GPU needs to pose a character from the frame rows of its bundle (32 bytes; `throng_bundle_write_rows`).
 *
 * The pose is `mix(mix(row_a, row_a + 1, frac), mix(row_b, row_b + 1, frac), blend)`: what is played, and what a
 * transition left and fades out. It stands at (x, y, z) and is turned by the heading, in Throng's axes: that is
 * (-x, y, z) and -heading in Unity, (100 z, -100 x, 100 y) and a yaw of -heading in Unreal.
 */
typedef struct ThrongInstance {
  /**
   * Frame row; the one after it is of the same clip, or `frac` is 0.
   */
  uint32_t row_a;
  /**
   * Frame row of what fades out; `row_a` where nothing does.
   */
  uint32_t row_b;
  /**
   * How far to the next rows (65535 is 1).
   */
  uint16_t frac;
  /**
   * The weight of `row_b` (65535 is 1).
   */
  uint16_t blend;
  /**
   * Number of the character's place, for looks (< capacity).
   */
  uint32_t variant;
  /**
   * Along X, to the left of heading 0 (m).
   */
  float x;
  /**
   * Height of the ground there (m).
   */
  float y;
  /**
   * Along Z (m).
   */
  float z;
  /**
   * About +Y from +Z (rad).
   */
  float heading;
} ThrongInstance;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Copies why the last call failed on this thread, in UTF-8 and with a zero at its end; cut where it is too long.
 *
 * @param buffer memory for the text; may be null where `size` is 0.
 * @param size its length (bytes).
 * @return the length of the whole text, without the zero (bytes).
 *
 * @pre
 * `buffer` must have room for `size` bytes.
 */
size_t throng_last_error(char *buffer, size_t size);

/**
 * Opens a bundle file. What happens to the file afterwards does not matter.
 *
 * @pre
 * `path` ends with a zero, `bundle` can be written.
 */
enum ThrongStatus throng_bundle_open(const char *path, struct ThrongBundle *bundle);

/**
 * Opens a bundle that lies in memory; it is copied.
 *
 * @pre
 * `bytes` points to `size` bytes, `bundle` can be written.
 */
enum ThrongStatus throng_bundle_from_memory(const uint8_t *bytes, size_t size, struct ThrongBundle *bundle);

/**
 * Frees a bundle.
 */
enum ThrongStatus throng_bundle_free(struct ThrongBundle bundle);

/**
 * The number of a behaviour's policy; the error lists the names that there are.
 *
 * @pre
 * `behaviour` ends with a zero, `policy` can be written.
 */
enum ThrongStatus throng_bundle_policy(struct ThrongBundle bundle, const char *behaviour, uint32_t *policy);

/**
 * The skeleton of a bundle.
 *
 * @param joints room for `THRONG_NUM_JOINTS`.
 *
 * @pre
 * `joints` has that room.
 */
enum ThrongStatus throng_bundle_skeleton(struct ThrongBundle bundle, struct ThrongJoint *joints);

/**
 * Copies the name of a joint, with a zero at its end.
 *
 * @return the length of the name, 0 where there is no such joint (bytes).
 *
 * @pre
 * `buffer` has room for `size` bytes.
 */
size_t throng_joint_name(uint32_t joint, char *buffer, size_t size);

/**
 * Frees a simulation; a call that another thread is in ends first.
 */
enum ThrongStatus throng_simulation_free(struct ThrongSimulation simulation);

/**
 * Moves everybody on. Works on this thread, and on those that help where the step was announced.
 *
 * @param dt_s 0 to 1 (s).
 */
enum ThrongStatus throng_simulation_step(struct ThrongSimulation simulation, double dt_s);

/**
 * Lets threads that call `throng_simulation_help` wait for the next step and work in it. Call it before they start. The
 * result of the step does not depend on how many there are, nor on when they come.
 */
enum ThrongStatus throng_simulation_announce(struct ThrongSimulation simulation);

/**
 * Works for a step that was announced, until it is over; returns at once where none is. For jobs of the application's
 * own threads, as many at a time as it likes.
 */
enum ThrongStatus throng_simulation_help(struct ThrongSimulation simulation);

/**
 * How many characters there are, those of a scene who have left included.
 *
 * @pre
 * `count` can be written.
 */
enum ThrongStatus throng_simulation_count(struct ThrongSimulation simulation, size_t *count);

/**
 * Simulated time (s).
 *
 * @pre
 * `time_s` can be written.
 */
enum ThrongStatus throng_simulation_time(struct ThrongSimulation simulation, double *time_s);

/**
 * A hash of the state: the same for the same motion, on every machine and from every language.
 *
 * @pre
 * `hash` can be written.
 */
enum ThrongStatus throng_simulation_hash(struct ThrongSimulation simulation, uint64_t *hash);

/**
 * Copies all that the next steps depend on, with a checksum.
 *
 * @param buffer room for `capacity` bytes; where it is null and `capacity` 0, only `size` is written.
 * @param size how many bytes there are. With less room nothing is copied, and `THRONG_STATUS_TOO_SMALL` returned.
 *
 * @pre
 * `buffer` has this room, `size` can be written.
 */
enum ThrongStatus throng_simulation_save(struct ThrongSimulation simulation,
                                         uint8_t *buffer,
                                         size_t capacity,
                                         size_t *size);

/**
 * Goes back to what was saved from the same bundle or scene; what is refused changes nothing.
 *
 * @pre
 * `bytes` points to `size` bytes.
 */
enum ThrongStatus throng_simulation_restore(struct ThrongSimulation simulation, const uint8_t *bytes, size_t size);

/**
 * Fills in the defaults: seed 1, 1000 characters who make way.
 *
 * @param size `sizeof(ThrongCharactersConfig)`.
 *
 * @pre
 * `config` has room for `size` bytes.
 */
enum ThrongStatus throng_characters_config_init(struct ThrongCharactersConfig *config, size_t size);

/**
 * Room for characters that policies of a bundle move; nobody is there yet.
 *
 * @pre
 * `config` points to as many bytes as its `struct_size` says, `simulation` can be written.
 */
enum ThrongStatus throng_characters_new(struct ThrongBundle bundle,
                                        const struct ThrongCharactersConfig *config,
                                        struct ThrongSimulation *simulation);

/**
 * Opens a scene file with its bundles and worlds, and puts everybody in place.
 *
 * @pre
 * `path` ends with a zero, `simulation` can be written.
 */
enum ThrongStatus throng_simulation_open(const char *path, struct ThrongSimulation *simulation);

/**
 * Lets an event of the scene happen now.
 *
 * @pre
 * `event` ends with a zero.
 */
enum ThrongStatus throng_simulation_raise(struct ThrongSimulation simulation, const char *event);

/**
 * Lets a character enter; it stands at (x, z) and looks along the heading. Its pose is there after the next step.
 *
 * @param heading about +Y from +Z (rad).
 *
 * @pre
 * `id` can be written.
 */
enum ThrongStatus throng_characters_spawn(struct ThrongSimulation simulation,
                                          float x,
                                          float z,
                                          float heading,
                                          struct ThrongId *id);

/**
 * Lets a character leave. The last one takes its row.
 */
enum ThrongStatus throng_characters_despawn(struct ThrongSimulation simulation, struct ThrongId id);

/**
 * Puts a character elsewhere at once.
 */
enum ThrongStatus throng_characters_place(struct ThrongSimulation simulation,
                                          struct ThrongId id,
                                          float x,
                                          float z,
                                          float heading);

/**
 * Tells a character what to do from now on: a policy of the bundle, and the target in the world that it is about.
 *
 * @param policy see `throng_bundle_policy`.
 */
enum ThrongStatus throng_characters_order(struct ThrongSimulation simulation,
                                          struct ThrongId id,
                                          uint32_t policy,
                                          float x,
                                          float y,
                                          float z);

/**
 * How far a character has come with its order.
 *
 * @param left_m what is left of its way where it is going, else 0 (m).
 *
 * @pre
 * `progress` and `left_m` can be written.
 */
enum ThrongStatus throng_characters_progress(struct ThrongSimulation simulation,
                                             struct ThrongId id,
                                             enum ThrongProgress *progress,
                                             float *left_m);

/**
 * Floats of one matrix: 12 or 16; 0 for a layout that does not exist.
 */
size_t throng_layout_floats(uint32_t layout);

/**
 * Copies where everybody is, in the order of rows.
 *
 * @param roots room for `capacity` records.
 * @param count how many there are; more than `capacity` are left out.
 *
 * @pre
 * `roots` has this room, `count` can be written.
 */
enum ThrongStatus throng_simulation_roots(struct ThrongSimulation simulation,
                                          struct ThrongRoot *roots,
                                          size_t capacity,
                                          size_t *count);

/**
 * Copies what happened in the last step.
 *
 * @param events room for `capacity` records.
 * @param count how many there are; more than `capacity` are left out.
 *
 * @pre
 * `events` has this room, `count` can be written.
 */
enum ThrongStatus throng_simulation_events(struct ThrongSimulation simulation,
                                           struct ThrongEvent *events,
                                           size_t capacity,
                                           size_t *count);

/**
 * Writes the matrix from each joint to the world, for everybody, in one pass and in the axes of an engine. Who has left
 * or has no body gets zeros.
 *
 * @param matrices characters times `THRONG_NUM_JOINTS` matrices, a character's side by side.
 * @param size its length (bytes).
 * @param stride from one character's first matrix to the next one's (bytes, a multiple of 4).
 * @param layout a `ThrongLayout`.
 *
 * @pre
 * `matrices` has room for `size` bytes.
 */
enum ThrongStatus throng_simulation_write_matrices(struct ThrongSimulation simulation,
                                                   float *matrices,
                                                   size_t size,
                                                   size_t stride,
                                                   uint32_t layout);

/**
 * Says who is posed in the next steps.
 *
 * @param detail null for everybody, as it is at first.
 *
 * @pre
 * `detail` is null or can be read.
 */
enum ThrongStatus throng_characters_set_detail(struct ThrongSimulation simulation, const struct ThrongDetail *detail);

/**
 * Copies the records of everybody, in the order of rows. None are there unless `ThrongCharactersConfig.instances`.
 *
 * @param instances room for `capacity` records.
 * @param count how many there are; more than `capacity` are left out.
 *
 * @pre
 * `instances` has this room, `count` can be written.
 */
enum ThrongStatus throng_characters_instances(struct ThrongSimulation simulation,
                                              struct ThrongInstance *instances,
                                              size_t capacity,
                                              size_t *count);

/**
 * How many frame rows a bundle has.
 *
 * @pre
 * `count` can be written.
 */
enum ThrongStatus throng_bundle_num_rows(struct ThrongBundle bundle, size_t *count);

/**
 * Writes the poses of all frame rows, once for a bundle: the matrix from each joint to the character's own frame. A body
 * is skinned by such a matrix after the inverse of the joint's one at rest, which does not turn.
 *
 * @param matrices rows times `THRONG_NUM_JOINTS` matrices, without gaps.
 * @param size its length (bytes).
 * @param layout a `ThrongLayout`.
 *
 * @pre
 * `matrices` has room for `size` bytes.
 */
enum ThrongStatus throng_bundle_write_rows(struct ThrongBundle bundle,
                                           float *matrices,
                                           size_t size,
                                           uint32_t layout);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* THRONG_H */
