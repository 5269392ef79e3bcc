//! Bodies that differ from one another, in proportions and in the colours of clothes.
//!
//! Only the drawn bodies differ. Feet stay at their simulated positions: legs are longer or shorter between them and
//! the hips, which are raised or lowered, so that feet do not slide. Trunk, arms and shoulders keep their rotations,
//! with the lengths of the varied body.

use super::StageLayout;
use super::body::{self, Stretch, body_of_pose};
use crate::render::{BodyStyle, Rgba};
use crate::{document::UserOutfit, model::Model, settings::Colouring};
use glam::{Quat, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use rayon::prelude::*;
use std::ops::Range;
use throng_core::{Joint, Mat3x4, NUM_JOINTS, Skeleton};
use throng_precompute::retarget::BodyFit;

/// Number of different bodies.
const NUM_BODIES: usize = 48;
/// The bodies are drawn with this seed.
const SEED: u64 = 7;
/// Over the length that the database skeleton has: legs, trunk, arms, width of the shoulders, thickness.
const LEGS: Range<f32> = 0.95..1.05;
const TRUNK: Range<f32> = 0.93..1.07;
const ARMS: Range<f32> = 0.96..1.04;
const SHOULDERS: Range<f32> = 0.92..1.08;
const GIRTH: Range<f32> = 0.9..1.16;
/// Colours of shirts, where these tell nothing.
const SHIRTS: [u32; 12] = [
    0x7c8fa6, 0xa65f4e, 0x5f7f63, 0xc9b28a, 0x4c566a, 0x9c7aa0, 0xd0d3d8, 0x86633f, 0x5b8ca0, 0xb08d3c, 0x6d3f46,
    0x3f5d52,
];

/// Bodies of one database skeleton.
#[derive(Default)]
pub struct BodyVariants {
    database: Skeleton,
    bodies: Vec<BodyVariant>,
}

/// A body.
struct BodyVariant {
    skeleton: Skeleton,
    fit: BodyFit,
    stretch: Stretch,
    /// Difference in height of the hips (m).
    rise: f32,
}

/// Bits that differ from character to character, by its number alone.
fn bits(character: usize) -> u64 {
    let mut z = (character as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// By which a shader chooses colours of skin, trousers and shoes; never 0.
pub(super) fn look_bits(character: usize) -> u32 {
    (bits(character) >> 32) as u32 | 1 << 31
}

/// True where bodies differ: capsules show poses as they are.
pub(super) fn is_wanted(model: &Model) -> bool {
    model.settings.varied && model.settings.body != BodyStyle::Capsules && !model.shows_clip() && !model.shows_blend()
}

/// Colour of a character: its shirt colour if colours have no meaning.
pub(super) fn shirt_or_plain(model: &Model, character: usize, plain: Rgba) -> Rgba {
    let is_shirt = is_wanted(model) && model.settings.colouring == Colouring::Plain;
    if is_shirt { Rgba::hex(SHIRTS[(bits(character) >> 8) as usize % SHIRTS.len()]) } else { plain }
}

impl BodyVariants {
    fn for_skeleton(database: &Skeleton) -> Self {
        let mut rng = Pcg32::seed_from_u64(SEED);
        let bodies = (0..NUM_BODIES).map(|_| BodyVariant::draw(database, &mut rng)).collect();
        Self { database: database.clone(), bodies }
    }

    fn body(&self, character: usize) -> Option<&BodyVariant> {
        self.bodies.get(bits(character) as usize % NUM_BODIES)
    }
}

impl BodyVariant {
    fn draw(database: &Skeleton, rng: &mut Pcg32) -> Self {
        let [legs, trunk, arms, shoulders, girth] =
            [LEGS, TRUNK, ARMS, SHOULDERS, GIRTH].map(|range| rng.random_range(range));
        let mut skeleton = database.clone();
        for joint in Joint::ALL {
            use Joint::*;
            skeleton.offsets[joint.index()] *= match joint {
                LeftShin | RightShin | LeftFoot | RightFoot => legs,
                Spine | Chest | UpperChest | Neck => trunk,
                LeftClavicle | RightClavicle | LeftUpperArm | RightUpperArm => shoulders,
                LeftForearm | RightForearm | LeftHand | RightHand => arms,
                _ => 1.0,
            };
        }
        // Heights of ankles are those of the database.
        let rise = skeleton.leg_length() - database.leg_length();
        skeleton.offsets[Joint::Hips.index()].y += rise;
        let mut stretch = body::stretch(database, &skeleton);
        for (joint, along) in stretch.iter_mut().enumerate() {
            let lengthwise = body::axis_of_limb(database, joint);
            let by = |axis: usize| if lengthwise == Some(axis) { 1.0 } else { girth };
            // Sizes of heads, hands and feet do not vary.
            use Joint::*;
            let is_end =
                [Head, LeftHand, RightHand, LeftFoot, RightFoot, LeftToe, RightToe].contains(&Joint::ALL[joint]);
            *along = if is_end { Vec3::ONE } else { Vec3::new(along.x * by(0), along.y * by(1), along.z * by(2)) };
        }
        Self { fit: BodyFit::from_skeleton(skeleton.clone()), skeleton, stretch, rise }
    }

    /// Joints of this body in a pose of the database skeleton.
    fn pose(&self, database: &Skeleton, pose: &[Mat3x4]) -> [(Vec3, Quat); NUM_JOINTS] {
        let mut own: [(Vec3, Quat); NUM_JOINTS] =
            std::array::from_fn(|j| (pose[j].translation(), pose[j].rotation().normalize()));
        [Joint::LeftThigh, Joint::RightThigh].into_iter().for_each(|thigh| own[thigh.index()].0.y += self.rise);
        let worn = self.fit.wear_pose(database, &own);
        let mut out = [(worn.hips, worn.model[0]); NUM_JOINTS];
        for joint in &Joint::ALL[1..] {
            let (at, turn) = out[joint.parent().map_or(0, Joint::index)];
            out[joint.index()] = (at + turn * self.skeleton.offsets[joint.index()], worn.model[joint.index()]);
        }
        out
    }
}

/// A character as drawn: its joints and skeleton.
#[derive(Debug)]
pub(super) struct DressedBody {
    pub joints: [(Vec3, Quat); NUM_JOINTS],
    pub skeleton: Skeleton,
}

impl StageLayout {
    /// Gives every character its own body.
    pub(super) fn vary(&mut self, model: &Model) {
        self.varied.clear();
        self.dressed.clear();
        if !is_wanted(model) || self.instances.is_empty() {
            return;
        }
        if self.variety.bodies.is_empty() || self.variety.database != self.skeleton {
            self.variety = BodyVariants::for_skeleton(&self.skeleton);
        }
        let mut varied = std::mem::take(&mut self.varied);
        let (poses, drawn, variety) = (self.poses(model), &self.drawn, &self.variety);
        // Other poses have their own bodies already.
        let is_common = |pose: &[Mat3x4]| has_same_legs(&body_of_pose(&self.skeleton, pose), &self.skeleton);
        let number = |i: usize| drawn.get(i).copied().unwrap_or(i);
        let dressed: Vec<Option<DressedBody>> = poses
            .par_chunks_exact(NUM_JOINTS)
            .enumerate()
            .map(|(i, pose)| {
                let body = variety.body(number(i)).filter(|_| is_common(pose))?;
                Some(DressedBody { joints: body.pose(&self.skeleton, pose), skeleton: body.skeleton.clone() })
            })
            .collect();
        for (i, (pose, dressed)) in poses.chunks_exact(NUM_JOINTS).zip(&dressed).enumerate() {
            match (dressed, variety.body(number(i))) {
                (Some(dressed), Some(body)) => {
                    let joints = dressed.joints.map(|(at, turn)| Mat3x4::from_rotation_translation(turn, at));
                    body::push_stretched(&mut varied, &joints, &body.stretch);
                }
                _ => varied.extend(pose),
            }
        }
        for (i, instance) in self.instances.iter_mut().enumerate() {
            instance.look = look_bits(self.drawn.get(i).copied().unwrap_or(i));
        }
        (self.varied, self.dressed) = (varied, dressed);
    }
}

/// Share by which legs may differ from those of the database and still count as the same: a foot lock stretches legs a
/// little.
const SAME_LEGS: f32 = 0.03;

impl StageLayout {
    /// Computes the matrices of the user's mesh for all instances, if there is one.
    pub(super) fn wear(&mut self, model: &Model) {
        let mut worn = std::mem::take(&mut self.worn);
        worn.clear();
        if let Some(outfit) = model.worn_outfit() {
            let num_frames = outfit.figure.num_frames();
            worn.resize(self.instances.len() * num_frames, Mat3x4::default());
            let (poses, instances) = (self.poses(model), worn.par_chunks_exact_mut(num_frames).enumerate());
            instances.for_each(|(i, out)| match self.dressed.get(i) {
                Some(Some(d)) => outfit.figure.pose_matrices(&d.skeleton, &d.joints, out),
                _ => put_on(outfit, &self.skeleton, &poses[i * NUM_JOINTS..][..NUM_JOINTS], out),
            });
        }
        self.worn = worn;
    }
}

fn put_on(outfit: &UserOutfit, database: &Skeleton, pose: &[Mat3x4], out: &mut [Mat3x4]) {
    let own = body_of_pose(database, pose);
    let turned: [(Vec3, Quat); NUM_JOINTS] = std::array::from_fn(|j| (pose[j].translation(), rotation(&pose[j])));
    outfit.figure.pose_matrices(if has_same_legs(&own, database) { database } else { &own }, &turned, out);
}

fn has_same_legs(body: &Skeleton, database: &Skeleton) -> bool {
    (body.leg_length() / database.leg_length() - 1.0).abs() < SAME_LEGS
}

/// Rotation of a joint; its axes may be scaled, as in bodies of other sizes.
fn rotation(m: &Mat3x4) -> Quat {
    let axis = |i: usize| Vec3::from(m.rows.map(|row| row[i])).normalize_or_zero();
    Quat::from_mat3(&glam::Mat3::from_cols(axis(0), axis(1), axis(2))).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{golden_path, quietly};
    use crate::run::SceneChoice;
    use crate::settings::ViewerSettings;

    const N: usize = 24;

    fn open(varied: bool) -> Model {
        let crowd = SceneChoice { characters: N, ..SceneChoice::default() };
        let mut model =
            Model::new(ViewerSettings { crowd, varied, body: BodyStyle::Mannequin, ..ViewerSettings::default() });
        quietly(|with| model.open_now(&golden_path(), with)).unwrap();
        model
    }

    /// Ankles and toes in the world, as laid out.
    fn feet(layout: &StageLayout, model: &Model) -> Vec<Vec3> {
        use Joint::*;
        let of = |(pose, instance): (&[Mat3x4], &crate::render::CharacterInstance)| {
            let root = instance.root;
            [LeftFoot, RightFoot, LeftToe, RightToe]
                .map(|j| root.rotation() * pose[j.index()].translation() + root.translation())
        };
        layout.poses(model).chunks_exact(NUM_JOINTS).zip(&layout.instances).flat_map(of).collect()
    }

    #[test]
    fn feet_stay_where_the_simulation_has_them() {
        let (mut plain, mut varied) = (open(false), open(true));
        let (mut a, mut b) = (StageLayout::default(), StageLayout::default());
        let mut off = Vec::new();
        let mut before: Option<[Vec<Vec3>; 2]> = None;
        let (mut slips, mut own_slips) = (Vec::new(), Vec::new());
        for _ in 0..240 {
            for model in [&mut plain, &mut varied] {
                model.is_unhurried = true;
                model.advance(&eframe::egui::Context::default(), 1.0 / 60.0);
            }
            a.lay_out(&plain, true);
            b.lay_out(&varied, true);
            let both = [feet(&a, &plain), feet(&b, &varied)];
            off.extend(both[0].iter().zip(&both[1]).map(|(p, q)| p.distance(*q)));
            if let Some(before) = before {
                let speed = |k: usize, i: usize| 60.0 * both[k][i].distance(before[k][i]);
                // What hardly moves in the simulation is on the ground.
                for i in (0..both[0].len()).filter(|&i| speed(0, i) < 0.1) {
                    own_slips.push(speed(0, i));
                    slips.push(speed(1, i));
                }
            }
            before = Some(both);
        }
        let p95 = |all: &mut Vec<f32>| {
            all.sort_by(f32::total_cmp);
            (all[all.len() * 95 / 100], all[all.len() - 1])
        };
        let (off, slip, own) = (p95(&mut off), p95(&mut slips), p95(&mut own_slips));
        println!("feet off {off:?} m; slip drawn {slip:?}, simulated {own:?} m/s (95th percentile, worst)");
        assert!(slips.len() > 1000, "{}", slips.len());
        assert!(off.0 < 0.005 && off.1 < 0.03, "{off:?}");
        assert!(slip.0 < own.0 + 0.03, "{slip:?} {own:?}");
    }

    #[test]
    fn people_differ_and_stay_who_they_are() {
        let model = open(true);
        let (mut a, mut b) = (StageLayout::default(), StageLayout::default());
        a.lay_out(&model, true);
        b.lay_out(&model, false);
        assert_eq!(a.poses(&model), b.poses(&model));
        let head = |c: usize| a.poses(&model)[c * NUM_JOINTS + Joint::Head.index()].translation().y;
        let heads: Vec<f32> = (0..N).map(head).collect();
        let (low, high) = heads.iter().fold((9.0f32, 0.0f32), |(l, h), &y| (l.min(y), h.max(y)));
        assert!(high - low > 0.06 && high - low < 0.35, "{low} to {high} m");
        let looks: std::collections::BTreeSet<u32> = a.instances.iter().map(|i| i.look).collect();
        assert!(looks.len() > N / 2 && !looks.contains(&0));
        // Nothing that is simulated differs.
        let other = open(false);
        let [own, other] = [&model, &other].map(|m| m.document.scene().unwrap().run.simulation());
        assert!(own.poses().eq(other.poses()));
    }
}
