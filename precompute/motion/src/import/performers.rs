//! Several performers in one hierarchy: each becomes a clip of its own.

use super::roles;
use super::source::{SourceClip, duplicate_names};
use crate::raw::{RawClip, RawJoint};

/// A body has at least so many joints, ends of chains not counted.
const LEAST_JOINTS: usize = 10;

/// The clips of all performers of a file: of each root, or each branch below one, that is a body by itself.
///
/// - returns the clip as it is where there is no more than one.
pub(super) fn apart(source: SourceClip) -> Vec<SourceClip> {
    let bodies: Vec<RawClip> = branches(&source.clip.joints)
        .into_iter()
        .map(|root| branch(&source.clip, root))
        .filter(|clip| roles::assign(clip, &[], None).is_ok())
        .collect();
    if bodies.len() < 2 {
        return vec![source];
    }
    let names: Vec<String> = bodies.iter().map(|b| b.joints[0].name.replace(['/', '\\'], "_")).collect();
    let is_taken = |i: usize| names.iter().filter(|n| **n == names[i]).count() > 1;
    let count = bodies.len();
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

/// The roots, or else the uppermost joints that hang on one joint, where two or more of them carry joints enough for a body.
fn branches(joints: &[RawJoint]) -> Vec<usize> {
    let mut size: Vec<usize> = joints.iter().map(|j| usize::from(!j.is_end)).collect();
    for j in (0..joints.len()).rev() {
        if let Some(p) = joints[j].parent {
            size[p] += size[j];
        }
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

/// What hangs on a joint, which becomes the root.
fn branch(clip: &RawClip, root: usize) -> RawClip {
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
            // What is above the root moves it.
            let (at, turn) = if j == root && clip.joints[root].parent.is_some() {
                clip.world(f)[root]
            } else {
                (clip.translations[f * n + j], clip.rotations[f * n + j])
            };
            out.translations.push(at);
            out.rotations.push(turn);
        }
    }
    out
}
