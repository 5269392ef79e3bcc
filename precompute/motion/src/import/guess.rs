//! Guesses roles from joint names and topology, for skeletons that no profile fits.
//!
//! Limb joints are found by name: a side (`Left`, `l_`, `_R`, ...) and a word for the part. What remains follows
//! from topology: the hips are where the legs meet, the chest is where the arms meet, the spine lies between.

use super::profile::plain;
use super::roles::RoleMap;
use crate::raw::RawJoint;
use throng_core::{Joint, NUM_JOINTS};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Left,
    Right,
    Middle,
}

/// A joint's name taken apart.
struct Name {
    side: Side,
    /// Lower case, without side, digits and separators.
    part: String,
}

/// Words for the parts of a limb, best first. A word may serve two parts: the first part takes it.
const LEG: [(Joint, &[&str]); 4] = [
    (Joint::LeftShin, &["shin", "calf", "tibia", "lowerleg", "lowleg", "leglower", "knee", "leg"]),
    (Joint::LeftThigh, &["thigh", "femur", "upleg", "upperleg", "legupper", "hip", "leg"]),
    (Joint::LeftFoot, &["ankle", "foot"]),
    (Joint::LeftToe, &["toebase", "toes", "toe", "ball", "foot"]),
];
const ARM: [(Joint, &[&str]); 4] = [
    (Joint::LeftForearm, &["forearm", "lowerarm", "lowarm", "armlower", "radius", "elbow"]),
    (Joint::LeftUpperArm, &["upperarm", "uparm", "armupper", "humerus", "arm", "shoulder"]),
    (Joint::LeftClavicle, &["clavicle", "collarbone", "collar", "scapula", "shoulder"]),
    (Joint::LeftHand, &["wrist", "hand"]),
];
const HIPS: &[&str] = &["hips", "pelvis", "hip", "root"];
/// Parts of names of joints that never play a role.
const IGNORED: [&str; 10] = ["twist", "roll", "thumb", "index", "finger", "dummy", "nub", "helper", "ik", "pinky"];

/// Maps what can be mapped; roles without a candidate stay empty.
pub(super) fn guess(joints: &[RawJoint]) -> RoleMap {
    let names: Vec<Option<Name>> = joints.iter().map(|j| if j.is_end { None } else { take_apart(&j.name) }).collect();
    let mut map = RoleMap { joints: [None; NUM_JOINTS], profile: RoleMap::GUESSED.into(), warnings: Vec::new() };
    for limb in [LEG, ARM] {
        for (role, words) in limb {
            for (side, role) in [(Side::Left, role), (Side::Right, role.mirrored())] {
                let taken = map.joints;
                let free = |i: usize| !taken.contains(&Some(i));
                map.joints[role.index()] = find(&names, side, words, free);
            }
        }
    }
    guess_trunk(joints, &names, &mut map);
    let pairs: Vec<_> = map.pairs(joints).map(|(role, joint)| format!("{}={joint}", role.name())).collect();
    map.warnings.push(format!(
        "no skeleton profile fits, so roles were guessed from names and topology: {}. Check them, and write a \
         profile where they are wrong (data/skeletons/README.md).",
        pairs.join(" ")
    ));
    map
}

/// The first joint, parents first, with the best of the words.
fn find(names: &[Option<Name>], side: Side, words: &[&str], free: impl Fn(usize) -> bool) -> Option<usize> {
    let is = |name: &Option<Name>, word: &str| {
        name.as_ref().is_some_and(|n| n.side == side && n.part.eq_ignore_ascii_case(word))
    };
    words.iter().find_map(|word| (0..names.len()).find(|&i| free(i) && is(&names[i], word)))
}

fn guess_trunk(joints: &[RawJoint], names: &[Option<Name>], map: &mut RoleMap) {
    use Joint::*;
    let any = |_: usize| true;
    let head = find(names, Side::Middle, &["head"], any);
    let neck = find(names, Side::Middle, &["neck", "lowerneck", "neckbase"], any);
    let meet = |a: Option<usize>, b: Option<usize>| Some(meeting(joints, a?, b?)).flatten();
    let legs = meet(map.get(LeftThigh), map.get(RightThigh));
    let named = find(names, Side::Middle, HIPS, any);
    let hips = named.filter(|&h| legs.is_some_and(|l| path_up(joints, l).contains(&h))).or(legs);
    let chest = meet(map.get(LeftUpperArm), map.get(RightUpperArm));
    (map.joints[Hips.index()], map.joints[Neck.index()], map.joints[Head.index()]) = (hips, neck, head);
    let (Some(hips), Some(chest)) = (hips, chest) else { return };
    // From the chest down to the hips, which are left out.
    let up = path_up(joints, chest);
    let Some(below) = up.iter().position(|&j| j == hips) else { return };
    let mut spine: Vec<usize> = up[..below].to_vec();
    spine.reverse();
    match spine.as_slice() {
        [] => {}
        [only] => map.joints[UpperChest.index()] = Some(*only),
        [first, middle @ .., last] => {
            map.joints[Spine.index()] = Some(*first);
            map.joints[Chest.index()] = middle.get(middle.len() / 2).copied();
            map.joints[UpperChest.index()] = Some(*last);
        }
    }
}

/// A joint and its ancestors, nearest first.
fn path_up(joints: &[RawJoint], joint: usize) -> Vec<usize> {
    std::iter::successors(Some(joint), |&j| joints[j].parent).collect()
}

/// The nearest common ancestor.
fn meeting(joints: &[RawJoint], a: usize, b: usize) -> Option<usize> {
    let above = path_up(joints, a);
    path_up(joints, b).into_iter().find(|j| above.contains(j))
}

/// Splits a name into side and part; `None` for joints that never play a role.
fn take_apart(name: &str) -> Option<Name> {
    let mut words = split_words(plain(name));
    let mut side = Side::Middle;
    words.retain(|w| {
        let found = match w.as_str() {
            "left" | "l" => Side::Left,
            "right" | "r" => Side::Right,
            _ => return true,
        };
        side = found;
        false
    });
    let mut part: String = words.into_iter().filter(|w| w != "bip" && w != "def" && w != "bone").collect();
    if IGNORED.iter().any(|i| part == *i || (i.len() > 2 && part.contains(i))) {
        return None;
    }
    if side == Side::Middle {
        (side, part) = glued_side(part);
    }
    Some(Name { side, part })
}

/// A side that is written without a break: `lfemur`, `leftarm`.
fn glued_side(part: String) -> (Side, String) {
    for (prefix, side) in [("left", Side::Left), ("right", Side::Right), ("l", Side::Left), ("r", Side::Right)] {
        let Some(rest) = part.strip_prefix(prefix) else { continue };
        if LEG.iter().chain(&ARM).any(|(_, words)| words.contains(&rest)) {
            return (side, rest.to_owned());
        }
    }
    (Side::Middle, part)
}

/// Words at separators, digits and changes from lower to upper case, in lower case.
fn split_words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    for c in name.chars() {
        let breaks = !c.is_alphabetic();
        if breaks || (c.is_uppercase() && was_lower) {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| !breaks) {
            word.extend(c.to_lowercase());
        }
        was_lower = c.is_lowercase();
    }
    words.retain(|w| !w.is_empty());
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_apart_into_side_and_part() {
        for (name, side, part) in [
            ("LeftUpLeg", Side::Left, "upleg"),
            ("Bip01 R Thigh", Side::Right, "thigh"),
            ("upperarm_l", Side::Left, "upperarm"),
            ("thigh.R", Side::Right, "thigh"),
            ("lfemur", Side::Left, "femur"),
            ("RKnee", Side::Right, "knee"),
            ("rig:Spine2", Side::Middle, "spine"),
            ("root", Side::Middle, "root"),
        ] {
            let n = take_apart(name).unwrap();
            assert_eq!((n.side, n.part.as_str()), (side, part), "{name}");
        }
        assert!(take_apart("LeftForeArmTwist").is_none());
    }
}
