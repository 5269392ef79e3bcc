//! Meaning of the name of a joint: its side, the part of the body, or that it plays no role.
//!
//! Names are in the conventions of many tools and languages. They confirm what the shape of a skeleton says, and
//! decide where it says nothing.

use super::super::profile::plain;
use crate::side::LateralSide;

/// A part of the body that a name may mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum NamedPart {
    Hips,
    Spine,
    Neck,
    Head,
    Clavicle,
    UpperArm,
    Forearm,
    Hand,
    Thigh,
    Shin,
    Foot,
    Toe,
}

use NamedPart::*;

/// Words for the parts, without sides and separators. Many mean one part in one convention and its neighbour in
/// another: then they name both. Of words as long as each other, the last one counts.
const WORDS: &[(&[NamedPart], &str)] = &[
    (&[Hips], "hips pelvis"),
    (&[Hips, Thigh], "hip"),
    (&[Hips], "becken"),
    (&[Hips, Thigh], "huefte hüfte"),
    (&[Hips], "下半身 腰"),
    (&[Spine], "spine chest thorax torso waist abdomen ab lowerback upperback back ribs wirbelsaeule wirbelsäule"),
    (&[Spine], "ruecken rücken bauch brust brustkorb 上半身"),
    (&[Neck], "neck hals nacken 首"),
    (&[Head], "head skull kopf 頭"),
    (&[Clavicle], "clavicle clav collar collarbone scapula"),
    (&[Clavicle, UpperArm], "shoulder"),
    (&[Clavicle], "schluesselbein schlüsselbein"),
    (&[Clavicle, UpperArm], "schulter"),
    (&[Clavicle], "肩"),
    (&[UpperArm], "upperarm uparm uarm armupper humerus shldr bicep oberarm arm 腕"),
    (&[Forearm], "forearm lowerarm lowarm farm larm armlower radius elbow unterarm ellbogen ひじ 肘"),
    (&[Hand], "hand wrist palm handgelenk 手首 手"),
    (&[Thigh], "thigh femur upleg upperleg uleg legupper oberschenkel"),
    (&[Thigh, Shin], "leg bein"),
    (&[Shin], "shin calf tibia lowerleg lowleg lleg leglower knee crus unterschenkel knie ひざ 膝"),
    (&[Foot, Toe], "foot"),
    (&[Foot], "ankle"),
    (&[Foot, Toe], "fuss fuß"),
    (&[Foot], "knoechel knöchel 足首"),
    (&[Thigh], "足"),
    (&[Toe], "toe toes toebase ball zehe zehen fussballen つま先 足先"),
];

/// Words of joints that play no role, wherever they stand in a name.
const LEFT_OUT: &str = "\
    twist thumb index finger dummy nub helper pinky weapon sword prop effector eye jaw teeth tongue hair brow \
    eyelid breast pectoral skirt daumen zeige mittelfinger ringfinger auge kiefer share metacarpal 捩 指 髪 目 \
    スカート ＩＫ buttock gluteus camera holster shield staff waffe muscle";
/// Words of joints that play no role where they stand alone between separators.
const LEFT_OUT_ALONE: &str = "\
    roll ik ring middle little end site tip top pole target ctrl gun rifle lip cheek ear nose bust cape bag \
    klein attach socket marker goal face";
/// Words of tools and rigs that say nothing.
const NOISE: &str = "\
    bip def bone cc base jnt joint mch org rig skel sk bn jt mixamorig character bend biped";

/// All words, each with the parts that it may mean.
fn words() -> impl Iterator<Item = (&'static str, &'static [NamedPart])> {
    WORDS.iter().flat_map(|&(parts, words)| words.split(' ').map(move |word| (word, parts)))
}

/// Meaning of a name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Label {
    /// The side it names.
    pub side: Option<LateralSide>,
    /// The parts it may mean, by bit; 0 where it names none.
    parts: u16,
    /// True where the name is the word of the part and nothing else.
    pub exact: bool,
    /// True where it names a finger, a twist joint, a prop or another thing that plays no role.
    pub left_out: bool,
}

impl Label {
    /// Takes a name apart.
    pub fn from_name(name: &str) -> Self {
        let name = plain(name);
        let words = split_words(name);
        let lower = words.concat();
        let left_out = (words.iter().any(|w| LEFT_OUT_ALONE.split(' ').any(|l| l == w)) && !lower.contains("spine"))
            || LEFT_OUT.split(' ').any(|l| lower.contains(&l.to_lowercase()) || name.contains(l));
        let (mut side, mut rest) = (None, String::new());
        for w in words {
            match side_of(&w) {
                Some(s) if side.is_none() => side = Some(s),
                _ if NOISE.split(' ').any(|n| n == w) => {}
                _ => rest.push_str(&w),
            }
        }
        if side.is_none() {
            (side, rest) = glued_side(rest);
        }
        let found = find_word(&rest);
        let parts = found.map_or(0, |(_, parts)| parts.iter().fold(0, |bits, &p| bits | 1 << p as u8));
        // Necks of two joints are called twist joints, too.
        let left_out = left_out && !(lower.contains("neck") && lower.contains("twist"));
        Self { side, parts, exact: found.is_some_and(|(word, _)| word == rest), left_out }
    }

    /// True where the name may mean the part.
    pub fn may_be(self, part: NamedPart) -> bool {
        self.parts & (1 << part as u8) != 0
    }

    /// True where the name is a word of the part, and of no other one.
    pub fn is_exactly(self, part: NamedPart) -> bool {
        self.exact && self.parts == 1 << part as u8
    }

    /// True where the name means some part of the body.
    pub fn names_a_part(self) -> bool {
        self.parts != 0
    }

    /// Agreement of the name with a part: 1 yes, -0.5 no, 0 says nothing.
    pub fn agreement(self, part: NamedPart) -> f32 {
        match (self.may_be(part), self.names_a_part()) {
            (true, _) => 1.0,
            (false, true) => -0.5,
            (false, false) => 0.0,
        }
    }
}

/// The longest word that a name is or contains.
fn find_word(rest: &str) -> Option<(&'static str, &'static [NamedPart])> {
    let known = |(word, _): &(&str, _)| word.chars().count() > 2 || !word.is_ascii();
    let within = || words().filter(known).filter(|(word, _)| rest.contains(word)).max_by_key(|(word, _)| word.len());
    words().find(|(word, _)| *word == rest).or_else(within)
}

fn side_of(word: &str) -> Option<LateralSide> {
    match word {
        "left" | "l" | "lt" | "lft" | "links" | "linke" | "linker" | "linkes" | "li" | "左" => Some(LateralSide::Left),
        "right" | "r" | "rt" | "rgt" | "rechts" | "rechte" | "rechter" | "rechtes" | "re" | "右" => {
            Some(LateralSide::Right)
        }
        _ => None,
    }
}

/// A side that is written without a break: `lfemur`, `leftarm`, `左腕`.
fn glued_side(part: String) -> (Option<LateralSide>, String) {
    const PREFIXES: [(LateralSide, &[&str]); 6] = [
        (LateralSide::Left, &["left"]),
        (LateralSide::Right, &["right"]),
        (LateralSide::Left, &["linker", "linkes", "linke", "links"]),
        (LateralSide::Right, &["rechter", "rechtes", "rechte", "rechts"]),
        (LateralSide::Left, &["左"]),
        (LateralSide::Right, &["右"]),
    ];
    for (side, words) in PREFIXES {
        let rest = words.iter().find_map(|word| part.strip_prefix(word).or_else(|| part.strip_suffix(word)));
        if let Some(rest) = rest {
            return (Some(side), rest.to_owned());
        }
    }
    for (letter, side) in [("l", LateralSide::Left), ("r", LateralSide::Right)] {
        let Some(rest) = part.strip_prefix(letter) else { continue };
        // `larm` may be a lower arm as well; `lradius` has a side.
        if words().any(|(word, _)| word == rest) && !words().any(|(word, _)| word == part && word.len() > 4) {
            return (Some(side), rest.to_owned());
        }
    }
    (None, part)
}

/// Words of a name, in lower case: `Idle_03` and `WalkBack` are `idle`, `walk`, `back`.
pub fn split_words(name: &str) -> Vec<String> {
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
    fn names_of_many_conventions_come_apart_into_side_and_part() {
        let (l, r) = (Some(LateralSide::Left), Some(LateralSide::Right));
        for (name, side, part) in [
            ("LeftUpLeg", l, Thigh),
            ("Bip01 R Thigh", r, Thigh),
            ("upperarm_l", l, UpperArm),
            ("thigh.R", r, Thigh),
            ("lfemur", l, Thigh),
            ("lradius", l, Forearm),
            ("RKnee", r, Shin),
            ("rig:Spine2", None, Spine),
            ("CC_Base_L_Upperarm", l, UpperArm),
            ("CC_Base_R_Calf", r, Shin),
            ("lShldr", l, UpperArm),
            ("rCollar", r, Clavicle),
            ("lShldrBend", l, UpperArm),
            ("LUArm", l, UpperArm),
            ("RFArm", r, Forearm),
            ("DEF-upper_arm.L", l, UpperArm),
            ("左腕", l, UpperArm),
            ("右ひざ", r, Shin),
            ("左足首", l, Foot),
            ("左足", l, Thigh),
            ("上半身2", None, Spine),
            ("Oberschenkel_L", l, Thigh),
            ("RechterUnterarm", r, Forearm),
            ("linke Hüfte", l, Hips),
            ("mixamorig:LeftToeBase", l, Toe),
            ("HEad", None, Head),
        ] {
            let n = Label::from_name(name);
            assert!(n.side == side && n.may_be(part) && !n.left_out, "{name}: {n:?}");
        }
    }

    #[test]
    fn fingers_twists_props_and_ends_play_no_role() {
        for name in [
            "LeftForeArmTwist",
            "Bip01 L Finger0",
            "LeftHandIndex1",
            "CC_Base_L_ThighTwist01",
            "ik_foot_l",
            "HeadTop_End",
            "Bip01 Prop1",
            "左親指１",
            "左足ＩＫ",
            "腕捩",
            "LeftUpLegRoll",
            "rButtock",
            "lThumb1",
            "sword",
        ] {
            assert!(Label::from_name(name).left_out, "{name}");
        }
        for name in ["Bone00", "joint12", "Hips", "LeftHand", "Spine1", "Reference", "LeftToeBase", "Ringo"] {
            assert!(!Label::from_name(name).left_out, "{name}");
        }
        assert!(
            !Label::from_name("Bone00").names_a_part()
                && Label::from_name("Bone_L.003").side == Some(LateralSide::Left)
        );
    }
}
