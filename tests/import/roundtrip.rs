//! Writing a clip and reading it back changes no position.

use glam::{Quat, Vec3};
use proptest::prelude::*;
use std::path::{Path, PathBuf};
use throng_precompute::export;
use throng_precompute::import::bvh;
use throng_precompute::raw::{RawClip, RawJoint, SourceFormat};

fn direction() -> impl Strategy<Value = Vec3> {
    (-1f32..1.0, -1f32..1.0, -1f32..1.0).prop_map(Vec3::from)
}

fn rotation() -> impl Strategy<Value = Quat> {
    (direction(), 0f32..1.0).prop_map(|(v, w)| Quat::from_xyzw(v.x, v.y, v.z, w + 1e-3).normalize())
}

/// A random tree of joints that all turn, some of which also move.
fn clip() -> impl Strategy<Value = RawClip> {
    let joints = prop::collection::vec((any::<prop::sample::Index>(), direction(), any::<bool>(), 0u8..9), 1..9);
    (joints, 1usize..4, prop_oneof![Just(30.0), Just(120.0), 1.0..240.0f64]).prop_flat_map(|(joints, frames, rate)| {
        let n = joints.len() * frames;
        (prop::collection::vec(rotation(), n), prop::collection::vec(direction(), n)).prop_map(
            move |(rotations, moves)| {
                let tree = joints.iter().enumerate().map(|(i, (p, offset, _, root))| RawJoint {
                    name: format!("j{i}"),
                    parent: (i > 0 && *root > 0).then(|| p.index(i)),
                    offset: *offset,
                    rest_rotation: Quat::IDENTITY,
                    is_end: false,
                });
                let translations = (0..n).map(|k| {
                    joints[k % joints.len()].1 + if joints[k % joints.len()].2 { moves[k] } else { Vec3::ZERO }
                });
                RawClip {
                    name: "random".into(),
                    path: PathBuf::from("random.bvh"),
                    format: SourceFormat::Bvh,
                    translations: translations.collect(),
                    joints: tree.collect(),
                    rate_hz: rate,
                    num_frames: frames,
                    rotations,
                }
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn bvh_written_and_read_keeps_every_position(clip in clip()) {
        let mut text = Vec::new();
        export::bvh::write_clip(&clip, &mut text).unwrap();
        let back = bvh::parse(&text, Path::new("back.bvh")).unwrap().clip;
        prop_assert_eq!(back.num_frames, clip.num_frames);
        prop_assert!((back.rate_hz - clip.rate_hz).abs() < 1e-6 * clip.rate_hz);
        for frame in 0..clip.num_frames {
            let (before, after) = (clip.world(frame), back.world(frame));
            for (j, joint) in clip.joints.iter().enumerate() {
                let k = back.joints.iter().position(|b| b.name == joint.name).unwrap();
                let (p, q) = (before[j].0, after[k].0 * 0.01);
                prop_assert!(p.distance(q) < 1e-4, "{} at {p}, read back at {q}", joint.name);
            }
        }
    }
}

#[test]
fn written_bvh_is_in_centimetres_with_channels_only_where_something_moves() {
    let source = super::formats::parse_bvh(super::formats::BVH).clip;
    let mut text = Vec::new();
    export::bvh::write_clip(&source, &mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("OFFSET 0.000000 -500.000000 0.000000"), "{text}");
    assert_eq!(text.matches("CHANNELS 6").count(), 1);
    assert_eq!(text.matches("End Site").count(), 1);
    assert!(text.contains("Frame Time: 0.033333333333\n"));
    // Writing what was read gives the same text but for the scale: names, ends and rates survive.
    let again = bvh::parse(text.as_bytes(), Path::new("a.bvh")).unwrap().clip;
    assert_eq!(again.joints.iter().map(|j| &j.name).collect::<Vec<_>>(), ["Hips", "Knee", "Knee_end"]);
    assert_eq!(again.rate_hz, 30.0);
}

#[test]
fn position_tables_have_a_row_per_frame_and_joint() {
    let clip = super::formats::parse_bvh(&super::formats::BVH.replace("Knee", "a,b")).clip;
    let mut csv = Vec::new();
    export::positions_csv(&clip, &mut csv).unwrap();
    let csv = String::from_utf8(csv).unwrap();
    let rows: Vec<_> = csv.lines().collect();
    assert_eq!(rows.len(), 1 + 2 * 3);
    assert_eq!(
        rows[..3],
        ["frame,joint,x,y,z", "0,Hips,1.000000,2.000000,3.000000", "0,\"a,b\",1.000000,-3.000000,3.000000"]
    );
    assert!(rows[4].starts_with("1,Hips,"));
}
