//! Several performers in one hierarchy: each becomes a clip of its own.

use super::{SourceClip, duplicate_names, roles};
use crate::raw::{RawClip, RawJoint};
use glam::{Quat, Vec3};
use throng_base::maths;

/// Least number of joints of a body, without ends of chains.
const LEAST_JOINTS: usize = 10;

/// The clips of all performers of a file: of each root, or each branch below one, that is a body by itself.
///
/// - returns the clip unchanged where there is no more than one.
pub(super) fn split_performers(source: SourceClip) -> Vec<SourceClip> {
    let (clip, roots) = (&source.clip, branches(&source.clip.joints));
    // Joints above the roots move them; all roots hang on one joint, or on none.
    let above = roots.first().and_then(|&root| clip.joints[root].parent);
    let above: Vec<(Vec3, Quat)> =
        above.map_or_else(Vec::new, |j| (0..clip.num_frames).map(|f| clip.world_of(j, f)).collect());
    let parts = roots.into_iter().map(|root| branch(clip, root, &above));
    let bodies: Vec<RawClip> = parts.filter(|clip| roles::assign(clip, &[], None).is_ok()).collect();
    if bodies.len() < 2 {
        return vec![source];
    }
    let names: Vec<String> = bodies.iter().map(|b| b.joints[0].name.replace(['/', '\\'], "_")).collect();
    let count = bodies.len();
    let is_twice = |name: &String| names.iter().filter(|n| *n == name).count() > 1;
    let some_twice = names.iter().any(is_twice);
    // Numbers replace names that other roots have, too.
    let is_number = |name: &str| name.parse().is_ok_and(|n: usize| (1..=count).contains(&n));
    let is_taken = |i: usize| is_twice(&names[i]) || (some_twice && is_number(&names[i]));
    let named = |(i, clip): (usize, RawClip)| {
        let name = if is_taken(i) { (i + 1).to_string() } else { names[i].clone() };
        let path = source.clip.path.join(&name);
        let mut findings = source.findings.clone();
        findings.push(format!("The file holds {count} performers: this one hangs on joint `{}`.", clip.joints[0].name));
        let warnings = duplicate_names(&clip.joints, &path);
        let clip = RawClip { name: format!("{}/{name}", source.clip.name), path, ..clip };
        SourceClip { clip, declared_metres_per_unit: source.declared_metres_per_unit, findings, warnings }
    };
    bodies.into_iter().enumerate().map(named).collect()
}

/// The roots, or else the uppermost joints that hang on one joint, where two or more of them carry enough joints for a body.
fn branches(joints: &[RawJoint]) -> Vec<usize> {
    let mut size: Vec<usize> = joints.iter().map(|j| usize::from(!j.is_end)).collect();
    for (j, p) in (0..joints.len()).rev().filter_map(|j| Some((j, joints[j].parent?))) {
        size[p] += size[j];
    }
    let below = |parent: Option<usize>| -> Vec<usize> {
        (0..joints.len()).filter(|&j| joints[j].parent == parent && size[j] >= LEAST_JOINTS).collect()
    };
    let mut at = below(None);
    while let [one] = at[..] {
        at = below(Some(one));
    }
    at
}

/// The part of a clip below a joint, which becomes the root.
///
/// - `above`: world transforms of the joint that it hangs on (num_frames); empty where there is none.
fn branch(clip: &RawClip, root: usize, above: &[(Vec3, Quat)]) -> RawClip {
    let n = clip.joints.len();
    let mut place = vec![None; n];
    let mut kept = Vec::new();
    for (j, joint) in clip.joints.iter().enumerate() {
        if j == root || joint.parent.is_some_and(|p| place[p].is_some()) {
            place[j] = Some(kept.len());
            kept.push(j);
        }
    }
    let joint = |&j: &usize| {
        let joint = clip.joints[j].clone();
        RawJoint { parent: joint.parent.filter(|_| j != root).and_then(|p| place[p]), ..joint }
    };
    let mut out = RawClip {
        joints: kept.iter().map(joint).collect(),
        translations: Vec::with_capacity(clip.num_frames * kept.len()),
        rotations: Vec::with_capacity(clip.num_frames * kept.len()),
        name: clip.name.clone(),
        path: clip.path.clone(),
        ..*clip
    };
    for f in 0..clip.num_frames {
        for &j in &kept {
            let (at, turn) = (clip.translations[f * n + j], clip.rotations[f * n + j]);
            let moves = above.get(f).filter(|_| j == root);
            out.translations.push(moves.map_or(at, |(p, r)| *p + *r * at));
            out.rotations.push(moves.map_or(turn, |(_, r)| maths::compose(*r, turn)));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::bvh;
    use std::path::Path;

    #[test]
    fn what_is_above_a_root_moves_it() {
        let text = "HIERARCHY ROOT r { OFFSET 0 1 0 CHANNELS 3 Xrotation Yrotation Zrotation JOINT a { OFFSET 2 0 0 CHANNELS 1 \
                    Yrotation JOINT b { OFFSET 0 3 0 CHANNELS 1 Zrotation End Site { OFFSET 1 0 0 } } } } MOTION\nFrames: \
                    2\nFrame Time: 0.1\n10 20 30 40 50\n-5 15 25 35 45\n";
        let clip = bvh::parse(text.as_bytes(), Path::new("a.bvh")).unwrap().clip;
        let above: Vec<_> = (0..2).map(|f| clip.world_of(1, f)).collect();
        let part = branch(&clip, 2, &above);
        for f in 0..2 {
            let world = clip.world(f);
            assert_eq!((part.world(f)[0], clip.world_of(3, f)), (world[2], world[3]));
        }
    }
}
