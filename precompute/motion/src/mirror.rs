//! Left and right exchanged.

use crate::clip::{Clip, ClipHit, ClipTag};
use glam::{Quat, Vec3};
use throng_core::{Contacts, Joint, NUM_JOINTS, format::ClassSpan};

/// Suffix of the name of a mirrored copy.
pub const SUFFIX: &str = "~mirror";

/// The clip as seen in a mirror: x becomes -x, left joints play the right ones' part, contacts included.
///
/// Mirroring twice gives the clip back, name included. On a skeleton whose sides differ, joints land as far from
/// the mirror image as the sides differ.
pub fn mirror_clip(clip: &Clip) -> Clip {
    let original = clip.name.strip_suffix(SUFFIX).filter(|_| clip.mirrored);
    let name = original.map_or_else(|| format!("{}{SUFFIX}", clip.name), str::to_string);
    let mirrored = |f: usize| {
        let local = clip.frame_rotations(f);
        Joint::ALL.map(|j| mirror_rotation(local[j.mirrored().index()]))
    };
    let rotations: Vec<Quat> = (0..clip.num_frames()).flat_map(mirrored).collect();
    debug_assert_eq!(rotations.len(), clip.num_frames() * NUM_JOINTS);
    Clip {
        name,
        source: clip.source.clone(),
        mirrored: !clip.mirrored,
        rate_hz: clip.rate_hz,
        root_positions: clip.root_positions.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect(),
        rotations,
        contacts: clip.contacts.iter().copied().map(Contacts::mirrored).collect(),
        excluded: clip.excluded.clone(),
        tags: mirror_tags(&clip.tags),
        hits: clip.hits.iter().map(mirror_hit).collect(),
        classes: clip.classes.iter().map(mirror_span).collect(),
        support: clip.support.clone(),
    }
}

/// The hit of the mirrored clip.
pub fn mirror_hit(hit: &ClipHit) -> ClipHit {
    let flip = Vec3::new(-1.0, 1.0, 1.0);
    ClipHit {
        joint: hit.joint.mirrored(),
        position: hit.position * flip,
        direction: hit.direction * flip,
        ..hit.clone()
    }
}

/// The span of the mirrored clip.
pub fn mirror_span(span: &ClassSpan) -> ClassSpan {
    ClassSpan { travel_deg: -span.travel_deg, ..span.clone() }
}

/// The tags of the mirrored clip: the words `left` and `right` in their names change places.
pub fn mirror_tags(of: &[ClipTag]) -> Vec<ClipTag> {
    of.iter().map(|t| ClipTag { name: mirrored_name(&t.name), range: t.range.clone() }).collect()
}

fn mirrored_name(name: &str) -> String {
    let other = |word: &str| match word {
        "left" => "right".to_string(),
        "right" => "left".to_string(),
        _ => word.to_string(),
    };
    name.split('_').map(other).collect::<Vec<_>>().join("_")
}

/// The mirror image at x = 0 of a rotation, for the joint on the other side: its axis is a pseudovector, so y and z of it
/// change sign.
pub fn mirror_rotation(q: Quat) -> Quat {
    Quat::from_xyzw(q.x, -q.y, -q.z, q.w)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use throng_core::Skeleton;

    fn clip(seeds: &[[f32; 4]]) -> Clip {
        let frames = seeds.len() / NUM_JOINTS;
        Clip {
            source: "c.bvh".into(),
            contacts: (0..frames).map(|f| Contacts(f as u8 & 15)).collect(),
            tags: vec![ClipTag { name: "t".into(), range: 0..1 }],
            ..Clip::new(
                "c",
                30.0,
                (0..frames).map(|f| Vec3::from_slice(&seeds[f][..3])).collect(),
                seeds.iter().map(|s| (Quat::from_array(*s) + Quat::IDENTITY * 3.0).normalize()).collect(),
            )
        }
    }

    #[test]
    fn sides_change_places_in_tags() {
        let name = |s: &str| mirror_tags(&[ClipTag { name: s.into(), range: 0..1 }])[0].name.clone();
        assert_eq!(["left_hook", "slip_right", "lefty", "jab"].map(name), ["right_hook", "slip_left", "lefty", "jab"]);
    }

    proptest! {
        #[test]
        fn twice_is_the_identity(seeds in prop::collection::vec(prop::array::uniform4(-1.0f32..1.0), 3 * NUM_JOINTS)) {
            let c = clip(&seeds);
            prop_assert_eq!(mirror_clip(&mirror_clip(&c)), c);
        }

        #[test]
        fn joints_land_on_their_mirror_image(
            seeds in prop::collection::vec(prop::array::uniform4(-1.0f32..1.0), NUM_JOINTS),
        ) {
            let (c, s) = (clip(&seeds), Skeleton::default());
            let (p, m) = (c.joint_positions(&s, 0), mirror_clip(&c).joint_positions(&s, 0));
            for j in Joint::ALL {
                let image = p[j.mirrored().index()] * Vec3::new(-1.0, 1.0, 1.0);
                prop_assert!((m[j.index()] - image).length() < 1e-5, "{}", j.name());
            }
        }
    }

    #[test]
    fn feet_change_sides_in_contacts() {
        let mut c = clip(&[[0.0; 4]; NUM_JOINTS]);
        c.contacts = vec![Contacts::LEFT_HEEL];
        assert_eq!(mirror_clip(&c).contacts, [Contacts::RIGHT_HEEL]);
        assert_eq!(mirror_clip(&c).name, "c~mirror");
        c.name = "c~mirror".into();
        assert_eq!((mirror_clip(&c).name.as_str(), mirror_clip(&mirror_clip(&c)).name), ("c~mirror~mirror", c.name));
    }
}
