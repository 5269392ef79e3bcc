/* Throng's runtime for C and C++. Made by `cargo test -p throng-capi`: do not edit. */

#ifndef THRONG_H
#define THRONG_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/**
 * Number of joints of every skeleton; parents come before their children.
 */
#define THRONG_NUM_JOINTS 22

/**
 * Status of a call. `throng_last_error` has the reason in words.
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
   * The handle was freed, or never existed.
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
   * The place is taken, or no path leads there.
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
 * Progress of a character's order.
 */
typedef enum ThrongProgress {
  /**
   * No order.
   */
  THRONG_PROGRESS_IDLE = 0,
  /**
   * On its way.
   */
  THRONG_PROGRESS_GOING = 1,
  /**
   * Arrived at its target.
   */
  THRONG_PROGRESS_THERE = 2,
  /**
   * Blocked: no progress.
   */
  THRONG_PROGRESS_BLOCKED = 3,
  /**
   * No path leads to its target.
   */
  THRONG_PROGRESS_NO_PATH = 4,
} ThrongProgress;

/**
 * Kind of an event of a character.
 */
typedef enum ThrongHappened {
  /**
   * Its blow has landed, or, for characters of a bundle, has reached its point.
   */
  THRONG_HAPPENED_HIT = 0,
  /**
   * Its blow met `other`, its opponent.
   */
  THRONG_HAPPENED_STRUCK = 1,
  /**
   * Its goal is fulfilled.
   */
  THRONG_HAPPENED_FULFILLED = 2,
  /**
   * Arrival at its goal.
   */
  THRONG_HAPPENED_ARRIVED = 3,
  /**
   * Departure at its goal.
   */
  THRONG_HAPPENED_LEFT = 4,
  /**
   * Stuck: no progress towards its goal.
   */
  THRONG_HAPPENED_STUCK = 5,
  /**
   * The moving obstacle `other` ran into it.
   */
  THRONG_HAPPENED_RUN_INTO = 6,
  /**
   * The foot that is joint `other` has come down.
   */
  THRONG_HAPPENED_FOOTSTEP = 7,
  /**
   * A part of the body, joint `other`, began to touch the ground or a thing.
   */
  THRONG_HAPPENED_CONTACT_BEGAN = 8,
  /**
   * A part, joint `other`, has ended to touch.
   */
  THRONG_HAPPENED_CONTACT_ENDED = 9,
  /**
   * The motion has come into a named range of a clip: `other` is 256 times the clip, plus the tag.
   */
  THRONG_HAPPENED_TAG = 10,
} ThrongHappened;

/**
 * Memory layout and axes of matrices.
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
   * Unreal's `FMatrix` of floats, rows that hold the axes and then the position; left-handed, X forward, Y right, Z up,
   * centimetres.
   */
  THRONG_LAYOUT_UNREAL = 2,
} ThrongLayout;

/**
 * A bundle of tables. Simulations made from it keep working when it is freed.
 */
typedef struct ThrongBundle {
  /**
   * Number of the handle; zero is none.
   */
  uint64_t handle;
} ThrongBundle;

/**
 * A joint of a skeleton in rest pose, where every joint's rotation is the identity in Throng's axes.
 */
typedef struct ThrongJoint {
  /**
   * Number of the parent joint; -1 for the first.
   */
  int32_t parent;
  /**
   * Offset from the parent (m; X left, Y up, Z forward).
   */
  float offset[3];
} ThrongJoint;

/**
 * A simulation of characters. Only one thread at a time may call with it, except for `throng_simulation_help`.
 */
typedef struct ThrongSimulation {
  /**
   * Number of the handle; zero is none.
   */
  uint64_t handle;
} ThrongSimulation;

/**
 * Settings of characters of a bundle.
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
   * Greatest number of characters at a time.
   */
  uint32_t capacity;
  /**
   * 1: characters avoid each other. 0: they ignore each other.
   */
  uint32_t avoids;
  /**
   * Randomness of choices: 0 takes the best action; above 0, one of the best few at random.
   */
  float temperature;
  /**
   * Time in which the offset of a transition halves (s).
   */
  float half_life_s;
  /**
   * 1: steps also write a `ThrongInstance` of every character.
   */
  uint32_t instances;
  /**
   * Reserved; 0.
   */
  uint32_t reserved;
} ThrongCharactersConfig;

/**
 * Identifies a character; unique in its simulation for all time. In scenes the index is its number, and the generation
 * is 0.
 */
typedef struct ThrongId {
  /**
   * Place of the character (< capacity).
   */
  uint32_t index;
  /**
   * Number of previous characters at this place.
   */
  uint32_t generation;
} ThrongId;

/**
 * What a body does beside its motion.
 */
typedef struct ThrongLayers {
  /**
   * `sizeof(ThrongLayers)`; all else may be 0.
   */
  size_t struct_size;
  /**
   * 1: head and neck turn to `look_at`.
   */
  uint32_t looks;
  /**
   * A point in the world (m).
   */
  float look_at[3];
  /**
   * What the left and the right arm do. 0: as their motion. 1: points. 2: waves. 3: carries beside the body, 4: before it, 5: on the
   * shoulder. 6: holds a telephone at the ear. 7: reaches; trunk and hips give way.
   */
  uint32_t arms[2];
  /**
   * Where they point or reach, in the world (m).
   */
  float arms_at[2][3];
  /**
   * Bend of the trunk forwards and to the left (radians, -0.6 to 0.6).
   */
  float lean[2];
  /**
   * First frame row of the bundle that joints show.
   */
  uint32_t first_frame;
  /**
   * Number of frames; 0 for none.
   */
  uint32_t num_frames;
  /**
   * A bit for each joint that shows them; those of hips and legs have no effect.
   */
  uint32_t joints;
  /**
   * 1: after the last frame the first follows.
   */
  uint32_t loops;
} ThrongLayers;

/**
 * Order to a person of a scene: an agent, or a captured person on the way to a goal.
 */
typedef struct ThrongOrder {
  /**
   * `sizeof(ThrongOrder)`; all else may be 0, which lets it stop.
   */
  size_t struct_size;
  /**
   * 0: stops. 1: goes to `at`. 2: follows `whom`. 3: walks on at the velocity `at`.
   */
  uint32_t task;
  /**
   * Number of the person that it follows.
   */
  uint32_t whom;
  /**
   * Place in the world, or velocity along x and z (m, m/s).
   */
  float at[3];
  /**
   * Distance that is kept to `whom` (m); 0 for 1.5 m.
   */
  float keep_m;
  /**
   * Desired speed from now on (m/s); 0 leaves it as it is. Captured people take the gait that is nearest to it.
   */
  float speed_mps;
  /**
   * 1: it faces `heading` at its goal, or turns to it where it stops.
   */
  uint32_t faces;
  /**
   * Heading about +Y from +Z (rad).
   */
  float heading;
} ThrongOrder;

/**
 * Position and heading of a character.
 */
typedef struct ThrongRoot {
  /**
   * The character.
   */
  struct ThrongId id;
  /**
   * 0 if it has left, else 1.
   */
  uint32_t is_there;
  /**
   * Position along X, to the left of heading 0 (m).
   */
  float x;
  /**
   * Position along Z (m).
   */
  float z;
  /**
   * Heading about +Y from +Z (rad).
   */
  float heading;
} ThrongRoot;

/**
 * Event of the last step.
 */
typedef struct ThrongEvent {
  /**
   * Time of the event (s).
   */
  double time_s;
  /**
   * The character that it happened to, or that caused it.
   */
  struct ThrongId id;
  /**
   * Kind of the event.
   */
  enum ThrongHappened happened;
  /**
   * Number of the other character, obstacle, joint, tag or hit, for the kinds that have one; else 0.
   */
  uint32_t other;
  /**
   * Point of a blow or a footstep; zeros for other events (m).
   */
  float at[3];
  /**
   * Strength of a blow or a footstep (0 to 1); 0 for other events.
   */
  float strength;
} ThrongEvent;

/**
 * Eye of the viewer, and distances up to which characters are detailed. Their paths do not depend on it.
 *
 * Eight characters of neighbouring rows have one level: that of the nearest.
 */
typedef struct ThrongDetail {
  /**
   * Position of the eye along X (m).
   */
  float eye_x;
  /**
   * Position of the eye along Z (m).
   */
  float eye_z;
  /**
   * Distance up to which planted feet stay in place; -1 for no character (m).
   */
  float full_m;
  /**
   * Distance up to which poses are computed, at least `full_m`; the matrices of others stay as they were (m).
   */
  float posed_m;
} ThrongDetail;

/**
 * Record from which a GPU poses a character with the frame rows of its bundle (32 bytes; `throng_bundle_write_rows`).
 *
 * The pose is `mix(mix(row_a, row_a + 1, frac), mix(row_b, row_b + 1, frac), blend)`: the playing motion, and the motion
 * that a transition fades out. It stands at (x, y, z) and is turned by the heading, in Throng's axes: that is
 * (-x, y, z) and -heading in Unity, (100 z, -100 x, 100 y) and a yaw of -heading in Unreal.
 */
typedef struct ThrongInstance {
  /**
   * Frame row; the next row is of the same clip, or `frac` is 0.
   */
  uint32_t row_a;
  /**
   * Frame row of the motion that fades out; `row_a` without a transition.
   */
  uint32_t row_b;
  /**
   * Fraction of the way to the next rows (65535 is 1).
   */
  uint16_t frac;
  /**
   * Weight of `row_b` (65535 is 1).
   */
  uint16_t blend;
  /**
   * Number of the character's place, to vary its appearance (< capacity).
   */
  uint32_t variant;
  /**
   * Position along X, to the left of heading 0 (m).
   */
  float x;
  /**
   * Height of the ground (m).
   */
  float y;
  /**
   * Position along Z (m).
   */
  float z;
  /**
   * Heading about +Y from +Z (rad).
   */
  float heading;
} ThrongInstance;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Copies the message of the last failed call of this thread, in UTF-8 and with a zero at its end; cut if it is too long.
 *
 * @param buffer memory for the text; may be null where `size` is 0.
 * @param size its length (bytes).
 * @return the length of the whole text, without the zero (bytes).
 *
 * @pre
 * `buffer` must have room for `size` bytes.
 */
size_t throng_last_error(char *buffer,
                         size_t size);

/**
 * Opens a bundle file. Later changes to the file do not matter.
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
 * Writes the number of a behaviour's policy; the error message lists the existing names.
 *
 * @pre
 * `behaviour` ends with a zero, `policy` can be written.
 */
enum ThrongStatus throng_bundle_policy(struct ThrongBundle bundle, const char *behaviour, uint32_t *policy);

/**
 * Writes the skeleton of a bundle.
 *
 * @param joints room for `THRONG_NUM_JOINTS` joints.
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
 * Frees a simulation; a call of another thread ends first.
 */
enum ThrongStatus throng_simulation_free(struct ThrongSimulation simulation);

/**
 * Steps a simulation, on this thread and, if the step was announced, on helper threads.
 *
 * @param dt_s duration of the step (s, 0 to 1).
 */
enum ThrongStatus throng_simulation_step(struct ThrongSimulation simulation, double dt_s);

/**
 * Announces the next step, so that threads that call `throng_simulation_help` wait for it and work in it. Call it before
 * they start. The result of the step does not depend on their number, nor on when they call.
 */
enum ThrongStatus throng_simulation_announce(struct ThrongSimulation simulation);

/**
 * Helps with an announced step until it is over; returns at once if none is announced. Any number of the application's
 * own threads may call it at a time.
 */
enum ThrongStatus throng_simulation_help(struct ThrongSimulation simulation);

/**
 * Writes the number of characters, including those of a scene that have left.
 *
 * @pre
 * `count` can be written.
 */
enum ThrongStatus throng_simulation_count(struct ThrongSimulation simulation, size_t *count);

/**
 * Writes the simulated time (s).
 *
 * @pre
 * `time_s` can be written.
 */
enum ThrongStatus throng_simulation_time(struct ThrongSimulation simulation, double *time_s);

/**
 * Writes a hash of the state: the same for the same motion, on every machine and from every language.
 *
 * @pre
 * `hash` can be written.
 */
enum ThrongStatus throng_simulation_hash(struct ThrongSimulation simulation, uint64_t *hash);

/**
 * Copies the whole state that the next steps depend on, with a checksum.
 *
 * @param buffer room for `capacity` bytes; if it is null and `capacity` is 0, only `size` is written.
 * @param size length of the state (bytes). With less room nothing is copied, and `THRONG_STATUS_TOO_SMALL` is returned.
 *
 * @pre
 * `buffer` has this room, `size` can be written.
 */
enum ThrongStatus throng_simulation_save(struct ThrongSimulation simulation,
                                         uint8_t *buffer,
                                         size_t capacity,
                                         size_t *size);

/**
 * Restores a state that was saved with the same bundle or scene; a refused state changes nothing.
 *
 * @pre
 * `bytes` points to `size` bytes.
 */
enum ThrongStatus throng_simulation_restore(struct ThrongSimulation simulation, const uint8_t *bytes, size_t size);

/**
 * Fills in the defaults: seed 1, 1000 characters that avoid each other.
 *
 * @param size `sizeof(ThrongCharactersConfig)`.
 *
 * @pre
 * `config` has room for `size` bytes.
 */
enum ThrongStatus throng_characters_config_init(struct ThrongCharactersConfig *config, size_t size);

/**
 * Makes an empty simulation of characters that are moved by policies of a bundle.
 *
 * @pre
 * `config` points to as many bytes as its `struct_size` says, `simulation` can be written.
 */
enum ThrongStatus throng_characters_new(struct ThrongBundle bundle,
                                        const struct ThrongCharactersConfig *config,
                                        struct ThrongSimulation *simulation);

/**
 * Opens a scene file with its bundles and worlds, and places all characters.
 *
 * @pre
 * `path` ends with a zero, `simulation` can be written.
 */
enum ThrongStatus throng_simulation_open(const char *path, struct ThrongSimulation *simulation);

/**
 * Raises an event of the scene.
 *
 * @pre
 * `event` ends with a zero.
 */
enum ThrongStatus throng_simulation_raise(struct ThrongSimulation simulation, const char *event);

/**
 * Adds a character that stands at (x, z) and faces along the heading. Its pose is available after the next step.
 *
 * @param heading heading about +Y from +Z (rad).
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
 * Removes a character. The character of the last row takes its row.
 */
enum ThrongStatus throng_characters_despawn(struct ThrongSimulation simulation, struct ThrongId id);

/**
 * Moves a character to another place at once.
 */
enum ThrongStatus throng_characters_place(struct ThrongSimulation simulation,
                                          struct ThrongId id,
                                          float x,
                                          float z,
                                          float heading);

/**
 * Orders a character to follow a policy of the bundle from now on, with a target in the world (m); its layers stay.
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
 * Sets what the body of a character does beside its motion, from now on. Changes fade in and out.
 *
 * @pre
 * `layers` points to as many bytes as its `struct_size` says.
 */
enum ThrongStatus throng_characters_set_layers(struct ThrongSimulation simulation,
                                               struct ThrongId id,
                                               const struct ThrongLayers *layers);

/**
 * Orders a character to stop as soon as its motion allows, and to stand at ease; its layers stay.
 */
enum ThrongStatus throng_characters_stop(struct ThrongSimulation simulation, struct ThrongId id);

/**
 * Orders a character to stop, and to turn on the spot; its layers stay.
 *
 * @param heading heading about +Y from +Z (rad).
 */
enum ThrongStatus throng_characters_turn_to(struct ThrongSimulation simulation, struct ThrongId id, float heading);

/**
 * Orders a character a manner of motion, which stays until another one is ordered; its other order goes on. The error message
 * lists the manners there are.
 *
 * @param manner such as "sad"; "normal" is that which nothing sets apart.
 *
 * @pre
 * `manner` ends with a zero.
 */
enum ThrongStatus throng_characters_set_manner(struct ThrongSimulation simulation,
                                               struct ThrongId id,
                                               const char *manner);

/**
 * Orders a character a speed on its way, which stays; it takes the gait whose usual speed is nearest to that.
 *
 * @param speed_mps 0 for that which its policy prefers (m/s).
 */
enum ThrongStatus throng_characters_set_speed(struct ThrongSimulation simulation, struct ThrongId id, float speed_mps);

/**
 * Progress of a character's order.
 *
 * @param left_m remaining length of its path while it is on its way, else 0 (m).
 *
 * @pre
 * `progress` and `left_m` can be written.
 */
enum ThrongStatus throng_characters_progress(struct ThrongSimulation simulation,
                                             struct ThrongId id,
                                             enum ThrongProgress *progress,
                                             float *left_m);

/**
 * Gives a person of a scene an order, which holds until the next one, or until a rule of its brain lets it act.
 *
 * @pre
 * `order` points to as many bytes as its `struct_size` says.
 */
enum ThrongStatus throng_people_order(struct ThrongSimulation simulation,
                                      struct ThrongId id,
                                      const struct ThrongOrder *order);

/**
 * Raises an event of the scene for one agent alone, which learns of it.
 *
 * @pre
 * `event` ends with a zero.
 */
enum ThrongStatus throng_people_raise(struct ThrongSimulation simulation, struct ThrongId id, const char *event);

/**
 * Sets a value of an agent's brain, within the limits of the scene.
 *
 * @pre
 * `name` ends with a zero.
 */
enum ThrongStatus throng_people_set_value(struct ThrongSimulation simulation,
                                          struct ThrongId id,
                                          const char *name,
                                          float value);

/**
 * Number of floats of one matrix: 12 or 16; 0 for a layout that does not exist.
 */
size_t throng_layout_floats(uint32_t layout);

/**
 * Copies position and heading of all characters, in the order of rows.
 *
 * @param roots room for `capacity` records.
 * @param count number of records; those beyond `capacity` are left out.
 *
 * @pre
 * `roots` has this room, `count` can be written.
 */
enum ThrongStatus throng_simulation_roots(struct ThrongSimulation simulation,
                                          struct ThrongRoot *roots,
                                          size_t capacity,
                                          size_t *count);

/**
 * Copies the events of the last step.
 *
 * @param events room for `capacity` records.
 * @param count number of records; those beyond `capacity` are left out.
 *
 * @pre
 * `events` has this room, `count` can be written.
 */
enum ThrongStatus throng_simulation_events(struct ThrongSimulation simulation,
                                           struct ThrongEvent *events,
                                           size_t capacity,
                                           size_t *count);

/**
 * Writes the matrix from each joint to the world, for all characters, in one pass and in the axes of an engine. Matrices
 * of a character that has left or has no body are zero.
 *
 * @param matrices room for characters times `THRONG_NUM_JOINTS` matrices, those of a character side by side.
 * @param size its length (bytes).
 * @param stride distance from one character's first matrix to the next one's (bytes, a multiple of 4).
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
 * Sets which characters are posed in the next steps.
 *
 * @param detail null to pose all characters, which is the default.
 *
 * @pre
 * `detail` is null or can be read.
 */
enum ThrongStatus throng_characters_set_detail(struct ThrongSimulation simulation, const struct ThrongDetail *detail);

/**
 * Copies the records of all characters, in the order of rows. There are none unless `ThrongCharactersConfig.instances`.
 *
 * @param instances room for `capacity` records.
 * @param count number of records; those beyond `capacity` are left out.
 *
 * @pre
 * `instances` has this room, `count` can be written.
 */
enum ThrongStatus throng_characters_instances(struct ThrongSimulation simulation,
                                              struct ThrongInstance *instances,
                                              size_t capacity,
                                              size_t *count);

/**
 * Writes the number of frame rows of a bundle.
 *
 * @pre
 * `count` can be written.
 */
enum ThrongStatus throng_bundle_num_rows(struct ThrongBundle bundle, size_t *count);

/**
 * Writes the poses of all frame rows, once for a bundle: the matrix from each joint to the character's own frame. To skin
 * a body, multiply such a matrix by the inverse of the joint's matrix at rest, which has no rotation.
 *
 * @param matrices room for rows times `THRONG_NUM_JOINTS` matrices, without gaps.
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
