//! Takes written and read back by the project's own readers: every joint is where it was, on the plain body and on others.

mod clients;
mod skins;
mod worn;

use glam::{Quat, Vec3};
use std::path::Path;
use throng_core::{Joint, NUM_JOINTS, Skeleton};
use throng_motion::export::{ActorPose, Glb, Take, TakeWriter, bvh, take_csv, usda, write_amass, write_npz};
use throng_motion::import::{ImportConfig, ImportedClip, read_clip, read_clips};

/// Frames of the takes here: more than one block.
const FRAMES: usize = 300;
/// When the third actor is there.
const THERE: std::ops::Range<usize> = 40..250;

/// A skeleton, larger by a factor.
pub fn sized(by: f32) -> Skeleton {
    let mut skeleton = Skeleton::default();
    skeleton.offsets.iter_mut().chain(&mut skeleton.tips).for_each(|o| *o *= by);
    skeleton
}

/// An actor's pose: it walks a curve, swings its limbs and twists its hands.
pub fn pose(skeleton: &Skeleton, actor: usize, frame: usize) -> ActorPose {
    use Joint::*;
    let (t, a) = (frame as f32 / 30.0, actor as f32);
    let mut rotations = [Quat::IDENTITY; NUM_JOINTS];
    let heading = a + 0.4 * t;
    rotations[0] = Quat::from_rotation_y(heading) * Quat::from_rotation_x(0.05 * t.sin());
    let mut turn = |joint: Joint, q: Quat| rotations[joint.index()] = q;
    turn(Spine, Quat::from_rotation_x(0.1) * Quat::from_rotation_y(0.2 * t.sin()));
    turn(Neck, Quat::from_rotation_y(0.5 * (2.0 * t).sin()));
    for (s, thigh, shin, foot, arm, forearm, hand) in [
        (1.0, LeftThigh, LeftShin, LeftFoot, LeftUpperArm, LeftForearm, LeftHand),
        (-1.0, RightThigh, RightShin, RightFoot, RightUpperArm, RightForearm, RightHand),
    ] {
        let swing = s * (3.0 * t + a).sin();
        turn(thigh, Quat::from_rotation_x(-0.2 - 0.4 * swing));
        turn(shin, Quat::from_rotation_x(0.4 + 0.3 * swing));
        turn(foot, Quat::from_rotation_x(-0.1));
        turn(arm, Quat::from_rotation_x(0.4 * swing) * Quat::from_rotation_z(-1.2 * s));
        turn(forearm, Quat::from_rotation_y(-s * (0.6 + 0.3 * swing)));
        turn(hand, Quat::from_rotation_x(0.8 * (t + a).sin()));
    }
    let root = Vec3::new(4.0 * a + t.cos(), skeleton.offsets[0].y - 0.03, 2.0 * t.sin());
    ActorPose::from_rotations(skeleton, root, rotations)
}

/// Three actors of different sizes; the third comes later and leaves earlier.
pub fn take() -> (Take, Vec<Skeleton>) {
    let skeletons = vec![Skeleton::default(), sized(0.8), Skeleton::default()];
    let actors = skeletons.iter().enumerate().map(|(i, s)| (10 + i, format!("walker {}", 10 + i), s.clone())).collect();
    let mut writer = TakeWriter::new(&std::env::temp_dir(), actors, 30.0).unwrap();
    for frame in 0..FRAMES {
        for (a, skeleton) in skeletons.iter().enumerate() {
            let there = a < 2 || THERE.contains(&frame);
            writer.push(a, there.then(|| pose(skeleton, a, frame))).unwrap();
        }
    }
    (writer.into_take().unwrap(), skeletons)
}

/// How far joints are at most from where they should be, over all roles (m).
pub fn farthest(read: &ImportedClip, first: usize, expected: impl Fn(usize) -> ActorPose) -> f32 {
    let mut worst = 0f32;
    for frame in 0..read.clip.num_frames {
        let (got, want) = (read.clip.world(frame), expected(first + frame).world_transforms());
        for joint in Joint::ALL {
            let Some(j) = read.roles.get(joint) else { panic!("{}: no {}", read.clip.name, joint.name()) };
            worst = worst.max(got[j].0.distance(want[joint.index()].0));
        }
    }
    worst
}

/// The bytes of a file with plain bodies.
pub fn glb(take: &Take) -> Vec<u8> {
    let document = Glb::new(take).unwrap();
    let mut bytes = Vec::new();
    document.write(&mut bytes).unwrap();
    assert_eq!(bytes.len() as u64, document.num_bytes());
    bytes
}

/// The clips of a file; who is away at first has no size then, and is no clip.
pub fn read_all(folder: &Path, name: &str, bytes: &[u8]) -> Vec<ImportedClip> {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    let config = ImportConfig { metres_per_unit: Some(1.0), ..ImportConfig::default() };
    read_clips(&path, &config).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn gltf_holds_every_joint_of_every_character() {
    let (take, skeletons) = take();
    let folder = tempfile::tempdir().unwrap();
    let read = read_all(folder.path(), "take.glb", &glb(&take));
    assert_eq!(read.len(), 2);
    for (a, clip) in read.iter().enumerate() {
        assert!(clip.clip.name.ends_with(&format!("walker {}", 10 + a)), "{}", clip.clip.name);
        assert_eq!((clip.clip.num_frames, clip.clip.rate_hz), (FRAMES, 30.0));
        let off = farthest(clip, 0, |f| pose(&skeletons[a], a, f));
        assert!(off < 1e-4, "actor {a}: {off} m");
    }
}

#[test]
fn who_is_away_has_no_size_in_gltf() {
    let (take, _) = take();
    let bytes = glb(&take);
    let (document, buffer) = throng_motion::import::gltf::document(&bytes).unwrap();
    let buffer = buffer.unwrap();
    let channels = &document.animations[0].channels;
    let scale: Vec<_> = channels.iter().filter(|c| c.target.path == "scale").collect();
    assert_eq!(scale.len(), 1, "one of three is ever away");
    assert_eq!(document.nodes[scale[0].target.node.unwrap()].name, "walker 12");
    let values = &document.accessors[document.animations[0].samplers[scale[0].sampler].output];
    let begin = document.buffer_views[values.buffer_view.unwrap()].byte_offset + values.byte_offset;
    for frame in 0..FRAMES {
        let at = begin + 12 * frame;
        let number = f32::from_le_bytes(buffer[at..at + 4].try_into().unwrap());
        assert_eq!(number, if THERE.contains(&frame) { 1.0 } else { 0.0 }, "frame {frame}");
    }
    // Meshes, bind matrices and times are shared: two skeletons, one clock.
    assert_eq!((document.meshes.len(), document.skins.len()), (2, 3));
    let inputs: std::collections::BTreeSet<usize> = document.animations[0].samplers.iter().map(|s| s.input).collect();
    assert_eq!(inputs.len(), 1);
}

#[test]
fn bvh_holds_an_actor_while_it_is_there() {
    let (take, skeletons) = take();
    let folder = tempfile::tempdir().unwrap();
    for (a, skeleton) in skeletons.iter().enumerate() {
        let path = folder.path().join(format!("{a}.bvh"));
        let mut bytes = Vec::new();
        bvh::write_actor(&take, a, &mut bytes).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let read = read_clip(&path, &ImportConfig::default()).unwrap();
        let there = if a == 2 { THERE } else { 0..FRAMES };
        assert_eq!(read.clip.num_frames, there.len());
        let off = farthest(&read, there.start, |f| pose(skeleton, a, f));
        assert!(off < 1e-4, "actor {a}: {off} m");
    }
}

#[test]
fn amass_holds_turns_and_ways_of_an_actor() {
    let (take, skeletons) = take();
    let folder = tempfile::tempdir().unwrap();
    // Such files have no lengths: the reader takes those of the default skeleton, which these two have.
    for (a, there) in [(0, 0..FRAMES), (2, THERE)] {
        let path = folder.path().join(format!("{a}.npz"));
        let mut bytes = Vec::new();
        write_amass(&take, a, &mut bytes).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let read = read_clip(&path, &ImportConfig::default()).unwrap();
        assert_eq!((read.clip.num_frames, read.clip.rate_hz), (there.len(), 30.0));
        let off = farthest(&read, there.start, |f| pose(&skeletons[a], a, f));
        assert!(off < 1e-4, "actor {a}: {off} m");
    }
}

#[test]
fn arrays_and_tables_hold_all_actors() {
    let (take, skeletons) = take();
    let mut bytes = Vec::new();
    write_npz(&take, &mut bytes).unwrap();
    let mut zip = zip::ZipArchive::new(std::io::Cursor::new(&bytes)).unwrap();
    let file = zip.by_name("positions.npy").unwrap();
    assert_eq!((file.compression(), file.size()), (zip::CompressionMethod::Stored, file.compressed_size()));
    let begin = file.data_start().unwrap() as usize;
    let header = u16::from_le_bytes([bytes[begin + 8], bytes[begin + 9]]) as usize;
    let numbers = begin + 10 + header;
    assert!(numbers.is_multiple_of(64), "numbers begin at {numbers}");
    let text = String::from_utf8_lossy(&bytes[begin + 10..numbers]).into_owned();
    assert!(text.contains(&format!("'shape': (3, {FRAMES}, 22, 3, )")), "{text}");
    let number = |k: usize| f32::from_le_bytes(bytes[numbers + 4 * k..numbers + 4 * k + 4].try_into().unwrap());
    let mut csv = Vec::new();
    take_csv(&take, &mut csv).unwrap();
    let csv = String::from_utf8(csv).unwrap();
    let mut lines = csv.lines().skip(1);
    for (a, skeleton) in skeletons.iter().enumerate() {
        for frame in 0..FRAMES {
            if a == 2 && !THERE.contains(&frame) {
                continue;
            }
            let world = pose(skeleton, a, frame).world_transforms();
            for joint in Joint::ALL {
                let at = ((a * FRAMES + frame) * NUM_JOINTS + joint.index()) * 3;
                let got = Vec3::new(number(at), number(at + 1), number(at + 2));
                assert!(got.distance(world[joint.index()].0) < 1e-5, "actor {a}, frame {frame}");
                let fields: Vec<&str> = lines.next().unwrap().split(',').collect();
                assert_eq!((fields[0], fields[2]), (&*(10 + a).to_string(), joint.name()));
                let read = Vec3::from_array(std::array::from_fn(|k| fields[3 + k].parse().unwrap()));
                assert!(read.distance(got) < 1e-5);
            }
        }
    }
    assert_eq!(lines.next(), None);
}

#[test]
fn usd_says_every_turn_and_when_somebody_is_away() {
    let (take, skeletons) = take();
    for instances in [false, true] {
        let mut bytes = Vec::new();
        usda(&take, instances, &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert!(text.starts_with("#usda 1.0\n"));
        let depth = text.chars().fold(0i32, |d, c| d + i32::from(c == '{') - i32::from(c == '}'));
        assert_eq!(depth, 0, "braces match");
        assert_eq!(text.matches("instanceable = true").count(), if instances { 3 } else { 0 });
        assert_eq!(text.matches("def SkelAnimation").count(), 3);
        assert!(text.contains("0: \"invisible\",\n            40: \"inherited\",\n            250: \"invisible\",\n"));
        // The second actor's turns at frame 7, w first.
        let animations: Vec<&str> = text.split("quatf[] rotations.timeSamples = {").collect();
        let row = animations[2].lines().find(|l| l.trim_start().starts_with("7: ")).unwrap();
        let numbers: Vec<f32> = row
            .split_once('[')
            .unwrap()
            .1
            .split(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | 'e')))
            .filter_map(|n| n.parse().ok())
            .collect();
        assert_eq!(numbers.len(), 4 * NUM_JOINTS);
        for (want, got) in pose(&skeletons[1], 1, 7).rotations.iter().zip(numbers.chunks(4)) {
            assert!(want.dot(Quat::from_xyzw(got[1], got[2], got[3], got[0])).abs() > 1.0 - 1e-6);
        }
    }
}

#[test]
fn a_library_is_one_figure_with_an_animation_for_each_clip() {
    let skeleton = Skeleton::default();
    let clip = |name: &str, frames: usize, actor: usize| {
        let poses: Vec<ActorPose> = (0..frames).map(|f| pose(&skeleton, actor, f)).collect();
        let roots = poses.iter().map(|p| p.translations[0]).collect();
        let turns = poses.iter().flat_map(|p| p.rotations).collect();
        throng_motion::Clip::new(name, 30.0, roots, turns)
    };
    let clips = [clip("a", 20, 0), clip("b", 33, 1)];
    let take = Take::from_clips(&std::env::temp_dir(), &clips, &skeleton).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let read = read_all(folder.path(), "clips.glb", &glb(&take));
    assert_eq!(read.iter().map(|r| r.clip.num_frames).collect::<Vec<_>>(), [20, 33]);
    for (a, clip) in read.iter().enumerate() {
        let off = farthest(clip, 0, |f| pose(&skeleton, a, f));
        assert!(off < 1e-4, "clip {a}: {off} m");
    }
}
