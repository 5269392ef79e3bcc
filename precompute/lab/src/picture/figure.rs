//! A body around the joints of the skeleton, for pictures.

use super::colour::{self, Colour};
use super::solid::RoundCone;
use glam::{Quat, Vec3};
use throng_core::{BodyVolume, Joint, NUM_JOINTS, Skeleton};

/// Joint positions of one character at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyFigure {
    /// World positions of the joints (m).
    pub joints: [Vec3; NUM_JOINTS],
    /// World positions of the head's top and the tips of the left and right toes (m).
    pub tips: [Vec3; 3],
}

impl BodyFigure {
    /// Figure from the world position and rotation of every joint; the tips are those of `skeleton`.
    pub fn from_transforms(skeleton: &Skeleton, transforms: &[(Vec3, Quat); NUM_JOINTS]) -> Self {
        let ends = [Joint::Head, Joint::LeftToe, Joint::RightToe].map(|joint| transforms[joint.index()]);
        let tips = std::array::from_fn(|i| ends[i].0 + ends[i].1 * skeleton.tips[i]);
        Self { joints: transforms.map(|t| t.0), tips }
    }

    /// Figure from joint positions alone: the head continues the neck, the toes the feet, level.
    pub fn from_positions(joints: &[Vec3; NUM_JOINTS]) -> Self {
        let at = |j: Joint| joints[j.index()];
        let toe = |foot: Joint, toe: Joint| {
            let d = at(toe) - at(foot);
            at(toe) + 0.07 * Vec3::new(d.x, 0.3 * d.y.min(0.0), d.z).normalize_or_zero()
        };
        let head = at(Joint::Head) + 0.2 * (at(Joint::Head) - at(Joint::UpperChest)).normalize_or(Vec3::Y);
        let tips = [head, toe(Joint::LeftFoot, Joint::LeftToe), toe(Joint::RightFoot, Joint::RightToe)];
        Self { joints: *joints, tips }
    }

    /// World position of one joint (m).
    pub fn joint(&self, joint: Joint) -> Vec3 {
        self.joints[joint.index()]
    }

    /// True where every position can be drawn: finite, and no limb is longer than a body could be.
    pub fn is_drawable(&self) -> bool {
        let hips = self.joints[0];
        self.joints.iter().chain(&self.tips).all(|p| p.is_finite() && p.distance(hips) < 10.0)
    }
}

/// Colours of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyColours {
    /// Pelvis and trunk.
    pub trunk: Colour,
    /// Head and hands.
    pub skin: Colour,
    /// Limbs of the left side.
    pub left: Colour,
    /// Limbs of the right side.
    pub right: Colour,
}

impl Default for BodyColours {
    /// Left and right limbs have different hues, so that a gait can be read.
    fn default() -> Self {
        Self { trunk: colour::BODY, skin: colour::SKIN, left: colour::LEFT, right: colour::RIGHT }
    }
}

impl BodyColours {
    /// These colours mixed with `paper` by `amount` (0 to 1).
    pub fn faded(self, paper: Colour, amount: f32) -> Self {
        let fade = |c: Colour| c.mix(paper, amount);
        Self { trunk: fade(self.trunk), skin: fade(self.skin), left: fade(self.left), right: fade(self.right) }
    }

    /// Shades of one colour: the sides differ a little in lightness.
    pub fn plain(base: Colour) -> Self {
        let [white, black] = [0xffffff, 0x000000].map(Colour::hex);
        Self { trunk: base, skin: base.mix(white, 0.45), left: base.mix(white, 0.14), right: base.mix(black, 0.14) }
    }
}

/// The solids of a body and their colours.
pub(super) fn body_solids(figure: &BodyFigure, colours: &BodyColours) -> Vec<(RoundCone, Colour)> {
    let frame = TrunkFrame::from_figure(figure);
    let mut out = Vec::with_capacity(32);
    trunk(figure, &frame, colours.trunk, &mut out);
    head(figure, &frame, colours, &mut out);
    arm(figure, [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand], colours.left, colours.skin, &mut out);
    arm(figure, [Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand], colours.right, colours.skin, &mut out);
    let left = [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot, Joint::LeftToe];
    let right = [Joint::RightThigh, Joint::RightShin, Joint::RightFoot, Joint::RightToe];
    leg(figure, left, figure.tips[1], colours.left, &mut out);
    leg(figure, right, figure.tips[2], colours.right, &mut out);
    out
}

/// Unit directions of the trunk.
struct TrunkFrame {
    chest_left: Vec3,
    chest_front: Vec3,
    pelvis_left: Vec3,
}

impl TrunkFrame {
    fn from_figure(f: &BodyFigure) -> Self {
        let spine = (f.joint(Joint::Neck) - f.joint(Joint::Hips)).normalize_or(Vec3::Y);
        let across = |left: Joint, right: Joint| (f.joint(left) - f.joint(right)).normalize_or(Vec3::X);
        let chest_left = across(Joint::LeftUpperArm, Joint::RightUpperArm);
        let chest_front = chest_left.cross(spine).normalize_or(Vec3::Z);
        Self { chest_left, chest_front, pelvis_left: across(Joint::LeftThigh, Joint::RightThigh) }
    }
}

/// A share of the radius that the volume of bodies has at a joint: trunks are wider than deep, limbs thinner at their ends (m).
fn thickness(joint: Joint, share: f32) -> f32 {
    share * BodyVolume::radius_m(joint)
}

/// Adds pelvis, belly, rib cage and shoulders, all wider than deep.
fn trunk(f: &BodyFigure, frame: &TrunkFrame, colour: Colour, out: &mut Vec<(RoundCone, Colour)>) {
    let at = |j| f.joint(j);
    let mut add = |solid: RoundCone| out.push((solid, colour));
    let (hips, spine, chest, upper) = (at(Joint::Hips), at(Joint::Spine), at(Joint::Chest), at(Joint::UpperChest));
    let crotch = hips.lerp(0.5 * (at(Joint::LeftThigh) + at(Joint::RightThigh)), 0.7);
    let front = 0.012 * frame.chest_front;
    let (waist, ribs) = (thickness(Joint::Spine, 0.82), thickness(Joint::Chest, 0.83));
    add(RoundCone::limb(crotch, spine, thickness(Joint::Hips, 0.88), waist).flattened(frame.pelvis_left, 1.5));
    add(RoundCone::limb(spine, chest, waist, ribs).flattened(frame.pelvis_left, 1.36));
    let neck = at(Joint::Neck);
    let chest_top = thickness(Joint::UpperChest, 0.9);
    add(RoundCone::limb(chest + front, upper.lerp(neck, 0.3) + front, ribs, chest_top)
        .flattened(frame.chest_left, 1.42));
    for shoulder in [at(Joint::LeftUpperArm), at(Joint::RightUpperArm)] {
        let inner = upper.lerp(neck, 0.55);
        add(RoundCone::limb(inner, shoulder, thickness(Joint::UpperChest, 0.68), thickness(Joint::LeftClavicle, 1.2)));
        let [near, far] = [1.0, 0.85].map(|share| thickness(Joint::LeftClavicle, share));
        add(RoundCone::limb(neck, shoulder.lerp(inner, 0.12), near, far));
    }
}

/// Adds neck, skull, and a visor that shows where the face is.
fn head(f: &BodyFigure, frame: &TrunkFrame, colours: &BodyColours, out: &mut Vec<(RoundCone, Colour)>) {
    let (neck, head, top) = (f.joint(Joint::Neck), f.joint(Joint::Head), f.tips[0]);
    let up = (top - head).normalize_or(Vec3::Y);
    let left = (frame.chest_left - up * frame.chest_left.dot(up)).normalize_or(Vec3::X);
    let front = left.cross(up);
    let size = (top - head).length().clamp(0.08, 0.4) / 0.2;
    out.push((
        RoundCone::limb(neck - 0.03 * up, head + 0.02 * up, thickness(Joint::Neck, 0.93), thickness(Joint::Neck, 0.87)),
        colours.skin,
    ));
    let crown = head + up * (0.115 * size) + front * (0.012 * size);
    let jaw = head + up * (0.04 * size) + front * (0.035 * size);
    out.push((
        RoundCone::limb(crown, jaw, thickness(Joint::Head, size), thickness(Joint::Head, 0.62 * size))
            .flattened(left, 0.84),
        colours.skin,
    ));
    let brow = head + up * (0.085 * size) + front * (0.094 * size);
    let visor = RoundCone::limb(brow + left * (0.03 * size), brow - left * (0.03 * size), 0.023 * size, 0.023 * size);
    out.push((visor, colours.trunk.mix(colour::INK, 0.75)));
}

fn arm(f: &BodyFigure, joints: [Joint; 3], colour: Colour, skin: Colour, out: &mut Vec<(RoundCone, Colour)>) {
    let [shoulder, elbow, wrist] = joints.map(|j| f.joint(j));
    let [upper, fore, hand] = joints.map(BodyVolume::radius_m);
    out.push((RoundCone::limb(shoulder, elbow, 1.1 * upper, fore), colour));
    out.push((RoundCone::limb(elbow, wrist, fore, 0.7 * hand), colour));
    let along = (wrist - elbow).normalize_or(-Vec3::Y);
    out.push((RoundCone::limb(wrist + 0.025 * along, wrist + 0.105 * along, 0.83 * hand, 0.62 * hand), skin));
}

/// Adds thigh, shin with calf, and a wedge-shaped foot: high at the ankle, flat at the tip.
fn leg(f: &BodyFigure, joints: [Joint; 4], tip: Vec3, colour: Colour, out: &mut Vec<(RoundCone, Colour)>) {
    let [hip, knee, ankle, ball] = joints.map(|j| f.joint(j));
    let [thigh, shin, foot, toe] = joints.map(BodyVolume::radius_m);
    out.push((RoundCone::limb(hip, knee, 1.1 * thigh, shin), colour));
    out.push((RoundCone::limb(knee, ankle, shin, 1.1 * foot), colour));
    let down = (ankle - knee).normalize_or(-Vec3::Y);
    let sole = (ball - ankle).normalize_or(Vec3::Z);
    let back = (sole - down * sole.dot(down)).normalize_or(Vec3::Z);
    let [high, low] = [knee + down * 0.1 - back * 0.016, knee + down * 0.2 - back * 0.012];
    out.push((RoundCone::limb(high, low, shin, 0.85 * shin), colour));
    let shoe = colour.mix(colour::INK, 0.42);
    let up = (back - sole * back.dot(sole)).normalize_or(Vec3::Y);
    let heel = ankle - sole * 0.035 - up * 0.012;
    out.push((RoundCone::limb(ankle, heel, 1.25 * foot, 1.2 * foot), shoe));
    out.push((RoundCone::limb(ankle, ball, 1.25 * foot, foot), shoe));
    out.push((RoundCone::limb(heel, ball, 1.1 * foot, foot), shoe));
    out.push((RoundCone::limb(ball, tip, foot, 1.1 * toe), shoe));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standing_body_covers_its_joints_and_stands_on_the_ground() {
        let skeleton = Skeleton::default();
        let figure = BodyFigure::from_positions(&skeleton.rest_positions());
        let solids = body_solids(&figure, &BodyColours::default());
        for joint in Joint::ALL {
            let p = figure.joint(joint);
            let from = p - Vec3::Z * 3.0;
            let covered = solids.iter().any(|(s, _)| s.intersect(from, Vec3::Z).is_some_and(|h| h.distance < 3.01));
            assert!(covered, "{}", joint.name());
        }
        let top =
            solids.iter().filter_map(|(s, _)| s.intersect(figure.tips[0] + Vec3::Y, -Vec3::Y)).map(|h| h.distance);
        assert!(top.fold(9.0, f32::min) < 1.03);
    }

    #[test]
    fn tips_from_transforms_follow_the_rotation() {
        let skeleton = Skeleton::default();
        let q = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
        let transforms = skeleton.rest_positions().map(|p| (q * p, q));
        let f = BodyFigure::from_transforms(&skeleton, &transforms);
        let toe = f.tips[1] - f.joint(Joint::LeftToe);
        assert!((toe - Vec3::X * 0.07).length() < 1e-5);
        assert!(f.is_drawable());
        assert!(!BodyFigure::from_positions(&[Vec3::NAN; NUM_JOINTS]).is_drawable());
    }
}
